# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user must not lose, in Blender's window by mouse and keys: finished bakes, begun ones, moves."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import PIL.Image

from tests.real.panel import (
    CROSS,
    WORKER,
    Told,
    choose,
    jobs,
    latest,
    press,
    preview,
    settle,
    start_again,
    wait_for,
    wait_for_end,
)
from tests.real.window import Window, changed, wait_until

SMALL = {"atlas_layout": "buckets", "texels": 16, "bucket": 4, "samples": 2}
LARGER = {"atlas_layout": "buckets", "texels": 96, "bucket": 8, "samples": 16}  # long enough to find a cross
RIGHT, LEFT = 70, 200  # pixels from the sidebar's right edge to the right and left one of two buttons
AWAY = 500, 600  # a place in the 3D view
NAME, SAVE = (500, 514), (1136, 514)  # in Blender's file window, which has no window manager to place it
PANEL = 1030, 66, 1292, 640
BLUE = 71, 114, 179  # of a dialog's default button
FOUND = "[str(found.next) for found in panel_state._cache.found.values()]"
PATHS = "sorted({bpy.path.abspath(image.filepath) for image in bpy.data.images if image.filepath})"
PLACES = """{
    item.name: [round(value, 3) for value in item.location]
    for item in bpy.data.objects if item.name.startswith("Suzanne")
}"""
BAKED_AT = """[
    round(value, 3)
    for value in list(bpy.data.objects["Suzanne (baked)"].data["radtex_matrix_world"])[3:12:4]
]"""
KNOW = """
import sys
ours = "bl_ext.user_default.radtex.radtex_addon.ui."
jobs_panel, known_jobs = sys.modules[ours + "panel.jobs_panel"], sys.modules[ours + "jobs.jobs"]
job_files, draw_messages = sys.modules[ours + "jobs.job_files"], sys.modules[ours + "panel.draw_messages"]
"""
TITLES = "[jobs_panel.job_title(job) for job in known_jobs.snapshot()]"
FATES = "[str(job_files.fate(job.number)) for job in known_jobs.snapshot()]"
LINES = """[
    str(line) for found in panel_state._cache.found.values()
    for line in (*draw_messages.left_out_of(found), *(other.text for other in found.not_baked))
]"""
CUTTER = """
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, -1, 0.5))
cutter = bpy.context.object
cutter.name, cutter.display_type, cutter.hide_render = "Cutter", "WIRE", True
bpy.data.objects["Suzanne"].modifiers.new("Boolean", "BOOLEAN").object = cutter
bpy.ops.object.empty_add(location=(2, 0, 0))
bpy.ops.object.select_all(action="DESELECT")
room.step("Cutter")
"""


def test_a_copy_saved_beside_a_file_has_bakes_of_its_own(window: Window) -> None:
    open_scene(window, "build", "first.blend")
    choose(window, **SMALL)
    window.key("ctrl+s", over_view=True)  # so that Open Recent knows it
    press(window)
    ends(window)
    first = stamps(window, "first")
    save_as(window, "second.blend")
    assert window.value(FOUND) == ["bake"]
    look(window, "copy-saved")
    ends(window, wait_for_job(window, "radtex.bake("))
    assert stamps(window, "first") == first
    assert {name: facts(window, name)["blend"] for name in ("first", "second")} == {
        "first": "first.blend",
        "second": "second.blend",
    }
    look(window, "copy-baked")

    window.key("ctrl+shift+o", over_view=True)  # Open Recent: the second file is below the mouse
    sleep(1)
    window.key("Down")
    window.key("Return")
    wait_until(lambda: window.value("bpy.data.filepath").endswith("first.blend"), 20, "not opened")
    window.show_tab("RadTex")
    settle(window)
    assert window.value(FOUND) == ["replace"]
    assert window.value(TITLES) == ["Suzanne", "Suzanne (second.blend)"]
    assert window.value(FATES) == ["there", "there"]
    window.ask(f"bpy.ops.radtex.fold_job(number={jobs(window)[0].number})")  # another has ended since
    for name in ("first", "second"):
        window.click(*window.find(f"{name}/Suzanne.radiance.json"))
        bake = [f"{window.inside}/radtex/{name}/Suzanne.radiance.exr"]
        wait_until(lambda: window.value(PATHS) == bake, 20, f"the bake of {name} is not shown")  # noqa: B023  # called in the loop
        look(window, f"copy-{name}-shown")
    assert stamps(window, "first") == first


