# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo's scene: a glossy head among three balls on a checkered floor, under an HDRI that Blender ships.

The floor and the balls are near enough for parallax; the head is curved and folded; its gold is so rough that
buckets of a few cells can hold its reflections.
"""

from __future__ import annotations

from math import cos, sin
from pathlib import Path
from typing import Any, cast

import bpy
from mathutils import Vector

from ..core.errors import InputError
from .nodes import open_material, open_world

OBJECT = "Suzanne"


def build_demo_scene(roughness: float = 0.3) -> bpy.types.Scene:
    """Empty the open file and build the demo in it; returns the scene. Raises InputError without the HDRI."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    cast(Any, scene.render).engine = "CYCLES"  # the stubs lack add-ons' engines
    scene.world = _world("courtyard.exr")
    bpy.ops.mesh.primitive_plane_add(size=10, location=(0, 0, -1))
    bpy.context.object.name = "Floor"
    bpy.context.object.data.materials.append(_checker())
    for index in range(3):
        angle = index * 2.1 + 0.9
        bpy.ops.mesh.primitive_uv_sphere_add(location=(cos(angle) * 2.4, abs(sin(angle)) * 2.4, 0))
        bpy.ops.object.shade_smooth()
        colour = [0.05, 0.05, 0.05, 1.0]
        colour[index] = 0.9
        bpy.context.object.data.materials.append(_principled(f"Ball {index + 1}", tuple(colour)))
    bpy.ops.mesh.primitive_monkey_add()
    head = bpy.context.object
    head.name = OBJECT
    subdivision = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    bpy.ops.object.shade_smooth()
    gold = _principled("Gold", (0.9, 0.6, 0.2, 1), metallic=1.0, roughness=roughness)
    head.data.materials.append(gold)
    scene.camera = add_camera(scene, (1.6, -3.4, 0.9))
    return scene


def add_camera(scene: bpy.types.Scene, place: tuple[float, float, float]) -> bpy.types.Object:
    """A camera at `place` that looks at the origin."""
    data = bpy.data.cameras.new("Camera")
    camera = bpy.data.objects.new("Camera", data)
    camera.location = place
    camera.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    return camera


def _world(name: str) -> bpy.types.World:
    resource = cast(Any, bpy.utils).system_resource  # missing in the stubs
    folder: str = resource("DATAFILES", path="studiolights/world")
    path = Path(folder, name)
    if not folder or not path.exists():
        raise InputError(f"the demo needs an HDRI that Blender ships, and this Blender has no {name}")
    world, build = open_world("Courtyard")
    image: Any = bpy.data.images.load(str(path))
    environment = build.node("ShaderNodeTexEnvironment", image=image)
    background = build.node("ShaderNodeBackground", environment.outputs["Color"], 1.0)
    build.node("ShaderNodeOutputWorld", background.outputs[0])
    build.arrange()
    # Importance map as fine as the picture: Cycles' default is finer, and delays each render by a second.
    settings = cast(Any, world).cycles
    settings.sampling_method, settings.sample_map_resolution = "MANUAL", image.size[0]
    return world


def _principled(
    name: str, colour: tuple[float, ...], metallic: float = 0.0, roughness: float = 0.5
) -> bpy.types.Material:
    material, build = open_material(name)
    shader = build.node("ShaderNodeBsdfPrincipled")
    for socket, value in (("Base Color", colour), ("Metallic", metallic), ("Roughness", roughness)):
        build.feed(shader.inputs[socket], value)
    build.node("ShaderNodeOutputMaterial", shader.outputs[0])
    build.arrange()
    return material


def _checker() -> bpy.types.Material:
    material = _principled("Checker", (0.4, 0.4, 0.4, 1))
    tree = material.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Color1"].default_value = (0.55, 0.55, 0.55, 1)
    checker.inputs["Color2"].default_value = (0.12, 0.12, 0.14, 1)
    checker.inputs["Scale"].default_value = 10
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], shader.inputs["Base Color"])
    return material
