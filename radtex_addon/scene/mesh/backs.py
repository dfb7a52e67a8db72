# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that can be seen from behind, such as a leaf's or a bowl's, get a twin that faces the other way.

A twin has its own vertices and texels, so that the back can look different from the front; engines then draw
only front faces. Cycles renders the surface without twins, since it renders both sides of each face.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from mathutils.bvhtree import BVHTree

from ...bake.progress import Steps, finished
from ...core.arrays import Bools, Floats, Ints
from ...core.frame import normalised
from ...core.islands import areas_on_surface, weld
from ...core.surface import inner_edges, is_closed
from .evaluated import EvaluatedMesh, MeshAttribute
from .face_rays import (
    having_neighbours,
    leaving_rays,
    rays_per_triangle,
    regions,
    small_regions,
    spread_to_neighbours,
)
from .mesh_parts import taken
from .triangle_tree import triangle_tree

TWIN = "radtex_twin"  # attribute of faces: their twin's index, or -1; of twins: -2 minus their face's index
_RAYS = 200_000  # about so many in total, in proportion to area, but at least one for each triangle
_RAYS_IN_CLOSED = 20_000  # in total from the backs of a closed surface, unless one of them leaves it
_LEAST, _MOST = 8, 512  # rays per triangle; in large meshes the least is lower
_SEEN = 0.01  # share of a triangle's rays that must leave the mesh
_HOLE = 0.02  # times the area seen from behind: smaller unseen regions next to it count as seen, too
_CRACK = 0.02  # times the area of the connected surface: smaller seen regions get no twins
_FEW = 0.002  # times the mesh's area: if less is seen from behind in total, nothing gets twins
_LIFT = 5e-6  # times the mesh's diagonal: how far twins are off their faces in previews
_APART = 1.2  # times the mesh's extent: how far twins are moved for the unwrap


def seen_from_behind(mesh: EvaluatedMesh) -> Bools:
    """`seen_from_behind_steps`, without progress."""
    return finished(seen_from_behind_steps(mesh))


def seen_from_behind_steps(mesh: EvaluatedMesh) -> Steps[Bools]:
    """Which triangles can be seen from behind from outside the mesh, in whole regions: (F,).

    Cosine-distributed rays start at each triangle's back; it can be seen if some of them meet no other
    triangle. Triangles for which the mesh already has one that faces the other way are left out. A material's
    Backface Culling does not count, as Cycles ignores it. Where only a few crumbs of the mesh are seen from
    behind, none count: for a handful of texels, a fit UV layer would be given up, or an unwrap not fit into
    few texels. Of a mesh of many triangles a ray from each is cast only if one leaves it of those that start
    all over it. So it is with a closed surface, from which fewer start: its backs are seen only where it is
    inside out, or cuts itself. Yields progress.
    """
    triangles = mesh.triangles
    area = areas_on_surface(mesh.position, triangles)
    wanted = area > 0
    if not wanted.any():
        return wanted
    tree = triangle_tree(mesh.position, triangles)
    none = np.zeros(len(triangles), dtype=bool)
    if len(triangles) > _RAYS and not (yield from _any_leaves(mesh, tree, area * wanted, _RAYS)):
        return none
    vertex = weld(mesh.position)[triangles]
    wanted &= ~_paired(vertex)
    if not wanted.any():
        return wanted
    few = len(triangles) <= _RAYS and is_closed(vertex)
    if few and not (yield from _any_leaves(mesh, tree, area * wanted, _RAYS_IN_CLOSED)):
        return none
    share = yield from _leaving(mesh, tree, area, wanted)
    first, second = inner_edges(vertex).starts.T // 3
    seen = spread_to_neighbours(share, first, second) > _SEEN
    seen = seen | having_neighbours(seen, first, second)
    seen &= ~small_regions(seen, first, second, area, _CRACK * _area_of_surface(first, second, area))
    hole = small_regions(~seen, first, second, area, np.full(len(seen), _HOLE * area[seen].sum()))
    found: Bools = wanted & (seen | (hole & _beside(hole, seen, first, second)))
    return found & (area[found].sum() > _FEW * area.sum())


def with_twins(mesh: EvaluatedMesh, faces: Bools) -> EvaluatedMesh:
    """The mesh with a twin for each of `faces` (F,), after its own triangles; the attribute TWIN pairs them.

    A twin has its triangle's corners in the opposite order and the opposite normals; all else is the same.
    Without any such face, the mesh itself.
    """
    if not faces.any():
        return mesh
    old, own = np.flatnonzero(faces), len(mesh.triangles)
    used, corner = np.unique(mesh.triangles[old][:, ::-1], return_inverse=True)
    triangles = corner.reshape(-1, 3) + len(mesh.position)
    twin = np.full(own + len(old), -1, dtype=np.int32)
    twin[old], twin[own:] = np.arange(own, own + len(old)), -2 - old
    take = {"POINT": used, "FACE": old}
    attributes = []
    for attribute in mesh.attributes:
        values = attribute.values
        more = values[old][:, ::-1] if attribute.domain == "CORNER" else values[take[attribute.domain]]
        attributes.append(replace(attribute, values=np.concatenate([values, more])))
    return replace(
        mesh,
        position=np.concatenate([mesh.position, mesh.position[used]]),
        triangles=np.concatenate([mesh.triangles, triangles]).astype(np.int32),
        normal=np.concatenate([mesh.normal, -mesh.normal[old][:, ::-1]]),
        material_index=np.concatenate([mesh.material_index, mesh.material_index[old]]),
        attributes=(*attributes, MeshAttribute(TWIN, "FACE", "INT", twin[:, None])),
    )


