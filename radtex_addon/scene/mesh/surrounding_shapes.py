# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of everything that a render shows besides one object, instances and particles included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Bools, Floats, Ints
from .evaluated import render_with

RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


@dataclass(frozen=True, eq=False)
class Shape:
    """Vertices (V, 3) float32 in object space and triangles (F, 3), at least one."""

    position: Floats
    triangles: Ints


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape in the world: `matrix` (4, 4) from object to world, and the kinds of RAYS that see it."""

    shape: Shape
    matrix: Floats
    seen_by: frozenset[str]


@dataclass(frozen=True, eq=False)
class Beside:
    """An object's matrix (4, 4) in renders, and all `others` around it; instances share their shapes."""

    matrix: Floats
    others: tuple[Placed, ...]


def read_beside(scratch: bpy.types.Scene, baked: bpy.types.Object) -> Beside:
    """Read what a render of the scratch scene's enabled view layer shows besides `baked`.

    That includes instances of `baked`, and objects that it instances. Faces whose material has a volume but
    no surface are left out, since light passes through them. Raises BakeError where Blender does not render.
    """
    found: list[Beside] = []

    def read(graph: bpy.types.Depsgraph) -> None:
        reader = _Reader(graph)
        shown = (item for item in graph.object_instances if item.show_self and not _is(item, baked))
        others = tuple(placed for item in shown if (placed := reader.placed(item)) is not None)
        matrix = np.array(baked.evaluated_get(graph).matrix_world, dtype=np.float64)
        found.append(Beside(matrix, others))

    render_with(scratch, read)
    return found[0]


def matrices_in_renders(scratch: bpy.types.Scene, items: Sequence[bpy.types.Object]) -> list[Floats]:
    """The matrices (4, 4), from object to world, of objects in renders of a scratch scene.

    Raises BakeError where Blender does not render.
    """
    found: list[Floats] = []

    def read(graph: bpy.types.Depsgraph) -> None:
        found.extend(np.array(item.evaluated_get(graph).matrix_world, dtype=np.float64) for item in items)

    render_with(scratch, read)
    return found


def _is(instance: bpy.types.DepsgraphObjectInstance, baked: bpy.types.Object) -> bool:
    return not instance.is_instance and instance.object.original == baked


class _Reader:
    """Reads each mesh once, however many instances of it there are."""

    def __init__(self, graph: bpy.types.Depsgraph) -> None:
        self._layer = cast(Any, graph.view_layer)
        self._shapes: dict[tuple[int, int], Shape | None] = {}

    def placed(self, instance: bpy.types.DepsgraphObjectInstance) -> Placed | None:
        """The instance in the world; None if it has no faces."""
        item = cast(bpy.types.Object, instance.object)
        shape = self._shape(item)
        if shape is None:
            return None
        owners = [item, *([instance.parent] if instance.is_instance and instance.parent else [])]
        seen = {ray for ray in RAYS if all(getattr(owner, f"visible_{ray}") for owner in owners)}
        if any(owner.original.indirect_only_get(view_layer=self._layer) for owner in owners):
            seen.discard("camera")
        return Placed(shape, np.array(instance.matrix_world, dtype=np.float64), frozenset(seen))

    def _shape(self, item: bpy.types.Object) -> Shape | None:
        if item.type != "MESH":  # curves, texts and metaballs come as meshes, too
            return None
        key = item.original.session_uid, item.data.as_pointer()  # geometry nodes instance bare meshes
        if key not in self._shapes:
            self._shapes[key] = _shape_of(item)
        return self._shapes[key]


def _shape_of(item: bpy.types.Object) -> Shape | None:
    mesh = cast(Any, item.to_mesh())
    if mesh is None:
        return None
    try:
        mesh.calc_loop_triangles()
        position = np.empty((len(mesh.vertices), 3), dtype=np.float32)
        triangles = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
        material = np.empty(len(mesh.loop_triangles), dtype=np.int32)
        mesh.vertices.foreach_get("co", position.ravel())
        mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
        mesh.loop_triangles.foreach_get("material_index", material)
        triangles = triangles[_opaque(item, mesh, material)]
    finally:
        item.to_mesh_clear()
    return Shape(position, triangles) if len(triangles) else None


def _opaque(item: bpy.types.Object, mesh: bpy.types.Mesh, index: Ints) -> Bools:
    """Which triangles, by their material indices `index` (F,), are more than a volume's boundary: (F,)."""
    materials = list(mesh.materials)
    for place, slot in enumerate(item.material_slots[: len(materials)]):
        if slot.link == "OBJECT":
            materials[place] = slot.material
    if not materials:
        return np.ones(len(index), dtype=bool)
    surfaces = np.array([not _is_mere_volume(material) for material in materials])
    found: Bools = surfaces[np.clip(index, 0, len(materials) - 1)]
    return found


def _is_mere_volume(material: bpy.types.Material | None) -> bool:
    if material is None or material.node_tree is None:
        return False
    output = cast(Any, material.node_tree).get_output_node("CYCLES")
    return output is not None and output.inputs["Volume"].is_linked and not output.inputs["Surface"].is_linked
