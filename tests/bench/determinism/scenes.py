# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes with much of what a renderer could take in another order: lamps, lights, instances, materials.

Each is built into an empty file; what is baked is called BODY, and what may be baked onto it CORE.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin
from typing import Any

import bpy

from tests.blender import stage

BODY, CORE = "Body", "Core"
context: Any = bpy.context  # to the stubs, every pointer may be None


def lamps() -> None:
    """Twelve lamps of all kinds, two of them of one data-block."""
    _room()
    kinds = ("POINT", "SPOT", "AREA", "SUN", "POINT", "AREA")
    names = ("Zinc", "Point", "Area", "Opal", "Iron", "Tin", "Jade", "Brass", "Amber", "Lead", "Ruby", "Gold")
    add_lamp: Any = bpy.ops.object.light_add  # to the stubs its type is a literal
    for number, kind in enumerate(2 * kinds):
        angle = 0.7 + number * 2.4
        turned = (0.3 * sin(angle), 0.3 * cos(angle), 0)
        add_lamp(type=kind, location=(3 * cos(angle), 3 * sin(angle), 2 + number % 3), rotation=turned)
        lamp = context.object
        lamp.name = names[number]
        lamp.data.energy = 1.0 if kind == "SUN" else 60 + 10 * number
        lamp.data.color = (0.5 + 0.5 * sin(angle), 0.7, 0.5 + 0.5 * cos(angle))
    twin = bpy.data.objects.new("Twin lamp", bpy.data.objects["Area"].data)
    twin.location = (0, -3, 3)
    context.scene.collection.objects.link(twin)


def lamps_without_tree() -> None:
    """The same, chosen from without a light tree."""
    lamps()
    context.scene.cycles.use_light_tree = False


def glowing() -> None:
    """Six glowing meshes, three of which share their mesh, in collections, and two lamps."""
    _room()
    stage.lamps()
    shared = None
    for number in range(6):
        angle = 0.3 + number * 2.1
        bpy.ops.mesh.primitive_ico_sphere_add(
            subdivisions=1 + number % 2, radius=0.3, location=(2.5 * cos(angle), 2.5 * sin(angle), 1.5)
        )
        item = context.object
        item.name = f"{'MNBVCX'[number]} glow"
        if number % 2 and shared is not None:
            item.data = shared
            item.scale = (1, 1.5, 0.7)
        else:
            tint = (0.2 + 0.15 * number, 0.8 - 0.1 * number, 0.5, 1)
            glow = stage.material(f"glow {number}", "ShaderNodeEmission", Color=tint, Strength=4.0 + number)
            item.data.materials.append(glow)
            shared = item.data
        _move(item, f"{'zyx'[number % 3]} group")


def instances() -> None:
    """Lamps and glowing meshes instanced by a collection, by faces, by particles, by geometry nodes; hair."""
    _room()
    stage.lamps()
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 0.5))
    lamp = context.object
    lamp.data.energy = 20
    bpy.ops.mesh.primitive_cube_add(size=0.3)
    cube = context.object
    cube.name = "Little cube"
    glow = stage.material("cube glow", "ShaderNodeEmission", Color=(1, 0.6, 0.2, 1), Strength=3.0)
    cube.data.materials.append(glow)
    for item in (lamp, cube):
        _move(item, "inner")
    inner = bpy.data.collections["inner"]
    context.scene.collection.children.unlink(inner)
    for number in range(3):
        bpy.ops.object.empty_add(location=(2.5 - 2.5 * number, 2.5, 1))
        empty = context.object
        empty.name = f"{'LAG'[number]} empty"
        empty.instance_type, empty.instance_collection = "COLLECTION", inner
    bpy.ops.mesh.primitive_plane_add(size=3, location=(0, -3, 1))
    giver = context.object
    giver.name = "Particles"
    giver.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = giver.particle_systems[0].settings
    settings.count, settings.frame_end, settings.render_type = 12, 1, "COLLECTION"
    settings.instance_collection, settings.particle_size = inner, 0.3
    bpy.ops.mesh.primitive_plane_add(size=2, location=(-3, 0, 1))
    furry = context.object
    furry.name = "Fur"
    furry.modifiers.new("Hair", "PARTICLE_SYSTEM")
    hair = furry.particle_systems[0].settings
    hair.type, hair.count, hair.hair_length = "HAIR", 200, 0.4
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3, size=3, location=(3, -1, 1))
    _scatter(context.object, cube)
    context.scene.frame_set(3)