def with_fronts_alone(meshes: list[EvaluatedMesh], some: Sequence[Collection[Any]]) -> list[EvaluatedMesh]:
    """The meshes with the attribute TWIN, by which only fronts are drawn, where `some` has anything."""

    def alone(mesh: EvaluatedMesh) -> EvaluatedMesh:
        if any(attribute.name == TWIN for attribute in mesh.attributes):
            return mesh
        none = np.full((len(mesh.triangles), 1), -1, dtype=np.int32)
        return replace(mesh, attributes=(*mesh.attributes, MeshAttribute(TWIN, "FACE", "INT", none)))

    return [alone(mesh) if any(some[number : number + 1]) else mesh for number, mesh in enumerate(meshes)]


def fronts(twin: Ints) -> Bools:
    """Which triangles are the mesh's own and not twins, by the values (F,) of the attribute TWIN: (F,)."""
    own: Bools = twin >= -1
    return own


def fronts_of(mesh: EvaluatedMesh) -> Bools:
    """`fronts` of a mesh: (F,); True everywhere if no twins were added."""
    for attribute in mesh.attributes:
        if attribute.name == TWIN:
            return fronts(attribute.values[:, 0])
    return np.ones(len(mesh.triangles), dtype=bool)


def without_twins(mesh: EvaluatedMesh) -> EvaluatedMesh:
    """The mesh without its twins; the attribute TWIN stays."""
    return taken(mesh, fronts_of(mesh))


def with_twins_moved(mesh: EvaluatedMesh) -> EvaluatedMesh:
    """The mesh with twins moved away, so that the unwrap does not connect a twin with its front."""
    own = fronts_of(mesh)
    if own.all():
        return mesh
    place = mesh.position.copy()
    away = np.unique(mesh.triangles[~own])
    place[away, 0] += np.float32(_APART * float(np.ptp(place, axis=0).max()))
    return replace(mesh, position=place)


def lift_twins(mesh: Any) -> None:
    """Move the twins of a Blender mesh that has the attribute TWIN off their faces, along their own normals.

    It is by _LIFT times the mesh's diagonal, less than what a picture shows. Of two triangles in one place
    Cycles meets only one, whichever way it faces, and a back face that is transparent would hide its twin.
    """
    twin = twin_numbers(mesh)
    if twin is None:
        return
    place = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", place)
    corner = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corner)
    position = place.reshape(-1, 3).astype(np.float64)
    first, second, third = (corner.reshape(-1, 3)[~fronts(twin)]).T
    normal = np.cross(position[second] - position[first], position[third] - position[first])
    total = np.zeros_like(position)
    for each in (first, second, third):
        np.add.at(total, each, normal)
    position += _LIFT * float(np.linalg.norm(np.ptp(position, axis=0))) * normalised(total)
    mesh.vertices.foreach_set("co", position.astype(np.float32).ravel())
    mesh.update()


def twin_numbers(mesh: Any) -> Ints | None:
    """The attribute TWIN of a Blender mesh, (F,) int64; None without it, or if twins were left out."""
    attribute = mesh.attributes.get(TWIN)
    if attribute is None:
        return None
    values = np.empty(len(mesh.polygons), dtype=np.int32)
    attribute.data.foreach_get("value", values)
    return values.astype(np.int64) if values.max(initial=-1) < len(values) else None


def _paired(vertex: Ints) -> Bools:
    """Which triangles (F, 3) share all their vertices with a triangle that faces the other way: (F,)."""
    ordered = np.sort(vertex, axis=1)
    turns = ((vertex[:, 0] < vertex[:, 1]).astype(int) + (vertex[:, 1] < vertex[:, 2])) + (
        vertex[:, 2] < vertex[:, 0]
    )
    odd = turns < 2  # going around, vertex indices fall more often than they rise
    place = weld(ordered)
    ways = np.zeros((int(place.max(initial=-1)) + 1, 2), dtype=bool)
    ways[place, odd.astype(int)] = True
    found: Bools = ways[place].all(axis=1)
    return found


def _any_leaves(mesh: EvaluatedMesh, tree: BVHTree, area: Floats, rays: int) -> Steps[bool]:
    """Whether any of some rays from the backs leaves the mesh; they start as densely all over the `area`."""
    so_far = np.cumsum(area)
    place = (np.arange(rays) + 0.5) / rays * so_far[-1]
    face = np.searchsorted(so_far, place)
    free = yield from leaving_rays(mesh.position, mesh.triangles, tree, face, -1, stop=True)
    return bool(free.any())


def _leaving(mesh: EvaluatedMesh, tree: BVHTree, area: Floats, wanted: Bools) -> Steps[Floats]:
    """The share of rays from each triangle's back that leave the mesh: (F,), 0 where not `wanted` (F,)."""
    rays = rays_per_triangle(area, _RAYS, _LEAST, _MOST) * wanted
    face = np.repeat(np.arange(len(rays)), rays)
    free = yield from leaving_rays(mesh.position, mesh.triangles, tree, face, -1)
    left: Floats = np.bincount(face, free.astype(np.float64), len(rays)) / np.maximum(rays, 1)
    return left


def _area_of_surface(first: Ints, second: Ints, area: Floats) -> Floats:
    """For each triangle the area of the connected surface that it belongs to, (F,)."""
    label = regions(np.ones(len(area), dtype=bool), first, second)
    total: Floats = np.bincount(label, area)[label].astype(np.float64)
    return total


def _beside(some: Bools, seen: Bools, first: Ints, second: Ints) -> Bools:
    """Triangles in connected regions of `some` that have a `seen` neighbour."""
    label = regions(some, first, second)
    touched = np.zeros(len(label), dtype=bool)
    touched[label[some & having_neighbours(seen, first, second)]] = True
    return touched[label]
