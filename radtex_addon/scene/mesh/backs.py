# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that can be seen from behind, such as a leaf's or a bowl's, get a twin that faces the other way.

A twin has vertices and texels of its own, so that a bake keeps what its side looks like; whoever draws the
mesh draws front faces alone. Cycles renders the surface without twins: it has both sides already.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.arrays import Bools, Floats, Ints
from ...core.frame import normalised
from ...core.islands import components, surface_areas, weld
from ...core.ray_offset import ray_offset
from .evaluated import EvaluatedMesh, MeshAttribute
from .parts import taken

TWIN = "radtex_twin"  # of faces: their twin's number, -1 without; of twins: -2 less their face's number
_RAYS = 200_000  # about so many in all, shared out by area; a large mesh's take one each
_LEAST, _MOST = 8, 512  # rays of a triangle
_OFF = 0.05  # of a bake's ray offset: how far behind a triangle they start, less than thin walls are thick
_SPREAD = 3  # times that triangles take the mean of what they and their neighbours found
_SEEN = 0.01  # of the rays: how many have to leave the mesh
_HOLE = 0.02  # of the area that is seen from behind: smaller regions beside it count as seen, too
_CRACK = 0.02  # of the area of the surface that hangs together: regions smaller than this are left alone
_INSET = 0.1  # of a triangle: how far from its edges rays start
_APART = 1.2  # of the mesh's extent: how far twins are moved for the unwrap


def seen_from_behind(mesh: EvaluatedMesh) -> Bools:
    """Which triangles can be seen from behind from outside the mesh, in whole regions: (F,).

    From each triangle's back some rays leave in all directions, by the cosine; it is seen if some meet no
    other triangle. Not those whose material culls back faces, which no engine would draw, nor those in whose
    place the mesh has one that faces the other way already.
    """
    triangles = mesh.triangles
    vertex = weld(mesh.position)[triangles]
    corners = mesh.position[triangles].astype(np.float64)
    area = surface_areas(corners)
    wanted = (area > 0) & ~_culled(mesh) & ~_paired(vertex)
    if not wanted.any():
        return wanted
    first, second = _neighbours(vertex)
    share = _leaving(mesh, corners, area, wanted)
    count = np.bincount(np.concatenate([first, second]), minlength=len(triangles)) + 1
    for _ in range(_SPREAD):
        total = share + np.bincount(first, share[second], len(share))
        share = (total + np.bincount(second, share[first], len(share))) / count
    seen = share > _SEEN
    seen = seen | _joined(seen, first, second)
    seen &= ~_small(seen, first, second, area, _CRACK * _area_of_surface(first, second, area))
    hole = _small(~seen, first, second, area, np.full(len(seen), _HOLE * area[seen].sum()))
    return wanted & (seen | (hole & _beside(hole, seen, first, second)))


def with_twins(mesh: EvaluatedMesh, faces: Bools) -> EvaluatedMesh:
    """The mesh, and after its triangles a twin for each of `faces` (F,), which the attribute TWIN names.

    A twin has its triangle's corners in the opposite order, the opposite normals, and all else alike.
    """
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


def fronts(twin: Ints) -> Bools:
    """Which triangles are no twins that were added, by the attribute TWIN (F,)."""
    own: Bools = twin >= -1
    return own


def fronts_of(mesh: EvaluatedMesh) -> Bools:
    """The same of a mesh, whether twins were added or not: (F,)."""
    for attribute in mesh.attributes:
        if attribute.name == TWIN:
            return fronts(attribute.values[:, 0])
    return np.ones(len(mesh.triangles), dtype=bool)


def without_twins(mesh: EvaluatedMesh) -> EvaluatedMesh:
    """The mesh as it was; the attribute TWIN stays."""
    return taken(mesh, fronts_of(mesh))


def twins_apart(mesh: EvaluatedMesh) -> EvaluatedMesh:
    """The mesh with twins moved away, so that what unwraps it takes no twin for a neighbour of its front."""
    own = fronts_of(mesh)
    if own.all():
        return mesh
    place = mesh.position.copy()
    away = np.unique(mesh.triangles[~own])
    place[away, 0] += np.float32(_APART * float(np.ptp(place, axis=0).max()))
    return replace(mesh, position=place)


def twin_numbers(mesh: Any) -> Ints | None:
    """The attribute TWIN of a Blender mesh, (F,) int64; None without, and where twins were left out."""
    attribute = mesh.attributes.get(TWIN)
    if attribute is None:
        return None
    values = np.empty(len(mesh.polygons), dtype=np.int32)
    attribute.data.foreach_get("value", values)
    return values.astype(np.int64) if values.max(initial=-1) < len(values) else None


