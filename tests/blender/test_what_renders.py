# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake mirrors what the render shows, where the render has it: neither more nor elsewhere."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any, Literal

import bpy
import numpy as np
import pytest
from mathutils import Vector

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.forms.layered.capture.hidden_lamps import HideableLamp, hidden_lamps
from radtex_addon.forms.layered.capture.lamps import lamps_shown
from radtex_addon.forms.layered.capture.panoramas import Near, _seen_from_above, look_around, near_things
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.environment import Plane
from radtex_addon.job import bake_object
from radtex_addon.preview.lit_material import first_sun
from radtex_addon.scene.checks.see_through import volumes_around
from radtex_addon.scene.mesh.render_contents import top_of_render
from radtex_addon.scene.proxy_content import find_content
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.test_scene_others import moved

context: Any = bpy.context
MIDDLE = np.array([0, 0, 4], np.float32)  # the ball's
SPEC = BakeSpec(layout=Layout.LAYERED, texels=8, samples=1, uv_layer="UVMap")


def ball() -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, location=(0, 0, 4))
    context.object.name = "Ball"
    material = stage.material("Gloss", "ShaderNodeBsdfPrincipled", Roughness=0.2, Metallic=1.0)
    context.object.data.materials.append(material)
    return context.object


def lamp(name: str, at: tuple[float, float, float], kind: Literal["POINT", "SUN"] = "POINT") -> Any:
    bpy.ops.object.light_add(type=kind, location=at)
    context.object.name = name
    context.object.data.energy = 100
    return context.object


def floor(name: str, height: float, size: float = 12, subdivisions: int = 2) -> Any:
    bpy.ops.mesh.primitive_grid_add(
        x_subdivisions=subdivisions, y_subdivisions=subdivisions, size=size, location=(0, 0, height)
    )
    context.object.name = name
    return context.object


def cube(name: str, at: tuple[float, float, float]) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=1, location=at)
    context.object.name = name
    return context.object


def excluded(item: Any) -> None:
    collection = moved(item, f"without {item.name}")
    context.view_layer.layer_collection.children[collection.name].exclude = True


def near(subjects: Collection[Any]) -> list[Near]:
    with scratch_scene(context.scene) as scratch:
        return near_things(scratch, subjects)


def names(things: Near) -> list[str]:
    return sorted(item.name for item in things.objects)


def lit(receiver: Any) -> dict[str, list[float]]:
    """The lamps that a receiver mirrors, and where they are."""
    with scratch_scene(context.scene) as scratch:
        found = lamps_shown(scratch, [receiver])
    return {one.item.name: np.round(one.matrix[:3, 3], 4).tolist() for one in found}


def test_a_bake_mirrors_lamps_and_floor_of_the_render_alone(out: Path) -> None:
    """One lamp renders, and the floor and another lamp are hidden in the viewport alone, where they stand."""
    receiver = ball()
    lamp("On", (3, 0, 4))
    excluded(lamp("Excluded", (0, 5, 4)))
    moved(lamp("Render off", (0, -5, 4)), "off").hide_render = True
    hidden = lamp("Hidden in views", (0, 0, 0))
    floor("Floor", 0).hide_viewport = hidden.hide_viewport = True
    context.object.location.z = 2.6  # Blender does not evaluate what is hidden: its matrix_world stays
    hidden.location = (0, 0, 9)
    excluded(floor("Old floor", -30, size=200))
    receiver.select_set(True)
    before = fingerprint()
    made = bake_object(context.scene, "Ball", SPEC, out)
    assert differences(before, fingerprint()) == {}
    around = read_layered(made.files.sidecar)[0].around
    towards = [found.place / np.linalg.norm(found.place) for found in around.lamps]
    assert sorted(np.round(towards, 2).tolist()) == [[0, 0, 1], [1, 0, 0]]
    planes = [layer.shape for layer in around.layers if isinstance(layer.shape, Plane)]
    assert [plane.height for plane in planes] == pytest.approx([2.6 - MIDDLE[2]], abs=1e-4)


