# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex in Blender's window: installed, its settings chosen, its buttons pressed, its bakes watched."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.real.root import Root
from tests.real.window import Window, opened, wait_until

WORKER = "--background"
CROSS = 54  # pixels from the sidebar's right edge to the buttons that cancel a job
LONG = {
    "atlas_layout": "buckets",
    "texels": 128,
    "bucket": 8,
    "samples": 16,
}  # half a minute or more on two cores
SHORT = {"atlas_layout": "buckets", "texels": 64, "bucket": 4, "samples": 4}
_PATIENCE = 240.0  # seconds for a bake on a busy machine; after 300 a test counts as hung
_KNOW = """
import sys
panel_state = sys.modules["bl_ext.user_default.radtex.radtex_addon.ui.panel.panel_state"]
"""
_FORGET = """
if bpy.ops.radtex.clear_jobs.poll():
    bpy.ops.radtex.clear_jobs()
states.clear()
"""
_SETTLED = "not bpy.app.timers.is_registered(panel_state._tick)"
_NOTHING_FAILS = f"{_SETTLED} and [found.errors for found in panel_state._cache.found.values()] == [()]"
_RIGHT = 70  # pixels from the sidebar's right edge to the last of the large buttons


@dataclass(frozen=True)
class Told:
    """What the panel knows of a job."""

    number: int
    what: str
    state: str
    fraction: float
    message: str


@contextmanager
def radtex_window(root: Root, archive: Path) -> Iterator[Window]:
    """Blender's window with RadTex installed from the zip, its tab open, and a scene to bake.

    What was said in Python's tracebacks meanwhile is an error.
    """
    with opened(root) as window:
        install(window, archive)
        window.ask(f"room.build({window.inside + '/room.blend'!r})")
        window.show_tab("RadTex")
        yield window
        assert "Traceback" not in window.said(), window.said()


def install(window: Window, archive: Path) -> None:
    """Install the zip and enable it, as dropping it on Blender's window does."""
    shutil.copy(archive, window.folder / "radtex.zip")
    window.ask(
        f"bpy.ops.extensions.package_install_files(filepath={window.inside + '/radtex.zip'!r}, "
        "repo='user_default', enable_on_install=True)"
    )
    window.ask(_KNOW)


def start_again(window: Window, file: str) -> None:
    """Start Blender again after it was quit, with a file of the folder, and enable RadTex."""
    window.start_blender(file, "blender-again.log")
    window.ask("bpy.ops.preferences.addon_enable(module='bl_ext.user_default.radtex')")
    window.ask(_KNOW)


def choose(window: Window, *objects: str, **settings: object) -> None:
    """Select objects, set what the panel shows, and wait until it has thought about it."""
    window.ask(_FORGET)
    for name, value in settings.items():
        window.ask(f"bpy.context.scene.radtex.{name} = {value!r}")
    window.ask(f"room.select(*{objects or ('Suzanne',)!r})")
    wait_until(lambda: window.value(_NOTHING_FAILS), 20, "the panel knows nothing, or sees what would fail")


def press(window: Window) -> None:
    """Click on the panel's large button, the last one if there are two."""
    window.click(*window.find("radtex.bake(", right=_RIGHT))
    wait_until(lambda: jobs(window), 20, "no bake")


def settle(window: Window) -> None:
    """Wait until the panel knows of what has happened."""
    wait_until(lambda: window.value(_SETTLED), 20, "the panel does not settle")


def jobs(window: Window) -> list[Told]:
    """What the panel knows of all jobs."""
    return [Told(*told) for told in window.value("jobs()")]


def latest(window: Window) -> Told:
    """What the panel knows of the job that was added last."""
    return jobs(window)[-1]


def wait_for(window: Window, fraction: float) -> None:
    """Wait until the latest job is that far."""
    wait_until(lambda: latest(window).fraction > fraction, _PATIENCE, f"the bake does not reach {fraction}")


def wait_for_end(window: Window, timeout: float = _PATIENCE) -> Told:
    """Wait until the latest job has ended; what is known of it then."""
    running = {"running", "waiting"}
    wait_until(lambda: latest(window).state not in running, timeout, "the bake does not end")
    return latest(window)


def preview(window: Window, seen: str) -> None:
    """Click on the preview's switch, and wait until that object is seen."""
    window.click(*window.find("radtex.preview_toggle("))
    wait_until(lambda: seen in window.value("room.seen()"), 30, f"{seen} is not seen")


def bake(window: Window, *objects: str, **settings: object) -> None:
    """A bake by a click, to its end."""
    choose(window, *objects, **settings)
    press(window)
    told = wait_for_end(window)
    assert told.state == "done", told.message
