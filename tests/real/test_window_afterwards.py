# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake in Blender's window: exported and compared with Cycles by clicks, without a stall."""

from __future__ import annotations

import json
import shutil
from time import sleep
from urllib.error import URLError
from urllib.request import urlopen

import numpy as np
import pytest

from tests.real.panel import Told, bake, choose, jobs, wait_for_end
from tests.real.window import Window, wait_until

SHARP = {"atlas_layout": "buckets", "texels": 64, "bucket": 12, "samples": 8}
IMAGES = "sorted(image.name for image in bpy.data.images if image.packed_file)"
KEPT = "[row.name for row in bpy.context.scene.radtex_exports]"
THREE = ["RadTex Baked", "RadTex Difference", "RadTex Path Traced"]
WINDOWS = "len(bpy.context.window_manager.windows)"
DIALOG = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
region = next(region for region in area.regions if region.type == "WINDOW")
with bpy.context.temp_override(window=window, area=area, region=region):
    bpy.ops.radtex.export("INVOKE_DEFAULT", object="Suzanne", target="{target}", advanced=True)
"""
ESTIMATES = """
import sys
estimates = sys.modules["bl_ext.user_default.radtex.radtex_addon.ui.jobs.estimates"]
"""
BROWSER = """
import webbrowser
webbrowser.register("ours", None, webbrowser.GenericBrowser(["{program}", "%s"]), preferred=True)
"""
SECONDS_TO_DRAW = 5  # a new window


def test_an_export_is_made_while_the_window_stays_alive(window: Window) -> None:
    bake(window, **SHARP)
    window.ask("room.remember('before')")
    told = asked_for(window, "radtex.export(")
    assert told.state == "done", told.message
    assert list((window.folder / "radtex" / "room").glob("*/*.glb"))
    assert window.value("room.changes('before')") == []


def test_the_dialog_is_about_the_object_that_it_was_opened_for(window: Window) -> None:
    window.point(500, 300)
    window.ask("bpy.ops.object.select_all(action='DESELECT')\nroom.step('Deselect')")
    number = last_number(window)
    for target in ("web", "godot", "web"):  # the last replaces the first
        window.ask(DIALOG.format(target=target))
        sleep(SECONDS_TO_DRAW)
        window.key("Return")
        wait_until(lambda: last_number(window) > number, 20, "no job")  # noqa: B023  # called in the loop
        number += 1
        told = wait_for_end(window)
        assert told.state == "done", told.message
    folders = {path.parent.name for path in (window.folder / "radtex" / "room").glob("*/*.glb")}
    assert {"Suzanne.web", "Suzanne.godot"} <= folders


def test_an_export_that_the_dialog_keeps_is_made_again_after_the_next_bake(window: Window) -> None:
    """It is kept as a step to undo."""
    number = last_number(window)
    window.point(500, 300)
    window.ask(DIALOG.format(target="raw").replace("advanced=True", "again=True"))
    sleep(SECONDS_TO_DRAW)
    window.key("Return")
    wait_until(lambda: last_number(window) > number, 20, "no job")
    assert wait_for_end(window).state == "done"
    assert window.value(KEPT) == ["Suzanne"]
    window.key("ctrl+z", over_view=True)
    wait_until(lambda: window.value(KEPT) == [], 10, "it is not undone")
    window.key("ctrl+shift+z", over_view=True)
    wait_until(lambda: window.value(KEPT) == ["Suzanne"], 10, "it is not done again")
    made = window.folder / "radtex" / "room" / "Suzanne.raw" / "Suzanne.export.json"
    before = made.read_text()
    choose(window, **{**SHARP, "texels": 32})
    window.ask("bpy.ops.radtex.bake(object='Suzanne', overwrite=True, overwrite_any=True)")
    wait_until(lambda: made.read_text() != before, 120, "it was not exported again")
    told = wait_for_end(window)
    assert (told.number, told.state) == (number + 3, "done"), told.message


def test_a_page_opens_in_the_browser_once_it_is_exported(window: Window) -> None:
    shutil.rmtree(window.folder / "radtex" / "room" / "Suzanne.web", ignore_errors=True)
    (window.folder / "browser").write_text(f'#!/bin/sh\necho "$1" > {window.inside}/opened\n')
    (window.folder / "browser").chmod(0o755)
    window.ask(BROWSER.format(program=f"{window.inside}/browser"))
    window.ask("bpy.ops.radtex.show_in_browser(object='Suzanne')")
    opened = window.folder / "opened"
    wait_until(lambda: opened.is_file() and opened.read_text().endswith("\n"), 60, "nothing is opened")
    address = opened.read_text().strip()
    with urlopen(f"{address}Suzanne.export.json") as answer:
        assert json.loads(answer.read())["name"] == "Suzanne"
    window.ask("bpy.ops.preferences.addon_disable(module='bl_ext.user_default.radtex')")
    with pytest.raises(URLError):
        urlopen(address)
    window.ask("bpy.ops.preferences.addon_enable(module='bl_ext.user_default.radtex')")


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
    wait_until(lambda: window.value(IMAGES) == [], 10, "the pictures are not undone")
    assert window.value("room.changes('before')") == []


def test_an_estimate_is_made_while_the_window_stays_alive(window: Window) -> None:
    window.ask(f"ticks.clear()\n{ESTIMATES}")
    window.ask("bpy.ops.radtex.estimate()")
    wait_until(lambda: not window.value("estimates.asking()"), 120, "the estimate does not end")
    assert window.value("str(estimates.message())") == "None"
    without_stalls(window, "radtex.estimate(")


def last_number(window: Window) -> int:
    """The number of the job that was added last; 0 if there is none, as after RadTex was enabled again."""
    return max((job.number for job in jobs(window)), default=0)


def without_stalls(window: Window, what: str) -> None:
    """Fail if Blender's main loop stood still for a second since ticks were cleared."""
    gaps = np.diff(window.value("ticks"))
    usual, longest = np.percentile(gaps, 99), gaps.max()
    print(f"\n{what}…), {gaps.sum():.0f} s: 99 % of ticks at most {usual:.3f} s apart, all {longest:.3f} s")
    assert longest < 1


def asked_for(window: Window, operator: str) -> Told:
    """Click on an operator's button, and on OK; wait for its job's end, without a second's stall."""
    number = last_number(window)
    window.ask("ticks.clear()")
    window.scroll(30)
    window.click(*window.find(operator))
    window.key("Return")
    wait_until(lambda: last_number(window) > number, 20, "no job")
    window.scroll(-30)
    told = wait_for_end(window)
    without_stalls(window, operator)
    return told
