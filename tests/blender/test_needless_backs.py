# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Backs get texels only where a camera can be: in rooms of planes, on walls, and in the open."""

from __future__ import annotations

from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.prepare.faces import find_two_sided, seen_backs
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.choices import Backs
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.plane_room import HIGH, LONG, WALLS, box, card, furniture, walls

context: Any = bpy.context  # to the stubs, every pointer may be None


def kept(*names: str, backs: Backs = Backs.AUTO) -> dict[str, float]:
    """The share of triangles of each object whose backs get texels; they are judged as one atlas's."""
    items = [bpy.data.objects[name] for name in names]
    with scratch_scene(context.scene, None, []) as scratch:
        meshes = [evaluate(scratch, item) for item in items]
        seen, _ = finished(seen_backs(scratch, items, meshes, backs))
    return {name: float(faces.mean()) for name, faces in zip(names, seen, strict=True)}


@pytest.mark.parametrize("without", [(), ("North",), ("Ceiling",)])
def test_what_encloses_a_room_has_no_backs(without: tuple[str, ...]) -> None:
    walls(without)
    furniture()
    names = tuple(name for name in WALLS if name not in without)
    assert kept(*names) == dict.fromkeys(names, 0.0)
    for name in names:
        assert kept(name) == {name: 0.0}, "by itself as in one atlas"
    assert kept("Rug", "Mirror") == {"Rug": 0.0, "Mirror": 0.0}
    assert kept("Floor", "Rug", backs=Backs.ALL) == {"Floor": 1.0, "Rug": 1.0}
    assert kept("Floor", "Rug", backs=Backs.NONE) == {"Floor": 0.0, "Rug": 0.0}


def told_of(*names: str, backs: Backs, caplog: pytest.LogCaptureFixture) -> list[str]:
    """What a bake warns of, of the backs of these objects."""
    items = [bpy.data.objects[name] for name in names]
    caplog.clear()
    with scratch_scene(context.scene, None, []) as scratch:
        meshes = [evaluate(scratch, item) for item in items]
        finished(find_two_sided(scratch, items, meshes, BakeSpec(texels=64, backs=backs)))
    return [record.getMessage() for record in caplog.records]


def test_a_line_says_how_many_backs_of_which_objects_get_no_texels(caplog: pytest.LogCaptureFixture) -> None:
    walls()
    furniture()
    (line,) = told_of("Floor", "Rug", backs=Backs.AUTO, caplog=caplog)
    assert "the backs of 'Floor' (2 triangles), 'Rug' (2 triangles), which face" in line
    lines = told_of("Floor", "Rug", backs=Backs.NONE, caplog=caplog)
    assert [line.partition(" can be seen")[0] for line in lines] == [
        "2 of 2 triangles of 'Floor'",
        "2 of 2 triangles of 'Rug'",
    ]
    assert told_of("Floor", "Rug", backs=Backs.ALL, caplog=caplog) == []


def test_the_planes_of_an_empty_room_have_no_backs_either() -> None:
    walls()
    assert kept("Floor", "West") == {"Floor": 0.0, "West": 0.0}


@pytest.mark.parametrize("full", [True, False])
def test_backs_that_look_into_a_room_are_kept(full: bool) -> None:
    walls(turned=True)
    if full:
        furniture()
    assert kept(*WALLS) == dict.fromkeys(WALLS, 1.0)


def test_between_two_rooms_no_camera_can_be() -> None:
    walls()
    first = [bpy.data.objects[name] for name in WALLS]
    for item in first:
        other = item.copy()
        other.location.x += LONG + 0.15
        context.scene.collection.objects.link(other)
    context.view_layer.update()
    assert kept("East", "East.001", "West.001") == {"East": 0.0, "East.001": 0.0, "West.001": 0.0}


