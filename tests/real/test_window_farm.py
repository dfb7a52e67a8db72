# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm in Blender's window: prepared in its dialog, done by the command that is copied, and assembled."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from time import sleep

from tests.real.panel import SHORT, choose, jobs, latest, wait_for_end
from tests.real.window import Window, wait_until

SAVE = 1136, 514  # in Blender's file window, which has no window manager to place it
DRAWN = 3.0  # seconds until a dialog or a window is drawn
WINDOWS = "len(bpy.context.window_manager.windows)"
ASK = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
region = next(region for region in area.regions if region.type == "WINDOW")
with bpy.context.temp_override(window=window, area=area, region=region):
    bpy.ops.radtex.{}("INVOKE_DEFAULT")
"""


def test_a_farm_is_prepared_done_and_assembled_by_clicks(window: Window) -> None:
    choose(window, "Plane", "Suzanne", **SHORT | {"together": "off"})
    window.ask("room.remember('before')")
    window.point(500, 300)
    window.ask(ASK.format("prepare_farm"))
    sleep(DRAWN)
    window.shot("farm-dialog")
    window.key("Return")
    wait_until(lambda: jobs(window), 20, "no job")
    told = wait_for_end(window)
    assert told.state == "done", told.message
    farm = farm_of(window)
    names = [bake["name"] for bake in json.loads((farm / "tasks.json").read_text(encoding="utf-8"))["bakes"]]
    assert names == ["Plane", "Suzanne"]
    assert window.value("room.changes('before')") == []
    window.shot("farm-prepared")

    window.click(*window.find("radtex.assemble_farm("))
    wait_until(lambda: len(jobs(window)) == 2, 20, "no job")
    told = wait_for_end(window)
    assert told.state == "failed"
    assert "2 of 2 tasks are not done" in told.message
    window.shot("farm-unfinished")

    window.click(*window.find("radtex.copy_farm_command("))
    command = shlex.split(str(window.value("bpy.context.window_manager.clipboard")))
    assert command[0] == "blender"
    window.ask("bpy.ops.wm.save_userpref()")  # as Blender does when it is quit: RadTex is enabled
    window.start(command, "work.log")
    done = farm / "done"
    wait_until(lambda: done.is_dir() and len(list(done.glob("*.json"))) == 2, 240, "the farm is not done")
    window.click(*window.find("radtex.assemble_farm("))
    wait_until(lambda: len(jobs(window)) == 3, 20, "no job")
    told = wait_for_end(window)
    assert told.state == "done", told.message
    for name in names:
        assert (farm.parent / f"{name}.radiance.json").is_file()
        assert (farm.parent / f"{name}.preview.blend").is_file()
    window.shot("farm-assembled")


def test_a_farm_that_is_chosen_in_the_file_browser_asks_before_it_replaces(window: Window) -> None:
    sidecar = farm_of(window).parent / "Suzanne.radiance.json"
    before, stamp = len(jobs(window)), sidecar.stat().st_mtime_ns
    window.ask(ASK.format("assemble_farm"))
    wait_until(lambda: window.value(WINDOWS) == 2, 20, "no file browser")
    sleep(DRAWN)
    window.shot("farm-browser")
    params = "bpy.context.window_manager.windows[-1].screen.areas[0].spaces.active.params"
    assert window.value(f"{params}.directory.decode()").rstrip("/").endswith("radtex/room")
    window.ask(f"{params}.directory = {f'{window.inside}/radtex/room/{farm_of(window).name}/'!r}.encode()")
    sleep(DRAWN)
    window.click(*SAVE)
    wait_until(lambda: window.value(WINDOWS) == 1, 20, "the file browser stays")
    sleep(DRAWN)
    window.shot("farm-replaces")
    assert len(jobs(window)) == before, "it asks"
    window.key("r")  # Replace
    wait_until(lambda: len(jobs(window)) == before + 1, 20, "no job")
    wait_for_end(window)
    assert latest(window).state == "done", latest(window).message
    assert sidecar.stat().st_mtime_ns > stamp


def farm_of(window: Window) -> Path:
    return window.folder / "radtex" / "room" / "room.radtex-farm"
