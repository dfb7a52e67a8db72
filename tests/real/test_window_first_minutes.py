# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The first minutes with RadTex in Blender's window: from the zip to a bake that one looks at, in few clicks.

The clicks are counted, and after each one there is a picture: with RADTEX_FIGURES they are kept.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import pytest

from tests.real.panel import install, latest, wait_for_end
from tests.real.root import Root
from tests.real.window import Window, opened, wait_until

MOST_CLICKS = 8
_SAVE_AS = 1136, 514  # the button in Blender's file window, which has no window manager to place it
_KNOWN = "[str(found.next) for found in panel_state._cache.found.values()]"


@dataclass
class Artist:
    """Clicks with Blender's mouse, and counts."""

    window: Window
    name: str
    clicks: int = 0

    def click(self, x: int, y: int) -> None:
        self.window.click(x, y)
        self.clicks += 1
        self.look()

    def press(self, operator: str) -> None:
        self.click(*self.window.find(operator))

    def open_tab(self) -> None:
        """Open the sidebar by its key and the tab by one click; finding where to click does not count."""
        self.window.show_tab("RadTex")
        self.clicks += 1
        self.look()

    def look(self) -> None:
        self.window.shot(f"first-{self.name}-{self.clicks}")


@pytest.fixture
def fresh(blender_root: Root, window_zip: Path) -> Iterator[Window]:
    """Blender as it starts the first time, RadTex installed from the zip."""
    with opened(blender_root) as window:
        install(window, window_zip)
        yield window
        assert "Traceback" not in window.said(), window.said()


def knows(window: Window, doing: str) -> bool:
    """Whether the panel has found that its button does this."""
    return bool(window.value(_KNOWN) == [doing])


def bakes_and_looks(artist: Artist, seen: str) -> None:
    """Press the button, wait, show the bake, and render the 3D view."""
    window = artist.window
    wait_until(lambda: knows(window, "bake"), 30, "the button is not ready")
    artist.press("radtex.bake(")
    wait_until(lambda: window.value("jobs()"), 20, "no bake")
    told = wait_for_end(window)
    assert told.state == "done", told.message
    wait_until(lambda: knows(window, "replace"), 30, "the panel does not see the bake")
    artist.press("radtex.preview_toggle(")
    wait_until(lambda: seen in window.value("room.seen()"), 30, f"{seen} is not seen")
    window.ask("room.shade('CYCLES', 'RENDERED')")
    artist.look()


def test_the_default_cube_is_baked_and_previewed(fresh: Window) -> None:
    began = monotonic()
    artist = Artist(fresh, "cube")
    artist.open_tab()
    assert knows(fresh, "nothing") or knows(fresh, "bake")
    artist.press("wm.save_as_mainfile(")
    artist.click(*_SAVE_AS)
    wait_until(lambda: fresh.value("bpy.data.filepath"), 10, "the file is not saved")
    bakes_and_looks(artist, "Cube (baked)")
    print(f"\nthe cube: {artist.clicks} clicks, {monotonic() - began:.0f} s from the zip's installation on")
    assert artist.clicks <= MOST_CLICKS


def test_an_object_as_artists_make_them_is_baked_and_previewed(fresh: Window) -> None:
    """Modifiers, three materials, UVs of its own."""
    fresh.ask(f"room.build_lamp({fresh.inside + '/lamp.blend'!r})")
    began = monotonic()
    artist = Artist(fresh, "lamp")
    artist.open_tab()
    bakes_and_looks(artist, "Lamp (baked)")
    told = latest(fresh)
    print(f"\nthe lamp: {artist.clicks} clicks, {monotonic() - began:.0f} s; {told.message}")
    assert artist.clicks <= MOST_CLICKS
    shutil.rmtree(fresh.folder / "radtex")