def test_a_better_bake_is_replaced_only_by_who_says_so(window: Window) -> None:
    open_scene(window, "build", "better.blend")
    choose(window)
    window.click(*window.find('preset_apply(name="preview")'))
    window.ask("bpy.context.scene.radtex.texels, bpy.context.scene.radtex.samples = 32, 4")  # for seconds
    settle(window)
    press(window)
    ends(window)
    better = stamps(window, "better")
    assert facts(window, "better")["layout"] == "layered"
    window.click(*window.find('preset_apply(name="draft")', right=220))
    settle(window)
    for refuse in ("mouse", "Return", "Escape"):
        before = look(window, "better-draft")
        window.click(*window.find("radtex.bake(", right=RIGHT))
        asked = window.shot("lost-better-asked")
        assert changed(before.crop(PANEL), asked.crop(PANEL)) > 0.1
        if refuse == "mouse":
            window.click(*default_button(before, asked))
        else:
            window.key(refuse)
        settle(window)
        assert changed(before.crop(PANEL), look(window, "better-kept").crop(PANEL)) < 0.01
        assert (len(jobs(window)), stamps(window, "better")) == (1, better)
    window.click(*window.find("radtex.bake(", right=RIGHT))
    sleep(1)
    window.key("r")  # Replace
    wait_until(lambda: len(jobs(window)) == 2, 20, "no bake")
    ends(window)
    settle(window)
    assert facts(window, "better")["layout"] == "buckets"
    assert window.value(FATES) == ["replaced", "there"]
    look(window, "better-replaced")


def test_a_move_of_the_preview_is_kept_and_undone(window: Window) -> None:
    open_scene(window, "build", "moved.blend")
    choose(window, **SMALL)
    press(window)
    ends(window)
    window.ask("bpy.ops.radtex.clear_jobs()")
    preview(window, "Suzanne (baked)")
    move(window, "x", "1.5")
    assert window.value(PLACES) == {"Suzanne": [0, 0, 0], "Suzanne (baked)": [1.5, 0, 0]}
    look(window, "preview-moved")
    preview(window, "Suzanne")
    assert window.value(PLACES) == {"Suzanne": [1.5, 0, 0]}
    look(window, "object-moved")
    moved = {"Suzanne": (0, 0, 0), "Suzanne (baked)": (1.5, 0, 0)}
    take_back(window, "ctrl+z", moved)
    take_back(window, "ctrl+z", moved | {"Suzanne (baked)": (0, 0, 0)})
    take_back(window, "ctrl+shift+z", moved)
    take_back(window, "ctrl+shift+z", {"Suzanne": (1.5, 0, 0)})

    preview(window, "Suzanne (baked)")
    move(window, "y", "1")
    ends(window, wait_for_job(window, "radtex.bake("))
    assert window.value(PLACES) == {"Suzanne": [1.5, 1, 0]}
    look(window, "baked-where-moved")
    preview(window, "Suzanne (baked)")
    assert window.value(BAKED_AT) == [1.5, 1, 0]
    take_back(window, "ctrl+z", {"Suzanne": (1.5, 1, 0)})
    take_back(window, "ctrl+z", {"Suzanne": (1.5, 0, 0), "Suzanne (baked)": (1.5, 1, 0)})


def test_all_that_can_be_baked_of_everything_is(window: Window) -> None:
    open_scene(window, "build", "all.blend")
    window.ask("bpy.ops.radtex.clear_jobs()")
    window.ask(CUTTER)
    for name, value in (SMALL | {"texels": 64}).items():
        window.ask(f"bpy.context.scene.radtex.{name} = {value!r}")
    window.key("a", over_view=True)
    settle(window)
    assert window.value("len(bpy.context.selected_objects)") == 6
    assert window.value(FOUND) == ["bake"]
    cutter, others = window.value(LINES)
    assert cutter.startswith("left out: object 'Cutter' is hidden from render")
    assert others.startswith("Left out: ")
    assert {"'Camera' is a camera", "'Empty' is an empty", "'Light' is a light"} == set(
        others.removeprefix("Left out: ").split(", ")
    )
    look(window, "all-selected")
    press(window)
    ends(window)
    assert [(told.what, told.state) for told in jobs(window)] == [("Plane", "done"), ("Suzanne", "done")]
    look(window, "all-baked")


def test_a_modified_object_goes_on_after_two_cancels(window: Window) -> None:
    open_scene(window, "build_lamp", "lamp.blend")
    choose(window, "Lamp", **LARGER)
    press(window)
    wait_for(window, 0.15)
    window.key("Escape")
    wait_until(lambda: latest(window).state == "cancelled", 10, "not cancelled by Esc")
    settle(window)
    begun = pieces(window)
    assert window.value(FOUND) == ["resume"]
    look(window, "lamp-cancelled")
    window.ask("bpy.ops.radtex.clear_jobs()")

    number = wait_for_job(window, "resume=True", right=LEFT)
    window.click(*window.find(f"radtex.cancel(number={number})", right=CROSS))
    wait_until(lambda: latest(window).state == "cancelled", 10, "not cancelled by its cross")
    settle(window)
    more = pieces(window)
    assert begun.items() < more.items()
    look(window, "lamp-cancelled-again")

    number = wait_for_job(window, "resume=True", right=CROSS)  # in the job's box
    goes_on(window, more)
    ends(window, number)
    assert window.value(FOUND) == ["replace"]
    look(window, "lamp-done")


