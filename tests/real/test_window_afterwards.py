# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake in Blender's window: exported and compared with Cycles by clicks, without a stall."""

from __future__ import annotations

from time import sleep

import numpy as np

from tests.real.panel import Told, bake, jobs, latest, wait_for_end
from tests.real.window import Window, wait_until

SHARP = {"atlas_layout": "buckets", "texels": 64, "bucket": 12, "samples": 8}
IMAGES = "sorted(image.name for image in bpy.data.images if image.packed_file)"
THREE = ["RadTex Baked", "RadTex Difference", "RadTex Path Traced"]
WINDOWS = "len(bpy.context.window_manager.windows)"
SECONDS_TO_DRAW = 5  # a new window


def test_an_export_is_made_while_the_window_stays_alive(window: Window) -> None:
    bake(window, **SHARP)
    window.ask("room.remember('before')")
    told = asked_for(window, "radtex.export(")
    assert told.state == "done", told.message
    assert list((window.folder / "radtex").glob("*/*.glb"))
    told = asked_for(window, "radtex.export(")
    assert told.state == "done", f"the dialog replaces it: {told.message}"
    assert window.value("room.changes('before')") == []


def test_a_comparison_is_made_while_the_window_stays_alive(window: Window) -> None:
    window.ask("room.remember('before')")
    told = asked_for(window, "radtex.compare(")
    assert told.state == "done", told.message
    assert window.value(IMAGES) == THREE
    assert all(change.startswith("('images") for change in window.value("room.changes('before')"))
    window.click(*window.find(f"radtex.show_comparison(number={told.number})"))
    wait_until(lambda: window.value(WINDOWS) == 2, 10, "no pictures")
    window.point(500, 400)  # Blender draws a window that the mouse comes to
    sleep(SECONDS_TO_DRAW)
    window.shot("compare")
    window.ask("room.close_other_windows()")
    window.key("ctrl+z", over_view=True)
    wait_until(lambda: not window.value("room.changes('before')"), 10, "the pictures are not undone")


def asked_for(window: Window, operator: str) -> Told:
    """Click on an operator's button, and on OK; wait for its job's end, without a second's stall."""
    number = latest(window).number
    window.ask("ticks.clear()")
    window.scroll(30)
    window.click(*window.find(operator))
    window.key("Return")
    wait_until(lambda: jobs(window)[-1].number > number, 20, "no job")
    window.scroll(-30)
    told = wait_for_end(window)
    gaps = np.diff(window.value("ticks"))
    print(
        f"\n{operator}…), {gaps.sum():.0f} s: 99 % of ticks at most {np.percentile(gaps, 99):.3f} s apart, "
        f"all {gaps.max():.3f} s"
    )
    assert gaps.max() < 1
    return told
