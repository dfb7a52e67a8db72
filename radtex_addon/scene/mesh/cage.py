# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage: the simple object's vertices and faces again, moved out to where rays for a detailed one start."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.surface import SurfaceMesh
from ...core.texel_map import TexelMap
from .evaluated import render_with

_FLAT = 1e-12  # of a triangle's edges' squares: below it has no inside to speak of


def find_cage(
    scene: bpy.types.Scene, simple: bpy.types.Object, source: str | None, name: str
) -> bpy.types.Object:
    """The object called `name` that is the cage around `simple`; it may be hidden, and is never seen.

    Raises InputError where there is no mesh of that name, or it is one of the two others.
    """
    if name in (simple.name, source):
        raise InputError(f"object '{name}' cannot be the cage too: name a copy of '{simple.name}', enlarged")
    found = cast("bpy.types.Object | None", scene.objects.get(name))
    if found is None or found.type != "MESH":
        what = "is not in" if found is None else "is no mesh of"
        raise InputError(
            f"cage '{name}' {what} scene '{scene.name}': name a copy of '{simple.name}', enlarged"
        )
    return found


def read_cage(scratch: bpy.types.Scene, simple: bpy.types.Object, cage: bpy.types.Object) -> Floats:
    """Where the cage has those vertices that faces of `simple` use, in order: (V, 3) float64, world space.

    Both are read as renders evaluate them. Raises InputError where the cage has other vertices or faces.
    """
    found: list[Floats] = []
    shown = cast(bpy.types.Object, cage.copy())
    shown.hide_render = False
    scratch.collection.objects.link(shown)

    def read(graph: bpy.types.Depsgraph) -> None:
        one, other = (_Faces(item.evaluated_get(graph)) for item in (simple, shown))
        _compare(simple.name, one, cage.name, other)
        world = other.places @ other.matrix[:3, :3].T + other.matrix[:3, 3]
        found.append(world[np.unique(one.corners)])

    try:
        render_with(scratch, read)
    finally:
        bpy.data.objects.remove(shown)
    if not np.isfinite(found[0]).all():
        raise InputError(f"cage '{cage.name}' has vertices whose coordinates are not finite: delete them")
    return found[0]


def rays_from_cage(places: Floats, surface: SurfaceMesh, texels: TexelMap) -> Floats:
    """From each texel's point of a simple object's `surface` to the cage's: (H, W, 3) in world space.

    The cage's point lies in the triangle of the same vertices, which are at `places` (V, 3), at the same
    barycentric coordinates.
    """
    moved = places - surface.position
    offset = np.zeros(texels.position.shape)
    covered = texels.covered
    corners = surface.triangles[texels.triangle[covered]]
    weights = _barycentric(surface.position[corners], texels.position[covered].astype(np.float64))
    offset[covered] = np.einsum("kc,kcx->kx", weights, moved[corners])
    return offset


def take_cage_out(scratch: bpy.types.Scene, name: str) -> None:
    """Leave the cage out of a scratch scene whose collections are its own."""
    for item in list(scratch.objects):
        if item.name == name:
            take_out(scratch, item)


def take_out(scratch: bpy.types.Scene, item: bpy.types.Object) -> None:
    """Leave an object out of a scratch scene whose collections are its own."""
    for collection in (scratch.collection, *scratch.collection.children_recursive):
        if item in collection.objects.values():
            collection.objects.unlink(item)


class _Faces:
    """An evaluated object's vertices `places` (V, 3), each face's first corner, and the corners' vertices."""

    def __init__(self, item: bpy.types.Object) -> None:
        mesh = cast(Any, item.to_mesh())
        self.places = np.empty((len(mesh.vertices), 3), dtype=np.float32)
        self.firsts = np.empty(len(mesh.polygons), dtype=np.int32)
        self.corners = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.vertices.foreach_get("co", self.places.ravel())
        mesh.polygons.foreach_get("loop_start", self.firsts)
        mesh.loops.foreach_get("vertex_index", self.corners)
        self.matrix = np.array(item.matrix_world, dtype=np.float64)
        item.to_mesh_clear()

    @property
    def counts(self) -> str:
        return f"{len(self.places)} vertices and {len(self.firsts)} faces"


def _compare(name: str, simple: _Faces, cage: str, other: _Faces) -> None:
    remedy = f"make it a copy of '{name}', modifiers and all, and move its vertices alone"
    if simple.counts != other.counts:
        raise InputError(f"cage '{cage}' has {other.counts}, '{name}' has {simple.counts}: {remedy}")
    same = np.array_equal(simple.firsts, other.firsts) and np.array_equal(simple.corners, other.corners)
    if not same:
        raise InputError(f"cage '{cage}' has other faces than '{name}', or in another order: {remedy}")


def _barycentric(corner: Floats, point: Floats) -> Floats:
    """Weights (K, 3) of triangles' corners (K, 3, 3) at points (K, 3) of theirs, never below 0."""
    along, across, to = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0], point - corner[:, 0]
    aa, ab, bb = (
        np.sum(one * two, axis=1) for one, two in ((along, along), (along, across), (across, across))
    )
    pa, pb = np.sum(to * along, axis=1), np.sum(to * across, axis=1)
    area = aa * bb - ab * ab
    flat = area <= _FLAT * aa * bb
    area[flat] = 1.0
    second, third = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    weights = np.clip(np.stack([1 - second - third, second, third], axis=1), 0, None)
    weights[flat] = 1 / 3
    found: Floats = weights / weights.sum(axis=1, keepdims=True)
    return found
