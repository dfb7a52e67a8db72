# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage: an enlarged copy of the simple object, from which rays to the detailed object start."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.surface import SurfaceMesh
from ...core.texel_map import TexelMap
from .evaluated import render_with

_FLAT = 1e-12  # times two edges' squared lengths: a triangle with less squared area counts as flat


def find_cage(
    scene: bpy.types.Scene, simple: bpy.types.Object, source: str | None, name: str
) -> bpy.types.Object:
    """The object called `name`, as the cage around `simple`; it may be hidden, since renders leave it out.

    Raises InputError if there is no mesh of that name, or if it is `simple` or the `source` itself.
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
    """Positions in the cage of the vertices that faces of `simple` use: (V, 3) float64, world space.

    Both are read as renders evaluate them. Raises InputError if the cage's vertices or faces differ.
    """
    shown = cast(bpy.types.Object, cage.copy())
    shown.hide_render = False
    scratch.collection.objects.link(shown)

    def read(graph: bpy.types.Depsgraph) -> Floats:
        one, other = (_Faces(item.evaluated_get(graph)) for item in (simple, shown))
        _compare(simple.name, one, cage.name, other)
        world = other.places @ other.matrix[:3, :3].T + other.matrix[:3, 3]
        used: Floats = world[np.unique(one.corners)]
        return used

    try:
        places = render_with(scratch, read)
    finally:
        bpy.data.objects.remove(shown)
    if not np.isfinite(places).all():
        raise InputError(f"cage '{cage.name}' has vertices whose coordinates are not finite: delete them")
    return places


def rays_from_cage(places: Floats, surface: SurfaceMesh, texels: TexelMap) -> Floats:
    """Vectors from each texel's point on the simple object's `surface` to the cage: (H, W, 3), world space.

    A vector ends at the point with the same barycentric coordinates in the same triangle of the cage, whose
    vertices are at `places` (V, 3).
    """
    moved = places - surface.position
    offset = np.zeros(texels.position.shape)
    covered = texels.covered
    corners = surface.triangles[texels.triangle[covered]]
    weights = barycentric(surface.position[corners], texels.position[covered].astype(np.float64))
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
    """An evaluated object's vertex positions `places` (V, 3), faces' first corners, and corners' vertices."""

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


def barycentric(corner: Floats, point: Floats) -> Floats:
    """Barycentric weights (K, 3), never negative, of points (K, 3) in triangles with corners (K, 3, 3)."""
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
