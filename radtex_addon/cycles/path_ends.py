# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene in which light says where it comes from: everything but the baked object emits its own direction.

The object keeps its materials, so paths go through it as they do in the user's scene; but what they bring back
is the direction, seen from the object's middle, of the point where they left it for good. The same paths, traced
again where everything emits white, bring back what the object lets through.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..scene.copy import copy_object
from ..scene.nodes import NodeBuilder, open_group, close_group, open_material, open_world

_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


class PathEnds:
    """The scene, and what everything but the baked object emits in it."""

    def __init__(
        self, scene: bpy.types.Scene, baked: bpy.types.Object, group: bpy.types.ShaderNodeTree
    ) -> None:
        self.scene, self._baked, self._group = scene, baked, group

    def blacken_object(self) -> None:
        """End, from now on, all paths that meet the object."""
        mesh = cast(bpy.types.Mesh, cast(bpy.types.ID, self._baked.data).copy())
        mesh.materials.clear()
        material, build = open_material("RadTex black")
        black = build.node("ShaderNodeBsdfDiffuse", (0.0, 0.0, 0.0, 1.0))
        build.node("ShaderNodeOutputMaterial", black.outputs[0])
        mesh.materials.append(material)
        self._baked.data = mesh

    def emit_directions(self, turn: int) -> None:
        """Emit directions d as d / 2 + 1/2, their components moved on by `turn` places among red, green, blue."""
        self._write(0.0, turn)

    def emit_white(self) -> None:
        """Emit (1, 1, 1)."""
        self._write(1.0, 0)

    def _write(self, white: float, turn: int) -> None:
        value = next(node for node in self._group.nodes if node.label == "white")
        cast(Any, value).outputs[0].default_value = white
        for index in range(3):
            node = next(node for node in self._group.nodes if node.label == f"turn {index}")
            cast(Any, node).outputs[0].default_value = float(index == turn)


def from_directions(emitted: Floats, white: Floats, turn: int) -> Floats:
    """Directions (..., 3), not of unit length where paths differ, from what was brought back (..., 3) of both."""
    shared = np.divide(emitted, white, out=np.full_like(emitted, 0.5), where=white > 0)
    return np.roll(shared * 2 - 1, -turn, axis=-1)


@contextmanager
def path_ends(
    scratch: bpy.types.Scene, baked: bpy.types.Object, mesh: bpy.types.Mesh, middle: Floats
) -> Iterator[PathEnds]:
    """Build the scene from `scratch`, a scratch scene: a copy of `baked` that shows `mesh`, and all else.

    `middle` (3,) is the point that directions are seen from. What is made is removed with the scratch scene's
    other data.
    """
    layer = next(layer for layer in scratch.view_layers if layer.use)
    layer.update()
    group = _light_group()
    scene = cast(bpy.types.Scene, scratch.copy())
    try:
        root = scene.collection
        for collection in list(root.children):
            root.children.unlink(collection)
        for item in list(root.objects):
            root.objects.unlink(item)
        scene.world = _world(group)
        copy = copy_object(baked, mesh)
        root.objects.link(copy)
        glow = _glow(group, middle)
        _copy_others(scene, layer.depsgraph, baked, glow)
        yield PathEnds(scene, copy, group)
    finally:
        bpy.data.scenes.remove(scene)


def _copy_others(
    scene: bpy.types.Scene, graph: bpy.types.Depsgraph, baked: bpy.types.Object, glow: bpy.types.Material
) -> None:
    """Copy what else renders as meshes that glow; what has no faces is left out."""
    meshes: dict[int, bpy.types.Mesh | None] = {}
    found = []
    for instance in graph.object_instances:
        item = instance.object
        original = item.original
        if original == baked and not instance.is_instance or item.hide_render or not instance.show_self:
            continue
        if item.type not in ("MESH", "CURVE", "SURFACE", "FONT", "META"):
            continue
        found.append((item.original.session_uid, item, instance.matrix_world.copy(), item.original))
        key = item.original.session_uid
        if key not in meshes:
            mesh = bpy.data.meshes.new_from_object(item, depsgraph=graph)
            meshes[key] = mesh if mesh and len(mesh.polygons) else None
            if meshes[key]:
                mesh.materials.clear()
                mesh.materials.append(glow)
    for key, _, matrix, original in found:
        mesh = meshes[key]
        if mesh is None:
            continue
        copy = bpy.data.objects.new("RadTex other", mesh)
        copy.matrix_world = matrix
        for ray in _RAYS:
            setattr(copy, f"visible_{ray}", getattr(original, f"visible_{ray}"))
        scene.collection.objects.link(copy)


def _light_group() -> bpy.types.ShaderNodeTree:
    """Colour to emit for the unit direction of a point."""
    build, (direction,) = open_group("RadTex ends", Direction="Vector")
    coded = build.vector("MULTIPLY_ADD", direction, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    x, y, z = build.separate(coded)
    turns = [build.vector("SCALE", build.combine(*order), _constant(build, f"turn {index}", index == 0))
             for index, order in enumerate(((x, y, z), (z, x, y), (y, z, x)))]
    turned = build.vector("ADD", build.vector("ADD", turns[0], turns[1]), turns[2])
    white = _constant(build, "white", False)
    return close_group(build, Emission=build.mix(white, turned, (1.0, 1.0, 1.0)))


def _constant(build: NodeBuilder, label: str, on: bool) -> Any:
    node = build.node("ShaderNodeValue", label=label)
    cast(Any, node).outputs[0].default_value = float(on)
    return node.outputs[0]


def _world(group: bpy.types.ShaderNodeTree) -> bpy.types.World:
    world, build = open_world("RadTex ends")
    direction = build.node("ShaderNodeTexCoord").outputs["Generated"]
    (emission,) = build.group(group, direction)
    background = build.node("ShaderNodeBackground", emission, 1.0)
    build.node("ShaderNodeOutputWorld", background.outputs[0])
    cast(Any, world).cycles.sampling_method = "NONE"  # paths end where they go, no light is looked for
    return world


def _glow(group: bpy.types.ShaderNodeTree, middle: Floats) -> bpy.types.Material:
    material, build = open_material("RadTex ends")
    towards = build.vector("NORMALIZE", build.vector("SUBTRACT", build.geometry("Position"), tuple(float(x) for x in middle)))
    (emission,) = build.group(group, towards)
    shader = build.node("ShaderNodeEmission", emission, 1.0)
    build.node("ShaderNodeOutputMaterial", shader.outputs[0])
    cast(Any, material).cycles.emission_sampling = "NONE"
    return material