def _culled(mesh: EvaluatedMesh) -> Bools:
    if not mesh.materials:
        return np.zeros(len(mesh.triangles), dtype=bool)
    culls = [material is not None and material.use_backface_culling for material in mesh.materials]
    found: Bools = np.array(culls)[mesh.material_index]
    return found


def _paired(vertex: Ints) -> Bools:
    """Triangles with vertices (F, 3) another of which lies in the same place and faces the other way."""
    ordered = np.sort(vertex, axis=1)
    turns = ((vertex[:, 0] < vertex[:, 1]).astype(int) + (vertex[:, 1] < vertex[:, 2])) + (
        vertex[:, 2] < vertex[:, 0]
    )
    odd = turns < 2  # falls more often than it rises, once around
    place = weld(ordered)
    ways = np.zeros((int(place.max(initial=-1)) + 1, 2), dtype=bool)
    ways[place, odd.astype(int)] = True
    found: Bools = ways[place].all(axis=1)
    return found


def _neighbours(vertex: Ints) -> tuple[Ints, Ints]:
    """Pairs of triangles with vertices (F, 3) that share an edge: two arrays (M,)."""
    edges = np.sort(np.stack([vertex, np.roll(vertex, -1, axis=1)], axis=-1), axis=-1).reshape(-1, 2)
    label = weld(edges)
    order = np.argsort(label, kind="stable")
    same = label[order[1:]] == label[order[:-1]]
    return order[:-1][same] // 3, order[1:][same] // 3


def _leaving(mesh: EvaluatedMesh, corners: Floats, area: Floats, wanted: Bools) -> Floats:
    """What share of the rays from behind each triangle leaves the mesh, (F,); 0 of those not `wanted`."""
    random = np.random.default_rng(0)
    least = max(1, min(_LEAST, _RAYS // len(area)))
    rays = np.clip(np.rint(_RAYS * area / area.sum()), least, _MOST).astype(np.int64) * wanted
    face = np.repeat(np.arange(len(rays)), rays)
    root, along = np.sqrt(random.random(len(face)))[:, None], random.random(len(face))[:, None]
    a, b, c = corners[face].transpose(1, 0, 2)
    behind = -normalised(np.cross(b - a, c - a))
    place = a * (1 - root) + root * ((1 - along) * b + along * c)
    place += _INSET * (corners.mean(axis=1)[face] - place)
    place += _OFF * ray_offset(mesh.position) * behind
    anywhere = normalised(random.normal(size=(len(face), 3)))
    tree: Any = BVHTree.FromPolygons(mesh.position.tolist(), mesh.triangles.tolist(), all_triangles=True)
    ways = normalised(behind + 0.999 * anywhere)
    free = [
        tree.ray_cast(Vector(start), Vector(way))[0] is None
        for start, way in zip(place.tolist(), ways.tolist(), strict=True)
    ]
    left: Floats = np.bincount(face, np.array(free, dtype=np.float64), len(rays)) / np.maximum(rays, 1)
    return left


def _joined(some: Bools, first: Ints, second: Ints) -> Bools:
    """The triangles that have a neighbour in `some`."""
    found = np.zeros_like(some)
    found[first[some[second]]] = True
    found[second[some[first]]] = True
    return found


def _regions(some: Bools, first: Ints, second: Ints) -> Ints:
    """Labels (F,) of the regions that hang together among `some` triangles; each other one is its own."""
    inside = some[first] & some[second]
    return components(np.stack([first[inside], second[inside]], axis=1), len(some))


def _area_of_surface(first: Ints, second: Ints, area: Floats) -> Floats:
    """For each triangle the area of all that hangs together with it, (F,)."""
    label = _regions(np.ones(len(area), dtype=bool), first, second)
    total: Floats = np.bincount(label, area)[label].astype(np.float64)
    return total


def _small(some: Bools, first: Ints, second: Ints, area: Floats, least: Floats) -> Bools:
    """Those of `some` triangles whose region has less area than `least` (F,)."""
    label = _regions(some, first, second)
    found: Bools = some & (np.bincount(label, area)[label] < least)
    return found


def _beside(some: Bools, seen: Bools, first: Ints, second: Ints) -> Bools:
    """Triangles of the regions of `some` that have a neighbour which is `seen`."""
    label = _regions(some, first, second)
    touched = np.zeros(len(label), dtype=bool)
    touched[label[some & _joined(seen, first, second)]] = True
    return touched[label]