def test_lamps_are_those_that_glossy_rays_of_the_render_meet() -> None:
    receiver = ball()
    lamp("On", (3, 0, 4))
    lamp("Unseen by gloss", (3, 1, 4)).visible_glossy = False
    lamp("Takes light away", (3, 2, 4)).data.energy = -60
    lamp("Nowhere", (0, 0, 0)).location.x = np.inf
    parent = bpy.data.objects.new("Parent", None)
    context.scene.collection.objects.link(parent)
    parent.location, parent.hide_viewport = (0, 0, 7), True
    child = lamp("Child", (1, 0, 0))
    child.parent, child.hide_viewport = parent, True
    found = lit(receiver)
    assert found == {"On": [3, 0, 4], "Child": [1, 0, 7]}


@pytest.mark.parametrize("how", ["itself", "red", "instance", "driver"])
def test_a_lamp_that_takes_light_away_is_refused_by_name(how: str, out: Path) -> None:
    ball()
    dark = lamp("Dark", (3, 0, 4))
    dark.data.energy = -60
    if how == "red":
        dark.data.color = 1, 0, 0
    if how == "driver":
        dark.data.energy = 60
        dark.data.driver_add("energy").driver.expression = "-60"
    if how == "instance":
        excluded(dark)
        bpy.ops.object.collection_instance_add(collection="without Dark")
    with pytest.raises(InputError, match=r"lamp 'Dark' takes light away \(its power is -60\)"):
        bake_object(context.scene, "Ball", SPEC, out)
    assert not out.exists() or not list(out.iterdir())


def test_instanced_lamps_stand_where_their_instances_are() -> None:
    receiver = ball()
    excluded(lamp("Bulb", (0, 0, 1)))
    bpy.ops.object.collection_instance_add(collection="without Bulb", location=(5, 0, 0))
    assert lit(receiver) == {"Bulb": [5, 0, 1]}


@pytest.mark.parametrize(
    ("state", "member", "shines"),
    [
        ("EXCLUDE", "Ball", False),
        ("EXCLUDE", "Other", True),
        ("INCLUDE", "Ball", True),
        ("INCLUDE", "Other", False),
    ],
)
def test_a_lamp_that_does_not_light_the_object_is_not_mirrored(
    state: Literal["INCLUDE", "EXCLUDE"], member: str, shines: bool
) -> None:
    receiver = ball()
    cube("Other", (5, 5, 5))
    linked, on = bpy.data.collections.new("Receivers"), lamp("On", (3, 0, 4))
    linked.objects.link(bpy.data.objects[member])
    linked.collection_objects[0].light_linking.link_state = state
    on.light_linking.receiver_collection = linked
    assert (lit(receiver) != {}) == shines


def test_collections_in_light_linking_count_with_all_their_objects() -> None:
    receiver = ball()
    inner = moved(receiver, "Inner")
    linked, on = bpy.data.collections.new("Receivers"), lamp("On", (3, 0, 4))
    linked.children.link(inner)
    on.light_linking.receiver_collection = linked
    assert lit(receiver) != {}
    linked.collection_children[0].light_linking.link_state = "EXCLUDE"
    assert lit(receiver) == {}


def test_the_largest_flat_thing_is_measured_by_its_size_not_its_vertices() -> None:
    receiver = ball()
    floor("Table", 2, size=1, subdivisions=60)
    floor("Floor", 0, size=12)
    plane, others = near([receiver])
    assert names(plane) == ["Floor"]
    assert plane.plane is not None
    assert abs(plane.plane[1]) < 1e-6
    assert names(others) == ["Table"]


def test_a_floor_of_tiles_that_are_instanced_is_one_flat_thing() -> None:
    receiver = ball()
    tile = floor("Tile", 0, size=1)
    context.scene.collection.objects.unlink(tile)
    tiles = bpy.data.collections.new("Tiles")
    for x in range(3):
        for y in range(3):
            copy = bpy.data.objects.new("Tile", tile.data)
            copy.location = x, y, 0
            tiles.objects.link(copy)
    bpy.ops.object.collection_instance_add(collection="Tiles", location=(0, 0, 1.5))
    (plane,) = near([receiver])
    assert names(plane) == ["Tiles"]
    assert plane.plane is not None
    normal, height = plane.plane
    assert height * normal[2] == pytest.approx(1.5)