def test_a_modified_object_goes_on_after_blender_was_quit(window: Window) -> None:
    """After the test above, whose bake is there."""
    choose(window, "Lamp", **LARGER)
    window.key("ctrl+s", over_view=True)
    wait_until(lambda: not window.value("bpy.data.is_dirty"), 10, "not saved")
    settle(window)
    done = stamps(window, "lamp")
    press(window)
    wait_for(window, 0.15)
    window.key("ctrl+q", over_view=True)
    wait_until(lambda: not window.processes("blender"), 10, "Blender or its worker is left")
    begun = pieces(window)
    assert not window.processes(WORKER)
    assert stamps(window, "lamp") == done

    start_again(window, "lamp.blend")
    settle(window)
    assert window.value(FOUND) == ["resume"]
    look(window, "lamp-opened-again")
    number = wait_for_job(window, "resume=True", right=LEFT)
    goes_on(window, begun)
    ends(window, number)
    assert stamps(window, "lamp").keys() == done.keys()
    look(window, "lamp-done-again")


def open_scene(window: Window, build: str, name: str) -> None:
    """A new scene that is saved by that name, and the panel beside it."""
    window.ask("bpy.ops.wm.read_homefile(app_template='')")
    window.ask(f"room.{build}({f'{window.inside}/{name}'!r})")
    window.show_tab("RadTex")
    window.ask(KNOW)


def save_as(window: Window, name: str) -> None:
    """Save As, by its key, a name that is typed, and the button."""
    window.key("ctrl+shift+s", over_view=True)
    wait_until(lambda: window.value("len(bpy.context.window_manager.windows)") == 2, 10, "no file window")
    sleep(3)
    window.point(*NAME)
    window.run("xdotool", "click", "--repeat", "2", "--delay", "60", "1")
    sleep(0.5)
    window.key("ctrl+a")
    window.run("xdotool", "type", "--delay", "40", name)
    window.key("Return")
    window.click(*SAVE)
    wait_until(lambda: window.value("bpy.data.filepath").endswith(name), 10, "not saved")
    settle(window)


def move(window: Window, axis: str, distance: str) -> None:
    """Move what is selected, by keys over the 3D view."""
    window.key("g", over_view=True)
    window.key(axis)
    window.run("xdotool", "type", "--delay", "40", distance)
    window.key("Return")
    settle(window)


def take_back(window: Window, keys: str, places: Mapping[str, tuple[float, ...]]) -> None:
    """Undo or redo by keys; then objects must be at these places."""
    wanted = {name: list(place) for name, place in places.items()}
    window.key(keys, over_view=True)
    wait_until(lambda: window.value(PLACES) == wanted, 10, f"not at {places} after {keys}")


def wait_for_job(window: Window, operator: str, right: int = RIGHT) -> int:
    """Click on a large button, or on one in a job's box; the number of the job that comes of it."""
    before = max((told.number for told in jobs(window)), default=0)
    window.click(*window.find(operator, right=right))
    wait_until(lambda: any(told.number > before for told in jobs(window)), 20, "no job")
    return latest(window).number


def ends(window: Window, number: int = 0) -> None:
    """Wait until the latest job is done, which has that number, if one is given."""
    since = monotonic()
    told: Told = wait_for_end(window)
    assert number in (0, told.number)
    assert told.state == "done", told.message
    settle(window)
    print(f"\n{told.what}: {monotonic() - since:.0f} s until it was done")


def pieces(window: Window) -> dict[str, tuple[int, int]]:
    """The same as `stamps` of what was traced of the lamp and is kept to go on from."""
    found = stamps(window, "lamp/Lamp.radiance.radtex-unfinished")
    return {name: stamp for name, stamp in found.items() if name.startswith("tile-")}


def goes_on(window: Window, begun: Mapping[str, tuple[int, int]]) -> None:
    """Wait until a job has traced more than `begun`, none of which it traces again."""
    assert begun
    wait_until(lambda: len(pieces(window)) > len(begun), 60, "nothing more is traced")
    assert begun.items() < pieces(window).items()


def default_button(before: PIL.Image.Image, after: PIL.Image.Image) -> tuple[int, int]:
    """The middle of what became blue: the default button of a dialog that opened."""
    was, now = (np.all(np.abs(np.asarray(one, int) - BLUE) < 6, axis=2) for one in (before, after))
    rows, columns = np.nonzero(now & ~was)
    return int(np.median(columns)), int(np.median(rows))


def look(window: Window, name: str) -> PIL.Image.Image:
    """A picture of all, with the mouse where it opens no tooltip."""
    window.point(*AWAY)
    return window.shot(f"lost-{name}")


def stamps(window: Window, blend: str) -> dict[str, tuple[int, int]]:
    """Names, times and sizes of the finished files that a .blend's own folder has."""
    folder: Path = window.folder / "radtex" / blend
    files = [path for path in folder.iterdir() if path.is_file()]
    return {path.name: (path.stat().st_mtime_ns, path.stat().st_size) for path in files}


def facts(window: Window, blend: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(
        (window.folder / "radtex" / blend / "Suzanne.radiance.json").read_text()
    )
    return found
