# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that take the place of instances look as these do, and nothing is lost with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.exr import read_pixels
from radtex_addon.job.instances import Joined, join_instances
from radtex_addon.scene.checks.own_coordinates import reads_its_place
from radtex_addon.scene.geometry_digests import mesh_digest
from tests.blender import stage

context: Any = bpy.context
COLOURS = {"Red": (1.0, 0.1, 0.1, 1.0), "Green": (0.1, 1.0, 0.1, 1.0), "Blue": (0.1, 0.1, 1.0, 1.0)}


def glow(name: str) -> bpy.types.Material:
    """A material that shines in one colour, so that a picture has no noise."""
    return stage.material(name, "ShaderNodeEmission", Color=COLOURS[name])


def normals() -> bpy.types.Material:
    """A material that shows which way its surface faces: one that is inside out looks different."""
    made = stage.material("Normals", "ShaderNodeEmission")
    nodes: Any = made.node_tree
    tree = nodes.nodes
    nodes.links.new(
        tree.new("ShaderNodeNewGeometry").outputs["Backfacing"], tree["Emission"].inputs["Strength"]
    )
    return made


def moved(item: Any, home: bpy.types.Collection) -> Any:
    for each in item.users_collection:
        each.objects.unlink(item)
    home.objects.link(item)
    return item


def cube(name: str, home: bpy.types.Collection, at: tuple[float, float, float], size: float = 1) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=size, location=at)
    context.object.name = name
    return moved(context.object, home)


def empty(name: str, of: bpy.types.Collection, x: float, mirrored: bool = False) -> Any:
    made = bpy.data.objects.new(name, None)
    made.instance_type, made.instance_collection = "COLLECTION", of
    made.location.x, made.scale.x = x, -1 if mirrored else 1
    context.scene.collection.objects.link(made)
    return made


def chair() -> bpy.types.Collection:
    """A collection of what joining could spoil.

    It has a seat whose material is the object's and which only renders subdivide, a text, a nested mirrored
    instance of a mesh with another UV layer, a lamp, and a cutter that does not render; its middle is off.
    """
    parts, nested = bpy.data.collections.new("Chair"), bpy.data.collections.new("Nested")
    seat = cube("Seat", parts, (0, 0, 0.5))
    seat.data.materials.append(None)
    seat.material_slots[0].link = "OBJECT"
    seat.material_slots[0].material = glow("Red")
    rounded = seat.modifiers.new("Rounded", "SUBSURF")
    rounded.levels, rounded.render_levels = 0, 2
    bpy.ops.object.text_add(location=(-0.4, -0.8, 0.5), rotation=(1.5708, 0, 0))
    context.object.data.body = "Hi"
    context.object.data.materials.append(glow("Blue"))
    moved(context.object, parts)
    arm = cube("Arm", nested, (0.3, 0, 1.2), 0.4)
    arm.data.materials.append(normals())
    arm.data.uv_layers[0].name = "Another"
    inner = bpy.data.objects.new("Inner", None)
    inner.instance_type, inner.instance_collection, inner.scale.y = "COLLECTION", nested, -1
    parts.objects.link(inner)
    lamp = bpy.data.objects.new("Bulb", bpy.data.lights.new("Bulb", "POINT"))
    lamp.location = (0.0, 0.0, 3.0)
    parts.objects.link(lamp)
    cube("Cutter", parts, (0, 0, 0), 3).hide_render = True
    parts.instance_offset = (0.1, 0, 0)
    return parts