def test_things_that_are_nowhere_are_left_out_by_name(caplog: pytest.LogCaptureFixture) -> None:
    receiver = ball()
    cube("Fine", (3, 0, 0))
    broken = cube("Broken", (0, 3, 0))
    broken.data.vertices[0].co.x = np.nan
    cube("Blown up", (0, 0, 9)).scale.x = np.inf
    (others,) = near([receiver])
    assert names(others) == ["Fine"]
    assert "object 'Broken' has vertices nowhere" in caplog.text
    assert "object 'Blown up'" in caplog.text


def test_a_portal_is_no_lamp() -> None:
    receiver = ball()
    bpy.ops.object.light_add(type="AREA", location=(0, 0, 9))
    assert len(lit(receiver)) == 1
    context.object.data.cycles.is_portal = True
    assert not lit(receiver)


def test_a_mirrored_lamp_is_where_the_lamp_is(out: Path) -> None:
    """To a third of a degree, for lamps of each type, some of them at the edges of the lamps' picture."""
    ball()
    places = {"POINT": (0, 0, -3), "SPOT": (2, 1, 3), "AREA": (-1, 3, -1), "SUN": (-2, -1, 2)}
    for kind, place in places.items():
        item = lamp(kind, (MIDDLE + place).tolist())
        item.data.type = kind
        item.rotation_euler = Vector(place).to_track_quat("Z", "Y").to_euler()
    made = bake_object(context.scene, "Ball", SPEC, out)
    found = [
        one.place / np.linalg.norm(one.place) for one in read_layered(made.files.sidecar)[0].around.lamps
    ]
    wanted = [np.array(place) / np.linalg.norm(place) for place in places.values()]
    assert len(found) == len(wanted)
    assert (np.linalg.norm(np.array(found)[:, None] - wanted, axis=-1).min(axis=0) < np.radians(1 / 3)).all()


def test_what_glossy_rays_do_not_see_is_no_near_thing() -> None:
    receiver = ball()
    cube("Unseen by cameras", (3, 0, 0)).visible_camera = False
    cube("Unseen by gloss", (0, 3, 0)).visible_glossy = False
    (others,) = near([receiver])
    assert names(others) == ["Unseen by cameras"]


def seen_around(receiver: Any, folder: Path, view_layer: str | None = None) -> tuple[Floats, Floats]:
    """The mean colours of the world and of the only layer before it, each (3,)."""
    with scratch_scene(context.scene, view_layer) as scratch:
        found = look_around(scratch, [receiver], MIDDLE, 1.0, folder, 0)
    assert len(found.layers) == 1
    total = found.layers[0].pictures.levels[0].sum(axis=(0, 1))
    assert total[3] > 1
    return found.world.levels[0].mean(axis=(0, 1)), total[:3] / total[3]


@pytest.mark.one_blender
def test_the_surroundings_are_as_a_mirror_sees_them(tmp_path: Path) -> None:
    """To cameras the world is red and the cube is not there; to glossy rays the world is green.

    The cube is there as an instance: in its layer, and not in the world.
    """
    receiver = ball()
    made = stage.world((1, 0, 0))
    tree: Any = made.node_tree
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMixRGB")
    mix.inputs[1].default_value, mix.inputs[2].default_value = (0, 1, 0, 1), (1, 0, 0, 1)
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs["Fac"])
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(mix.outputs[0], background.inputs["Color"])
    box = cube("Box", (0, 0, 0))
    box.data.materials.append(stage.material("Blue", "ShaderNodeEmission", Color=(0, 0, 1, 1)))
    moved(box, "Boxes").hide_render = True
    shown = bpy.data.collections.new("Shown")
    shown.objects.link(box)
    bpy.ops.object.collection_instance_add(collection="Shown", location=(3, 0, 4))
    box.visible_camera = context.object.visible_camera = False
    before = fingerprint()
    world, thing = seen_around(receiver, tmp_path)
    assert differences(before, fingerprint()) == {}
    np.testing.assert_allclose(world, [0, 1, 0], atol=1e-3)
    np.testing.assert_allclose(thing, [0, 0, 1], atol=0.1)


