# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, and plans for captures that need no unwrap."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import orthonormal_frame
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.scene.uv.unwrap_options import AtlasUnwrap, UnwrapOptions
from radtex_addon.settings.spec import Unwrap


def read(item: Any) -> EvaluatedMesh:
    """An object's mesh as a bake evaluates it."""
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch:
        return evaluate(scratch, item)


def unwrapped(
    mesh: EvaluatedMesh, texels: int, options: UnwrapOptions | None = None, method: Unwrap = Unwrap.XATLAS
) -> AtlasUnwrap:
    """The mesh's unwrap, without progress."""
    return finished(unwrap_steps(mesh, texels, method, options))


def material(name: str, shader: str, **inputs: object) -> bpy.types.Material:
    """A material of one shader node; inputs by name, blanks as underscores."""
    made = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(shader)
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def world(colour: tuple[float, float, float] = (1, 1, 1)) -> bpy.types.World:
    """A new world of one colour, set on the scene."""
    made = bpy.data.worlds.new("World")
    if made.node_tree is None:
        made.use_nodes = True
    next(n for n in made.node_tree.nodes if n.type == "BACKGROUND").inputs["Color"].default_value = (
        *colour,
        1,
    )
    bpy.context.scene.world = made
    return made


def hdri(made: bpy.types.World) -> None:
    """Light a world by one of the HDRIs that Blender ships.

    Cycles samples it by a map as fine as the picture: its own choice costs each scene a second more.
    """
    path = Path(bpy.utils.resource_path("LOCAL")) / "datafiles" / "studiolights" / "world" / "courtyard.exr"
    environment = made.node_tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = bpy.data.images.load(str(path))
    sampling: Any = made.cycles
    sampling.sampling_method, sampling.sample_map_resolution = "MANUAL", environment.image.size[0]
    background = next(n for n in made.node_tree.nodes if n.type == "BACKGROUND")
    made.node_tree.links.new(environment.outputs["Color"], background.inputs["Color"])


def lamps() -> None:
    """An area lamp and a point lamp with a size, both above the origin."""
    bpy.ops.object.light_add(type="AREA", location=(1, 0.5, 2), rotation=(0.2, 0.4, 0))
    bpy.context.object.data.size, bpy.context.object.data.energy = 1, 100
    bpy.ops.object.light_add(type="POINT", location=(-1, -0.5, 1.5))
    bpy.context.object.data.shadow_soft_size, bpy.context.object.data.energy = 0.3, 50


def clamps_off() -> None:
    """No light is cut away."""
    cycles = bpy.context.scene.cycles
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0


def plan_of(
    position: Floats, normal: Floats, bucket: int, tangent: Floats | None = None, sign: float = 1
) -> CapturePlan:
    """A plan of one row of texels at positions (K, 3) with unit normals (K, 3)."""
    count = len(position)
    tangent = np.zeros((count, 3)) if tangent is None else tangent
    t, b, n = orthonormal_frame(normal.astype(float), tangent.astype(float), np.full(count, float(sign)))
    fields = [f.astype(np.float32).reshape(1, count, 3) for f in (position, t, b, n, n)]
    return CapturePlan(AtlasLayout(count, 1, bucket), np.arange(count), *fields)
