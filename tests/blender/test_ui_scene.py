# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel bakes a scene in one go: what it foresees, bakes and leaves, and one bar over all jobs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import bpy
import pytest

from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.report.finished_bake import objects_and_frame
from radtex_addon.settings.time_left import Left, time_left
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.operators.scene_operator import RADTEX_OT_bake_scene
from radtex_addon.ui.operators.texels_operator import atlases_of_scene, squares_of
from radtex_addon.ui.panel import main_panel
from radtex_addon.ui.panel.jobs_panel import _ask_to_resume, told_together
from radtex_addon.ui.panel.not_baked import not_baked
from radtex_addon.ui.settings.request import request_of, values_of
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.together import Together, together_of
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, finish_jobs, ops, registered, settings

FURNITURE = ("Cup", "Top")


@pytest.fixture(autouse=True)
def _corner(out: Path) -> Iterator[None]:
    """A table with a cup on it in the corner of two walls and a floor, a lonely ball, and a text."""
    stage.world()
    gloss = stage.material("Gloss", "ShaderNodeBsdfPrincipled", Roughness=0.3)
    for name, place, turn in (
        ("Floor", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ("Wall N", (0.0, 2.0, 2.0), (1.5708, 0.0, 0.0)),
        ("Wall W", (-2.0, 0.0, 2.0), (0.0, 1.5708, 0.0)),
    ):
        bpy.ops.mesh.primitive_plane_add(size=4, location=place, rotation=turn)
        context.object.name = name
    for name, size, place in (("Top", 0.8, (1.0, 1.0, 0.5)), ("Cup", 0.2, (1.0, 1.0, 1.0))):
        bpy.ops.mesh.primitive_cube_add(size=size, location=place)
        context.object.name = name
    for item in context.scene.objects:
        item.data.materials.append(gloss)
    bpy.ops.object.camera_add()
    bpy.ops.object.select_all(action="DESELECT")
    with registered():
        settings().directory = str(out)
        settings().texels, settings().samples, settings().unwrap = 12, 1, "blender"
        yield


def foreseen(what: str = "ALL", *, again: bool = False) -> list[tuple[str, str]]:
    """What the dialog says."""
    dialog: Any = SimpleNamespace(what=what, again=again, join=True, at_once=True, _drawn=None)
    for name in ("_foreseen", "_found", "_chosen", "_collection", "_owners", "_plans"):
        setattr(dialog, name, getattr(RADTEX_OT_bake_scene, name).__get__(dialog))
    assert RADTEX_OT_bake_scene.check(dialog, context)
    assert not RADTEX_OT_bake_scene.check(dialog, context), "nothing has changed"
    dialog.layout, dialog.bl_rna = RecordedLayout(), ops.radtex.bake_scene.get_rna_type()
    RADTEX_OT_bake_scene.draw(dialog, context)
    return list(dialog._lines)


def test_the_dialog_tells_atlases_texels_and_time() -> None:
    lines = foreseen()
    assert next(line for line, icon in lines if icon == "TEXTURE").startswith(
        "'Scene_shell' has 'Floor', 'Wall N' and 'Wall W': "
    )
    told = r"2 bakes are left to do, in [\d.]+( s| min)? to [\d.]+ (s|min)"
    assert any(re.fullmatch(told, line) for line, icon in lines if icon == "TIME")
    for name in FURNITURE:
        context.scene.objects[name].select_set(True)
    assert [line.partition(":")[0] for line, icon in foreseen("SELECTED") if icon == "TEXTURE"] == [
        "'Top_group' has 'Cup' and 'Top'"
    ]
    context.scene.objects["Cup"].radtex.use = True
    assert [line.partition(":")[0] for line, icon in foreseen("SELECTED") if icon == "TEXTURE"] == ["'Top'"]
    bpy.ops.object.select_all(action="DESELECT")
    context.view_layer.objects.active = None
    assert foreseen("SELECTED") == [
        ("There is no mesh to bake that is seen in renders: choose others", "ERROR")
    ]


@pytest.mark.one_blender
def test_the_scene_is_baked_once_and_again_if_asked(out: Path) -> None:
    assert ops.radtex.bake_scene() == {"FINISHED"}
    found = sorted(out.glob("*.radiance.json"))
    assert [path.name for path in found] == ["Scene_shell.radiance.json", "Top_group.radiance.json"]
    assert [path.name for path in sorted(out.glob("*.preview.blend"))] == [
        "Scene_shell.preview.blend",
        "Top_group.preview.blend",
    ]
    before = [path.stat().st_mtime_ns for path in found]
    assert ("All of it is baked", "CHECKMARK") in foreseen()
    assert ops.radtex.bake_scene() == {"FINISHED"}
    assert [path.stat().st_mtime_ns for path in found] == before
    for path in out.glob("Top_group.*"):
        path.unlink()
    assert ops.radtex.bake_scene() == {"FINISHED"}
    assert found[1].exists()
    assert found[0].stat().st_mtime_ns == before[0], "what is there stays"
    bpy.ops.object.select_all(action="DESELECT")
    for name in FURNITURE:
        context.scene.objects[name].select_set(True)
    before = [path.stat().st_mtime_ns for path in found]
    assert ops.radtex.bake_scene(what="SELECTED", again=True) == {"FINISHED"}
    after = [path.stat().st_mtime_ns for path in found]
    assert (after[0] == before[0], after[1] > before[1]) == (True, True)


def cups() -> Any:
    """An empty that shows a collection with a cup and a lamp."""
    cup, lamp = (
        context.scene.objects["Cup"],
        bpy.data.objects.new("Bulb", bpy.data.lights.new("Bulb", "POINT")),
    )
    shelf = bpy.data.collections.new("Shelf")
    for item in (cup.copy(), lamp):
        shelf.objects.link(item)
    empty = bpy.data.objects.new("Second Cup", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", shelf
    empty.location.x = -0.4
    context.scene.collection.objects.link(empty)
    return empty


def test_instances_become_meshes_before_the_scene_is_baked() -> None:
    empty = cups()
    assert (
        "Instances become meshes first: those of 'Second Cup'",
        "OUTLINER_OB_GROUP_INSTANCE",
    ) in foreseen()
    assert ops.radtex.bake_scene() == {"FINISHED"}
    made = context.scene.objects["Second Cup"]
    assert (made.type, empty.name, empty.hide_render) == ("MESH", "Second Cup (instances)", True)
    baked = {
        name for path in Path(settings().directory).glob("*.json") for name in objects_and_frame(path)[0]
    }
    assert "Second Cup" in baked


def test_a_button_joins_the_instances_that_are_selected() -> None:
    empty = cups()
    assert not ops.radtex.join_instances.poll()
    empty.select_set(True)
    (told,) = not_baked([empty])
    assert (told.operator, told.button) == ("radtex.join_instances", "Join Instances")
    assert ops.radtex.join_instances() == {"FINISHED"}
    assert [item.name for item in context.view_layer.objects.selected] == ["Second Cup"]
    assert context.view_layer.objects.active.type == "MESH"
    assert "Second Cup Bulb" in context.scene.objects


def test_selected_instances_are_baked_as_meshes() -> None:
    cups().select_set(True)
    context.scene.objects["Cup"].select_set(True)
    assert ops.radtex.bake_scene(what="SELECTED") == {"FINISHED"}
    baked = [objects_and_frame(path)[0] for path in Path(settings().directory).glob("*.json")]
    assert {name for objects in baked for name in objects} == {"Cup", "Second Cup"}


def test_the_panel_has_the_button() -> None:
    layout: Any = RecordedLayout()
    main_panel._draw_buttons(layout, None)
    assert "Bake the Scene…" in layout.texts


@pytest.mark.one_blender
def test_one_bar_goes_over_the_bakes_of_a_scene() -> None:
    """By workers, in layout buckets, which is quick, and has an atlas for each object."""
    settings().atlas_layout, settings().bucket, settings().preview = "buckets", 2, False
    request = request_of(values_of(settings()) | {"together": "off"}, ("Cup", "Top"))
    jobs.submit(context.scene, [plan_bakes(context.scene, request)])
    seen: list[Together] = []
    while jobs.busy():
        jobs.advance()
        if (found := jobs.together()) is not None and (not seen or found != seen[-1]):
            seen.append(found)
    finish_jobs()
    assert {(each.done, each.count) for each in seen} == {(0, 2), (1, 2)}
    fractions = [each.fraction for each in seen]
    assert fractions == sorted(fractions)
    assert 0.5 <= fractions[-1] <= 1
    assert jobs.together() is None
    left = Left(95.0, 70.0, 130.0)
    assert told_together(replace(seen[-1], left=left)) == "1 of 2 bakes, 1 to 2 min left"
    assert told_together(replace(seen[-1], left=None)) == "1 of 2 bakes, time left: not known yet"
    running, other = (replace(job, state=JobState.RUNNING, fraction=0.5) for job in jobs.snapshot())
    waiting = replace(other, state=JobState.WAITING, fraction=0.0)
    running = replace(running, course=running.order.course.at("capture", 0.5, 10.0))
    told = together_of([running, waiting], {running.number: 10.0})
    assert told is not None
    assert told.fraction == pytest.approx(0.25)
    slower = replace(running, course=running.order.course.at("capture", 0.0, 20.0).at("capture", 0.5, 40.0))
    late = together_of([slower, waiting], {running.number: 40.0})
    assert told.left is not None
    assert late is not None
    assert late.left is not None
    alone = slower.course
    assert alone is not None
    assert told.left.seconds > 2.0, "the one that waits is counted, too"
    assert late.left.seconds > time_left(alone, 40.0).seconds + waiting.order.seconds, "at this one's pace"
    assert together_of([running], {}) is None
    elsewhere = replace(waiting, order=replace(waiting.order, folder=Path("elsewhere")))
    assert together_of([running, elsewhere], {}) is None, "it was not asked for at the same time"


def test_an_object_of_a_scene_is_resumed_with_its_texels() -> None:
    order: Any = SimpleNamespace(part="", shared=(), facts={"spec": {"density": None, "texels": 304}})
    button = SimpleNamespace()
    _ask_to_resume(button, cast(Job, SimpleNamespace(order=order, object="Floor")))
    assert (button.object, button.texels, button.resume) == ("Floor", 304, True)


def test_squares_are_as_large_as_texels_and_red_where_there_are_more() -> None:
    layer = context.view_layer
    layer.update()
    atlases = atlases_of_scene(context.scene, layer)
    assert {name for atlas in atlases for name in atlas.objects} == {"Floor", "Wall N", "Wall W", *FURNITURE}
    squares = {one.name: one for one in squares_of(atlases, 0.01)}  # units of a centimetre
    densities = {name: atlas.density for atlas in atlases for name in atlas.objects}
    for name, one in squares.items():
        assert one.size * densities[name] == pytest.approx(100)
    assert densities["Cup"] > densities["Floor"], "small things have more"
    assert squares["Cup"].tint[0] > squares["Floor"].tint[0]
    assert squares["Cup"].tint[2] < squares["Floor"].tint[2]
    assert squares_of([], 1) == []
    assert not ops.radtex.show_texels.poll(), "there is no viewport here"
