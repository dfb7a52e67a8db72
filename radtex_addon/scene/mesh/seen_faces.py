# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out which faces can be seen from where a camera can be; the others need few texels.

A camera can be wherever there is room; but where all cameras of a scene stand inside what is baked, as in a
room with walls of some thickness, it is taken that nobody sees that from outside.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mathutils.bvhtree import BVHTree

from ...bake.progress import Steps
from ...core.arrays import Bools, Floats, Ints
from ...core.islands import areas_on_surface, weld
from ...core.octahedron import cell_directions
from ...core.surface import inner_edges
from ..checks.see_through import is_see_through
from .evaluated import EvaluatedMesh
from .face_rays import (
    leaving_rays,
    rays_per_triangle,
    seen_from_points,
    small_regions,
    spread_to_neighbours,
)
from .triangle_tree import distances_from, triangle_tree

_FIRST = 4_000  # rays from all over the surface: if nearly all leave, no face is hidden
_OPEN = 0.98  # of those
_RAYS = 200_000  # about so many in total, in proportion to area
_LEAST, _MOST = 4, 256  # rays per triangle; in large meshes the least is lower
_SEEN = 0.005  # share of the rays that leave the meshes around a triangle, from which on it is seen
_LOOKS = 16  # cells along a side of the octahedron: the directions in which cameras look around
_ENCLOSED = 0.6  # share of them in which a camera inside sees what is baked
_WAYS = (0.25, 0.5, 0.75)  # of the way to that: where else inside a camera can be
_ROOMS = 5  # how often a camera may go on from there, as through doors …
_FROM = 100  # … from so many places …
_STEPS = 24  # … of which there is one at most in each cell of so many along the longest side
_EYES = 400  # such places that are taken
_CRUMB = 0.002  # times the whole area: hidden regions that are smaller keep their texels


def seen_faces(meshes: Sequence[EvaluatedMesh], room: float) -> Steps[Bools]:
    """Which triangles a camera can see, (F,), those of all meshes one after another.

    Cosine-distributed rays start in front of each triangle; it is seen if some of them, or of its
    neighbours', leave all of the meshes, or go on for so much `room`, in scene units, that a camera fits in
    there, as in a room of a house. Faces of clear materials hide nothing. Yields progress.
    """
    position, triangles, opaque = _in_world(meshes)
    area = areas_on_surface(position, triangles)
    every = np.ones(len(triangles), dtype=bool)
    if not (opaque.any() and area.sum() > 0):
        return every
    tree = triangle_tree(position, triangles[opaque])
    so_far = np.cumsum(area)
    place = (np.arange(_FIRST) + 0.5) / _FIRST * so_far[-1]
    free = yield from leaving_rays(position, triangles, tree, np.searchsorted(so_far, place), 1, far=room)
    if free.mean() > _OPEN:
        return every
    rays = rays_per_triangle(area, _RAYS, _LEAST, _MOST)
    face = np.repeat(np.arange(len(rays)), rays)
    free = yield from leaving_rays(position, triangles, tree, face, 1, far=room)
    share = np.bincount(face, free.astype(np.float64), len(rays)) / rays
    first, second = inner_edges(weld(position)[triangles]).starts.T // 3
    return _seen_enough(spread_to_neighbours(share, first, second), first, second, area)


def faces_inside(meshes: Sequence[EvaluatedMesh], cameras: Floats) -> Steps[Bools | None]:
    """Which triangles are seen from inside, (F,), if all `cameras` (C, 3) are inside the meshes; else None.

    From the cameras, and from where one can get to in straight lines, which lead to the meshes. Yields
    progress.
    """
    position, triangles, opaque = _in_world(meshes)
    area = areas_on_surface(position, triangles)
    if not (len(cameras) and opaque.any() and area.sum() > 0):
        return None
    if ((cameras < position.min(axis=0)) | (cameras > position.max(axis=0))).any():
        return None  # outside a box around it, no more than half of all directions meet what is in it
    tree = triangle_tree(position, triangles[opaque])
    if any(_ways_inside(tree, place)[1] < _ENCLOSED for place in cameras):
        return None
    random, points = np.random.default_rng(0), cameras
    step = float(np.ptp(position, axis=0).max()) / _STEPS
    for _ in range(_ROOMS):  # through doors, too
        some = random.permutation(len(points))[:_FROM]
        points = np.concatenate([points, *(_ways_inside(tree, place)[0] for place in points[some])])
        _, first = np.unique(np.floor(points / step), axis=0, return_index=True)
        points = points[first]  # everywhere as dense
    points = np.concatenate([cameras, points[random.permutation(len(points))[:_EYES]]])
    rays = rays_per_triangle(area, _RAYS, _LEAST, _MOST)
    face = np.repeat(np.arange(len(rays)), rays)
    seen = yield from seen_from_points(position, triangles, tree, face, points)
    share = np.bincount(face, seen.astype(np.float64), len(rays)) / rays
    first, second = inner_edges(weld(position)[triangles]).starts.T // 3
    found = _seen_enough(share, first, second, area)
    return None if found.all() else found


def _seen_enough(share: Floats, first: Ints, second: Ints, area: Floats) -> Bools:
    """Which triangles are seen by a large enough share of their rays, or hidden in small regions, (F,)."""
    hidden = share < _SEEN
    hidden &= ~small_regions(hidden, first, second, area, np.full(len(area), _CRUMB * area.sum()))
    found: Bools = ~hidden
    return found


def _ways_inside(tree: BVHTree, place: Floats) -> tuple[Floats, float]:
    """Places (P, 3) on the ways from a place (3,) to what it sees all around, and the share that it sees."""
    ways = cell_directions(_LOOKS).astype(np.float64)
    far = distances_from(tree, place, ways)
    met = np.isfinite(far)
    along = [place + part * far[met, None] * ways[met] for part in _WAYS]
    return np.concatenate(along), float(met.mean())


def _in_world(meshes: Sequence[EvaluatedMesh]) -> tuple[Floats, Ints, Bools]:
    """All meshes' vertices (V, 3) in world space, triangles (F, 3), and which of these hide things (F,)."""
    first = np.cumsum([0, *(len(mesh.position) for mesh in meshes)])
    triangles = [
        (mesh.triangles[:, ::-1] if mesh.mirrored else mesh.triangles) + start
        for mesh, start in zip(meshes, first, strict=False)
    ]
    opaque = [~_clear_slots(mesh)[mesh.material_index] for mesh in meshes]
    position = np.concatenate([mesh.world_position for mesh in meshes])
    return position, np.concatenate(triangles).astype(np.int32), np.concatenate(opaque)


def _clear_slots(mesh: EvaluatedMesh) -> Bools:
    """Which numbers of materials in a mesh are of clear ones, (M,)."""
    clear = [material is not None and is_see_through(material, glass=True) for material in mesh.materials]
    slots = max(int(mesh.material_index.max(initial=0)) + 1, len(clear))
    return np.array([*clear, *[False] * (slots - len(clear))], dtype=bool)