def volumes() -> None:
    """A cloud, a fog that fills the world, and lamps."""
    _room()
    stage.lamps()
    stage.world((0.3, 0.4, 0.5))
    tree = context.scene.world.node_tree
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    fog.inputs["Density"].default_value = 0.02
    output = next(node for node in tree.nodes if node.type == "OUTPUT_WORLD")
    tree.links.new(fog.outputs[0], output.inputs["Volume"])
    for number in range(2):
        bpy.ops.mesh.primitive_cube_add(size=1.5, location=(2.2 - 4.4 * number, 1, 1))
        item = context.object
        item.name = f"{'TC'[number]} cloud"
        cloud = stage.material(f"cloud {number}", "ShaderNodeVolumePrincipled", Density=0.5 + number)
        link = cloud.node_tree.links[0]
        links, output = cloud.node_tree.links, link.to_node
        links.remove(link)
        source = next(n for n in cloud.node_tree.nodes if n.type == "PRINCIPLED_VOLUME")
        links.new(source.outputs[0], output.inputs["Volume"])
        item.data.materials.append(cloud)


def large() -> None:
    """Meshes of more than 10,000 faces, on which Blender works in several threads: smooth, glowing."""
    _room()
    stage.lamps()
    smooth: Any = bpy.data.objects[BODY].modifiers.new("Subdivision", "SUBSURF")
    smooth.render_levels = 3
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6, radius=0.5, location=(2, -2, 1))
    context.object.name = "Glow"
    context.object.data.materials.append(
        stage.material("glow", "ShaderNodeEmission", Color=(1, 0.8, 0.5, 1), Strength=5.0)
    )
    bpy.ops.mesh.primitive_monkey_add(location=(-2, -2, 0.5))
    bpy.ops.object.shade_smooth()
    context.object.modifiers.new("Subdivision", "SUBSURF").render_levels = 3


def normal_mapped() -> None:
    """The same, and the head has a normal map, for which Cycles needs tangents."""
    large()
    skin = stage.material("skin", "ShaderNodeBsdfPrincipled", Roughness=0.2, Metallic=1.0)
    tree = skin.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    bump, noise = tree.nodes.new("ShaderNodeNormalMap"), tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], bump.inputs["Color"])
    tree.links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    bpy.data.objects["Suzanne"].data.materials.append(skin)


SCENES: dict[str, Callable[[], None]] = {
    "lamps": lamps,
    "lamps, no tree": lamps_without_tree,
    "glowing meshes": glowing,
    "instances": instances,
    "volumes": volumes,
    "large meshes": large,
    "normal map": normal_mapped,
}


def build(name: str) -> None:
    """Build one of the scenes into an empty file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    context.scene.render.engine = "CYCLES"
    SCENES[name]()
    context.view_layer.update()


def _room() -> None:
    """A floor and a body of two materials under a picture of a sky."""
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 0, -1))
    context.object.name = "Floor"
    context.object.data.materials.append(
        stage.material("floor", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.5, 0.4, 1))
    )
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8)
    bpy.ops.object.shade_smooth()
    body = context.object
    body.name = BODY
    rough = stage.material("clay", "ShaderNodeBsdfPrincipled", Roughness=0.6)
    shiny = stage.material("steel", "ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=0.2)
    for made in (rough, shiny):
        body.data.materials.append(made)
    for polygon in body.data.polygons:
        polygon.material_index = int(polygon.center.z > 0.2)
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.97)  # a finer shape that is baked onto the body
    context.object.name = CORE
    context.object.data.materials.append(rough)
    for number in range(3):
        bpy.ops.mesh.primitive_cube_add(size=0.8, location=(2.0 - 2 * number, 2.0, -0.5))
        context.object.name = f"{'BZK'[number]} block"
        tint = (0.9 - 0.3 * number, 0.2 + 0.3 * number, 0.4, 1)
        context.object.data.materials.append(
            stage.material(f"block {number}", "ShaderNodeBsdfDiffuse", Color=tint)
        )
    stage.hdri(stage.world())


def _move(item: Any, name: str) -> None:
    """Into a collection of that name, made when it is first called."""
    collection = bpy.data.collections.get(name)
    if collection is None:
        collection = bpy.data.collections.new(name)
        context.scene.collection.children.link(collection)
    for home in item.users_collection:
        home.objects.unlink(item)
    collection.objects.link(item)


def _scatter(item: Any, what: Any) -> None:
    """Instance an object on a mesh's vertices, by geometry nodes."""
    item.name = "Scattered"
    group: Any = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    given, made = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    scatter, info = group.nodes.new("GeometryNodeInstanceOnPoints"), group.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = what
    group.links.new(given.outputs[0], scatter.inputs["Points"])
    group.links.new(info.outputs["Geometry"], scatter.inputs["Instance"])
    group.links.new(scatter.outputs[0], made.inputs[0])
    item.modifiers.new("Scatter", "NODES").node_group = group