def scatter(of: Any) -> Any:
    """A plane on each of whose corners geometry nodes put an instance of an object, turned as it will."""
    bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 1, 0))
    made: Any = context.object
    made.name = "Tray"
    made.data.materials.append(glow("Green"))
    group: Any = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    names = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo")
    begin, end, place, info = (group.nodes.new(name) for name in names)
    join = group.nodes.new("GeometryNodeJoinGeometry")
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = of, True
    place.inputs["Scale"].default_value = (0.3, 0.3, -0.6)
    for first, second in (
        (begin.outputs[0], place.inputs["Points"]),
        (info.outputs["Geometry"], place.inputs["Instance"]),
        (begin.outputs[0], join.inputs[0]),
        (place.outputs[0], join.inputs[0]),
        (join.outputs[0], end.inputs[0]),
    ):
        group.links.new(first, second)
    made.modifiers.new("Scatter", "NODES").node_group = group
    return made


def picture(out: Path) -> Floats:
    """What Cycles renders of the scene, (40, 64, 3)."""
    scene = context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 40, 100
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", str(out / "picture.exr")
    bpy.ops.render.render(write_still=True)
    return read_pixels(out / "picture.exr", 64, 40)[..., :3]


@pytest.fixture
def _seen() -> None:
    lens = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    lens.location, lens.rotation_euler = (0.0, -7.0, 4.0), (1.1, 0.0, 0.0)
    context.scene.collection.objects.link(lens)
    context.scene.camera = lens
    stage.world((0.2, 0.2, 0.2))


def joined(*items: Any) -> tuple[list[Joined], list[str]]:
    made, messages = join_instances(context.scene, items)
    return made, [message.problem for message in messages]


@pytest.mark.usefixtures("_seen")
def test_joined_meshes_look_as_the_instances_did(out: Path) -> None:
    parts = chair()
    items = [empty("Left", parts, -1.5), empty("Right", parts, 1.5, mirrored=True)]
    hidden = bpy.data.collections.new("Hidden")  # of no scene
    pebble = cube("Pebble", hidden, (0, 0, 0))
    pebble.data.materials.append(normals())
    items.append(scatter(pebble))
    before = picture(out)
    made, messages = joined(*items)
    assert not messages
    assert [(one.name, one.objects) for one in made] == [
        ("Left", ("Left", "Left Arm")),
        ("Right", ("Right", "Right Arm")),
        ("Tray", ("Tray",)),
    ]
    after = picture(out)
    assert np.abs(after - before).max() < 0.02, "edges of pixels aside"
    assert before.std() > 0.1
    assert "Left Bulb" in context.scene.objects


def wig(parts: bpy.types.Collection) -> str:
    parts.objects.link(bpy.data.objects.new("Wig", bpy.data.hair_curves.new("Hair")))
    return "it shows hair, 'Wig'"


def combed(parts: bpy.types.Collection) -> str:
    head = cube("Head", parts, (0, 0, 1))
    head.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings.type = "HAIR"
    return "'Head' has hair"


def told_by_instancer(parts: bpy.types.Collection) -> str:
    told = glow("Red")
    tree: Any = told.node_tree
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type = "INSTANCER"
    tree.links.new(node.outputs["Color"], tree.nodes["Emission"].inputs["Color"])
    cube("Told", parts, (0, 0, 1)).data.materials.append(told)
    return "a material of 'Told' reads what its instancer tells"


@pytest.mark.parametrize("add", [wig, combed, told_by_instancer])
def test_what_cannot_be_a_mesh_stays_and_a_line_says_why(add: Any) -> None:
    parts = bpy.data.collections.new("Parts")
    cube("Seat", parts, (0, 0, 0))
    why = add(parts)
    owner = empty("Doll", parts, 0)
    made, messages = joined(owner)
    assert (made, messages) == ([], [f"the instances that 'Doll' shows are not baked: {why}"])
    assert (owner.name, owner.hide_render) == ("Doll", False)


def checks(name: str, node: str, output: str | int, **settings: Any) -> bpy.types.Material:
    """A material that glows as a node says."""
    made = stage.material(name, "ShaderNodeEmission")
    tree: Any = made.node_tree
    read = tree.nodes.new(node)
    for key, value in settings.items():
        setattr(read, key, value)
    tree.links.new(read.outputs[output], tree.nodes["Emission"].inputs["Color"])
    return made