def test_a_card_that_hides_from_the_camera_by_its_material_is_mirrored(tmp_path: Path) -> None:
    """It is transparent to cameras, red to them behind glass, blue in mirrors; in the second view layer."""
    receiver = ball()
    stage.world((0, 0, 0))
    material = stage.material("Card", "ShaderNodeEmission", Color=(0, 0, 1, 1))
    tree: Any = material.node_tree
    glow = next(node for node in tree.nodes if node.type == "EMISSION")
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMixRGB")
    mix.inputs[1].default_value, mix.inputs[2].default_value = (1, 0, 0, 1), (0, 0, 1, 1)
    tree.links.new(path.outputs["Is Glossy Ray"], mix.inputs["Fac"])
    tree.links.new(mix.outputs[0], glow.inputs["Color"])
    clear, either = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(path.outputs["Is Camera Ray"], either.inputs[0])
    tree.links.new(glow.outputs[0], either.inputs[1])
    tree.links.new(clear.outputs[0], either.inputs[2])
    tree.links.new(either.outputs[0], output.inputs["Surface"])
    cube("Card", (3, 0, 4)).data.materials.append(material)
    context.scene.view_layers.new("Second")
    before = fingerprint()
    np.testing.assert_allclose(seen_around(receiver, tmp_path, "Second")[1], [0, 0, 1], atol=0.1)
    assert differences(before, fingerprint()) == {}


@pytest.mark.one_blender
def test_a_glowing_thing_that_does_not_light_the_object_is_dark_in_it(tmp_path: Path) -> None:
    """As Cycles shows it: a mirror that light linking leaves out mirrors the thing without its light."""
    receiver = ball()
    stage.world((0, 0, 0))
    box = cube("Box", (3, 0, 4))
    box.data.materials.append(stage.material("Blue", "ShaderNodeEmission", Color=(0, 0, 1, 1)))
    linked = bpy.data.collections.new("Receivers")
    linked.objects.link(receiver)
    box.light_linking.receiver_collection = linked
    assert seen_around(receiver, tmp_path)[1][2] > 0.9
    linked.collection_objects[0].light_linking.link_state = "EXCLUDE"
    before = fingerprint()
    assert not seen_around(receiver, tmp_path)[1].any()
    assert differences(before, fingerprint()) == {}


def test_the_portals_stand_above_what_only_renders_show() -> None:
    cube("Tower", (0, 0, 0)).hide_viewport = True
    context.object.location.z = 500
    with scratch_scene(context.scene) as scratch:
        assert top_of_render(scratch) == pytest.approx(500.5)


def test_checks_know_where_things_are_that_the_viewport_hides() -> None:
    """Fog and content that are hidden in views, moved around the hull or away from it."""
    hull = cube("Hull", (9, 0, 0))
    fog = stage.material("Fog", "ShaderNodeBsdfDiffuse")
    tree: Any = fog.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    for name in ("Around", "Excluded"):
        item = cube(name, (0, 0, 0))
        item.data.materials.append(fog)
        item.hide_viewport, item.location.x = True, 9
        if name == "Excluded":
            moved(item, "off").hide_render = True
    assert volumes_around(context.view_layer, hull) == ["Around"]
    assert [item.name for item in find_content(context.view_layer, hull, None)] == ["Around"]


def test_the_first_sun_is_one_that_renders() -> None:
    moved(lamp("A", (0, 0, 1), "SUN"), "off").hide_render = True
    excluded(lamp("B", (0, 0, 1), "SUN"))
    lamp("C", (0, 0, 1), "SUN")
    found = first_sun(context.scene)
    assert found is not None
    assert found.name == "C"