def test_walls_that_a_camera_in_a_garden_sees_keep_their_backs() -> None:
    walls(without=("Floor",))
    card("Garden", (0, 0, 0), (0, 0, 1), (30, 30))
    assert kept("West", "Ceiling") == {"West": 1.0, "Ceiling": 0.0}


def test_furniture_of_sheets_keeps_its_backs() -> None:
    walls()
    card("Curtain", (0, -LONG / 2 + 0.3, 1.2), (0, 1, 0), (2, 2))
    card("Leaf", (0.5, 0.5, 1), (0, 0, 1), (0.2, 0.1))
    card("Leaning", (0, LONG / 2 - 0.2, 1), (0, -1, 0), (0.5, 1))
    assert kept("Curtain", "Leaf", "Leaning") == {"Curtain": 1.0, "Leaf": 1.0, "Leaning": 1.0}


def test_in_the_open_nothing_changes() -> None:
    card("Ground", (0, 0, 0), (0, 0, 1), (20, 20))
    box("Crate", (2, 0, 0.5), (1, 1, 1))
    card("Flag", (0, 0, 2), (0, 1, 0), (1.5, 1))
    card("Leaf", (0, 2, 0.5), (0, 0, 1), (0.2, 0.1))
    card("Table", (-3, 0, 0.7), (0, 0, -1), (1.5, 1))  # its normal is turned: the top is its back
    card("Roof", (-3, 5, 2.5), (0, 0, -1), (4, 4))
    card("Sunken", (3, 4, -1), (0, 0, 1), (2, 2))
    bpy.ops.mesh.primitive_uv_sphere_add(location=(5, 5, 1))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bisect(plane_co=(0, 0, 1), plane_no=(0, 0, 1), clear_outer=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    context.object.name = "Bowl"
    names = ("Ground", "Flag", "Leaf", "Table", "Roof", "Bowl")
    assert kept(*names) == dict.fromkeys(names, 1.0)
    for name in names:
        assert kept(name) == {name: 1.0}


def test_a_vase_with_flowers_keeps_its_outside() -> None:
    """Its faces look inwards, and something is inside; but no camera is."""
    bpy.ops.mesh.primitive_cylinder_add(radius=0.15, depth=0.6, end_fill_type="NOTHING")
    context.object.data.flip_normals()
    context.object.name = "Vase"
    box("Stem", (0, 0, 0.1), (0.02, 0.02, 0.5))
    box("Table", (0, 0, -0.31), (2, 2, 0.01))
    assert kept("Vase") == {"Vase": 1.0}
    bpy.data.objects.remove(bpy.data.objects["Table"])
    assert kept("Vase") == {"Vase": 1.0}


def test_what_lies_within_something_closed_has_no_back() -> None:
    """A panel in front of a wall with a thickness of its own, and a sheet in the wall."""
    box("Wall", (0, 0, 1), (4, 0.3, 2))
    card("Panel", (0, -0.14, 1), (0, -1, 0), (1, 1))
    assert kept("Panel") == {"Panel": 0.0}


def test_a_pane_of_glass_hides_nothing() -> None:
    walls(without=("North",))
    pane = card("Pane", (0, LONG / 2, HIGH / 2), (0, -1, 0), (LONG, HIGH))
    pane.data.materials.append(stage.material("Glass", "ShaderNodeBsdfGlass"))
    card("Sheet", (0, LONG / 2 - 0.001, 1), (0, -1, 0), (1, 1))
    card("Garden", (0, 20, 0), (0, 0, 1), (40, 35))
    assert kept("Sheet") == {"Sheet": 1.0}, "seen from outside, through the pane"


def test_a_scene_of_another_scale_is_judged_by_its_metre() -> None:
    walls(scale=0.01)
    box("Table", (0, 0, 0.004), (0.01, 0.008, 0.008))
    assert kept("West") == {"West": 1.0}, "a doll's house, which is looked at from outside"
    context.scene.unit_settings.scale_length = 100
    assert kept("West") == {"West": 0.0}