@pytest.mark.parametrize(
    ("node", "output", "settings", "reads"),
    [
        ("ShaderNodeTexChecker", 0, {}, True),
        ("ShaderNodeTexImage", 0, {}, False),
        ("ShaderNodeTexImage", 0, {"projection": "BOX"}, True),
        ("ShaderNodeTexCoord", "UV", {}, False),
        ("ShaderNodeTexCoord", "Object", {}, True),
        ("ShaderNodeNewGeometry", "Normal", {}, False),
        ("ShaderNodeNewGeometry", "Random Per Island", {}, True),
        ("ShaderNodeAmbientOcclusion", 0, {"only_local": True}, True),
        ("ShaderNodeAttribute", 0, {"attribute_type": "OBJECT"}, True),
        ("ShaderNodeAttribute", 0, {"attribute_type": "GEOMETRY"}, False),
    ],
)
def test_which_materials_read_their_objects_place(
    node: str, output: str | int, settings: dict[str, Any], reads: bool
) -> None:
    assert reads_its_place(checks("Checks", node, output, **settings)) == reads


@pytest.mark.usefixtures("_seen")
def test_parts_whose_materials_read_their_objects_place_stay_apart(out: Path) -> None:
    parts = bpy.data.collections.new("Parts")
    told = checks("Told", "ShaderNodeAttribute", "Color", attribute_type="OBJECT", attribute_name="paint")
    looks = (glow("Red"), checks("Checks", "ShaderNodeTexChecker", 0), told)
    for number, look in enumerate(looks):
        part = cube(f"Part {number}", parts, (1.5 * number - 1.5, 0, 0))
        part.data.materials.append(look)
        part["paint"] = (0.2, 0.9, 0.4)
    owner = empty("Owner", parts, 0.5)
    before = picture(out)
    made, _ = joined(owner)
    assert made[0].objects == ("Owner", "Owner Part 1", "Owner Part 2")
    assert context.scene.objects["Owner Part 2"].matrix_world.translation.x == 2
    assert np.abs(picture(out) - before).max() < 0.02
    context.scene.objects["Owner Part 1"].modifiers.new("Rounded", "BEVEL")
    parts.objects["Part 1"].modifiers.new("Rounded", "BEVEL")
    assert "'Part 1' has modifiers" in joined(empty("Another", parts, 0))[1][0]


def test_what_has_no_extent_or_another_linking_is_no_obstacle() -> None:
    parts = bpy.data.collections.new("Parts")
    for name, scale in (("Seat", (1, 1, 1)), ("Flat", (1, 1, 0)), ("Dot", (0, 0, 0))):
        cube(name, parts, (0, 0, 0)).scale = scale
    lit = cube("Lit", parts, (2, 0, 0))
    lit.light_linking.receiver_collection = bpy.data.collections.new("Receivers")
    owner = empty("N" * 63, parts, 5)
    made, messages = joined(owner)
    assert not messages
    assert made[0].objects == ("N" * 63, context.scene.objects[-1].name)
    mesh = context.scene.objects["N" * 63].data
    assert len(mesh.polygons) == 24, "a cube and a flat one"
    assert np.isfinite([corner.vector for corner in mesh.corner_normals]).all()
    assert context.scene.objects[-1].light_linking.receiver_collection.name == "Receivers"
    assert owner.hide_render


def test_what_bevels_made_is_known_again() -> None:
    parts = bpy.data.collections.new("Parts")
    cube("Seat", parts, (0, 0, 0)).modifiers.new("Bevel", "BEVEL")
    joined(empty("Left", parts, 0), empty("Right", parts, 4))
    left, right = (stage.read(context.scene.objects[name]) for name in ("Left", "Right"))
    assert left.made_of
    assert mesh_digest(left) == mesh_digest(right)