def hidden(place: tuple[float, float, float], receiver: Any, item: Any = None) -> bool:
    """Whether a small lamp at a place is hidden from the upper half of the ball."""
    if item is None:
        item = bpy.data.objects["Asked"] if "Asked" in bpy.data.objects else lamp("Asked", (0, 0, 90))
    direction = np.random.default_rng(3).normal(size=(200, 3))
    direction[:, 2] = np.abs(direction[:, 2])
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    asked = [HideableLamp(item, np.array(place, float), 0.1)]
    with scratch_scene(context.scene) as scratch:
        return bool(hidden_lamps(scratch, [receiver], MIDDLE + direction, direction, asked)[0] > 0.5)


def test_a_lamp_behind_a_wall_is_hidden_and_one_before_it_is_not() -> None:
    receiver = ball()
    wall = floor("Wall", 8, size=20)
    assert hidden((0, 0, 12), receiver)
    assert not hidden((0, 0, 7), receiver)
    assert not hidden((0, 0, 8.05), receiver), "a wall that a lamp is set into does not hide it"
    wall.visible_shadow = False
    assert not hidden((0, 0, 12), receiver)
    wall.visible_shadow = True
    wall.data.materials.append(stage.material("Pane", "ShaderNodeBsdfGlass"))
    assert not hidden((0, 0, 12), receiver)


def test_a_near_wall_hides_the_sun() -> None:
    receiver = ball()
    floor("Wall", 5.5, size=20)
    assert hidden((0, 0, 1e4), receiver), "the wall is half a unit away, and a sun ten thousand"


def test_a_pane_in_a_wall_of_the_same_mesh_does_not_make_the_wall_clear() -> None:
    receiver = ball()
    wall = floor("Wall", 8, size=20, subdivisions=8).data
    wall.materials.append(stage.material("Plaster", "ShaderNodeBsdfDiffuse"))
    wall.materials.append(stage.material("Pane", "ShaderNodeBsdfGlass"))
    wall.polygons[0].material_index = 1
    assert hidden((0, 0, 12), receiver)
    for face in wall.polygons:
        face.material_index = 1 - face.material_index
    assert not hidden((0, 0, 12), receiver)


def test_a_lamp_without_shadows_shines_through_walls() -> None:
    receiver = ball()
    wall = floor("Wall", 8, size=20)
    asked = lamp("Asked", (0, 0, 90))
    asked.data.use_shadow = False
    assert not hidden((0, 0, 12), receiver)
    asked.data.use_shadow = True
    assert hidden((0, 0, 12), receiver)
    asked.light_linking.blocker_collection = bpy.data.collections.new("Blockers")
    asked.light_linking.blocker_collection.objects.link(receiver)
    assert not hidden((0, 0, 12), receiver), "shadow linking leaves the wall out"
    asked.light_linking.blocker_collection.objects.link(wall)
    assert hidden((0, 0, 12), receiver)


def test_instances_hide_lamps_and_the_object_itself_does_not() -> None:
    receiver = ball()
    receiver.scale.z = 0.1
    wall = moved(floor("Wall", 0, size=20), "Walls")
    context.view_layer.layer_collection.children[wall.name].exclude = True
    assert not hidden((0, 0, 12), receiver)
    bpy.ops.object.collection_instance_add(collection="Walls", location=(0, 0, 8), rotation=(0.2, 0, 0))
    assert hidden((0, 0, 12), receiver)
    assert not hidden((0, 0, 6), receiver)


@pytest.mark.one_blender
def test_an_object_that_stands_in_a_plane_looks_at_it_from_above() -> None:
    plane = _seen_from_above(np.array([0, 0, 1.0]), 4.0, MIDDLE, 1.0)
    assert plane.height == 0
    assert plane.eye[2] == pytest.approx(0.5)
    plane = _seen_from_above(np.array([0, 0, 1.0]), 2.0, MIDDLE, 1.0)
    assert (plane.height, plane.eye[2]) == (-2, 2)
