# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex in Blender's window, a test after another: installed, baking by a click, alive meanwhile, previewed.

With RADTEX_FIGURES=docs/figures these tests and those of the other test_window files keep their pictures.
"""

from __future__ import annotations

from time import sleep

import numpy as np

from tests.real.panel import LONG, SHORT, choose, press, preview, settle, wait_for, wait_for_end
from tests.real.window import Window, changed

SECONDS_TO_RENDER = 12
MOST_DRAWN = 5  # times a second: two for progress, and those that Blender adds to load a thumbnail
SECONDS_TO_SMOOTH = 4  # the 3D view's edges, by drawing it several times
COUNT = """
if "drawn" not in globals():
    bpy.types.RADTEX_PT_bake.append(lambda panel, context: drawn.append(panel))
drawn = []
"""
LINE = 180  # pixels from the sidebar's right edge to the beginning of a job's lines
AWAY = 500, 600  # a place in the 3D view
JOB = 1030, 474, 1290, 782  # the sidebar where the panel lists jobs


def test_the_zip_installs(window: Window) -> None:
    addons = window.value("[addon.module for addon in bpy.context.preferences.addons]")
    assert "bl_ext.user_default.radtex" in addons
    origin = window.ask("import importlib.util as u; answer = u.find_spec('xatlas').origin")
    assert origin.startswith(f"{window.inside}/home/extensions/")


def test_the_button_bakes_by_a_click(window: Window) -> None:
    choose(window, **SHORT)
    window.ask("room.remember('before')")
    before = window.shot("panel")
    press(window)
    wait_for(window, 0.1)
    during = window.picture("begun")
    told = wait_for_end(window)
    assert told.state == "done", told.message
    assert {path.name for path in (window.folder / "radtex" / "room").iterdir()} == {
        "Suzanne.radiance.exr",
        "Suzanne.radiance.json",
        "Suzanne.preview.blend",
    }
    after = window.shot("done")
    fractions = [fraction for *_, fraction, _ in window.value("states")]
    assert len(set(fractions)) >= 4
    assert fractions == sorted(fractions)
    assert min(changed(before, during), changed(during, after)) > 0.005
    assert window.value("room.changes('before')") == []


def test_the_map_unfolds_by_a_click_and_folds_by_another(window: Window) -> None:
    window.point(*AWAY)
    settle(window)
    folded = window.picture("folded")
    line = window.find("radtex.fold_map(", right=LINE)
    window.click(*line)
    window.point(*AWAY)
    unfolded = window.shot("map", JOB)
    assert changed(folded, unfolded) > 0.01
    window.click(*line)
    window.point(*AWAY)
    again = window.picture("folded again")
    assert changed(folded.crop(JOB), again.crop(JOB)) < 0.001  # a message may leave the status bar meanwhile


def test_nothing_is_drawn_while_nothing_happens(window: Window) -> None:
    window.point(*AWAY)
    settle(window)
    sleep(SECONDS_TO_SMOOTH)
    window.ask(COUNT)
    sleep(3)
    assert window.value("len(drawn)") == 0


def test_the_window_stays_alive_during_a_long_bake(window: Window) -> None:
    choose(window, **LONG | {"samples": 112}, overwrite=True)
    window.ask(f"{COUNT}\nticks.clear()")
    press(window)
    pressed = int(window.value("len(ticks)"))
    wait_for(window, 0.7)
    window.shot("baking")
    told = wait_for_end(window, 280)
    ticks = window.value("ticks")
    gaps = np.diff(ticks)
    usual, longest = float(np.percentile(gaps, 99)), float(gaps.max())
    print(f"\n{gaps.sum():.0f} s: 99 % of ticks at most {usual:.3f} s apart, all {longest:.3f} s")
    print(f"when the button was pressed and the scene handed over {gaps[:pressed].max():.3f} s")
    drawn = int(window.value("len(drawn)"))
    print(f"the panel was drawn {drawn / gaps.sum():.2f} times a second")
    assert told.state == "done", told.message
    assert ticks[-1] - ticks[pressed] > 60
    assert usual < 0.2
    assert longest < 1
    assert drawn / gaps.sum() < MOST_DRAWN


def test_the_bake_is_shown_and_hidden_by_clicks(window: Window) -> None:
    window.ask("room.remember('before')")
    preview(window, "Suzanne (baked)")
    assert window.value("room.seen()") == ["Plane", "Suzanne (baked)"]
    window.ask("room.shade('CYCLES', 'RENDERED')")
    sleep(SECONDS_TO_RENDER)
    window.shot("preview")
    window.ask("room.shade('BLENDER_EEVEE', 'SOLID')")
    preview(window, "Suzanne")
    assert window.value("room.seen()") == ["Plane", "Suzanne"]
    assert window.value("room.changes('before')") == []
