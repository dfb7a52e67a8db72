# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out which meshes touch, or are one inside the other, and read them as they render or are shown.

What is found of a pair is kept, so that a panel which asks at each change pays for what has changed alone.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from ...core.arrays import Floats, Ints
from ..objects import about_matrix
from ..surfaces import shown_mesh
from .mesh_checks import FARTHEST
from .render_contents import read_render

_NEAR = 0.005  # of the smaller mesh's size: surfaces that come closer touch
_INSIDE = 0.95  # of a surface in another's hull: it is inside
_FILLED = 0.5
_ALIKE = 0.01  # of its size: boxes that differ by less are of one thing, if the hulls fill each other
_SAMPLES = 1500  # points on a surface, or on the part of it near another one
_READ = 200_000  # triangles of a mesh
_TRIANGLES = 30_000  # in a tree; of more the largest are kept, and every n-th of the others
_KEPT = 50_000  # pairs of meshes, at 32 bytes each


@dataclass(frozen=True, eq=False)
class Surface:
    """Vertices (V, 3) float32 in object space, triangles (F, 3), at least one, and the matrix (4, 4).

    All its coordinates in the world are such as can be baked.
    """

    local: Floats
    triangles: Ints
    matrix: Floats

    @cached_property
    def digest(self) -> bytes:
        """What tells it from others, and from itself at another place."""
        found = hashlib.blake2b(digest_size=16)
        for values in (self.local, self.triangles, self.matrix):
            found.update(np.ascontiguousarray(values).data)
        return found.digest()

    @cached_property
    def position(self) -> Floats:
        """The vertices in the world, (V, 3) float64."""
        return _in_world(self.local, self.matrix)

    @cached_property
    def box(self) -> Floats:
        """The least and the greatest coordinates, (2, 3)."""
        return np.stack([self.boxes[0].min(axis=0), self.boxes[1].max(axis=0)])

    @cached_property
    def boxes(self) -> Floats:
        """The least and the greatest coordinates of each triangle, (2, F, 3)."""
        a, b, c = (self.position[self.triangles[:, k]] for k in range(3))
        return np.stack([np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)])

    @cached_property
    def hull(self) -> Floats:
        """How far it reaches against and along each of `_DIRECTIONS`, (2, D): planes around its hull."""
        used = np.zeros(len(self.position), dtype=bool)
        used[self.triangles] = True
        along = _DIRECTIONS @ self.position[used].T
        return np.stack([along.min(axis=1), along.max(axis=1)])

    @property
    def size(self) -> float:
        """The diagonal of its box."""
        return float(np.linalg.norm(self.box[1] - self.box[0]))

    @cached_property
    def areas(self) -> Floats:
        """The area of each triangle, (F,)."""
        a, b, c = (self.position[self.triangles[:, k]] for k in range(3))
        found: Floats = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        return found

    @cached_property
    def samples(self) -> Floats:
        """Points spread evenly over it, (N, 3)."""
        return self._spread(np.arange(len(self.triangles)))

    def samples_within(self, box: Floats) -> Floats:
        """Points spread evenly over what lies in a box (2, 3): at most `_SAMPLES`, (N, 3)."""
        found = self._spread(self._near(box))
        inside: Floats = found[((found >= box[0]) & (found <= box[1])).all(axis=1)]
        return inside

    def tree_within(self, box: Floats) -> BVHTree | None:
        """A tree of the triangles near a box (2, 3); None if there are none."""
        some = self._near(box)
        if len(some) > _TRIANGLES:
            by_area = some[np.argsort(-self.areas[some], kind="stable")]
            largest, others = np.split(by_area, [_TRIANGLES // 2])
            some = np.concatenate([largest, others[:: -(-len(others) // (_TRIANGLES // 2))]])
        if not len(some):
            return None
        used, index = np.unique(self.triangles[some], return_inverse=True)
        faces = index.reshape(-1, 3).tolist()
        return BVHTree.FromPolygons(self.position[used].tolist(), faces, all_triangles=True)

    def _near(self, box: Floats) -> Ints:
        """The triangles whose own boxes meet a box (2, 3)."""
        meets = (self.boxes[0] <= box[1]).all(axis=1) & (self.boxes[1] >= box[0]).all(axis=1)
        return np.flatnonzero(meets)

    def _spread(self, some: Ints) -> Floats:
        """Points spread evenly over some of the triangles, the same each time: (N, 3)."""
        total = np.cumsum(self.areas[some])
        if not len(some) or not total[-1] > 0:
            corners: Floats = self.position[self.triangles[some, 0]][:_SAMPLES]
            return corners
        random = np.random.default_rng(0)
        place = (np.arange(_SAMPLES) + random.random(_SAMPLES)) / _SAMPLES * total[-1]
        chosen = some[np.minimum(np.searchsorted(total, place), len(some) - 1)]
        u, v = random.random((2, _SAMPLES, 1))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = (self.position[self.triangles[chosen, k]] for k in range(3))
        found: Floats = a + u * (b - a) + v * (c - a)
        return found


def surface_of(position: Floats, triangles: Ints, matrix: Floats) -> Surface | None:
    """The surface of an object with a matrix (4, 4); None without triangles, or if it is too far away.

    Of more than 200,000 triangles every n-th is taken: they are small.
    """
    if not len(triangles):
        return None
    if len(triangles) > _READ:
        triangles = triangles[:: -(-len(triangles) // _READ)]
        used = np.zeros(len(position), dtype=bool)
        used[triangles] = True
        position, triangles = position[used], (np.cumsum(used, dtype=np.int32) - np.int32(1))[triangles]
    is_near = (np.abs(_in_world(position, matrix)) < FARTHEST).all()
    return Surface(position, triangles, matrix) if is_near else None


def _in_world(position: Floats, matrix: Floats) -> Floats:
    with np.errstate(over="ignore", invalid="ignore"):
        found: Floats = position.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return found


def surfaces_shown(layer: bpy.types.ViewLayer, items: Sequence[bpy.types.Object]) -> list[Surface | None]:
    """The surfaces of mesh objects as the view layer last evaluated them for the viewport; quick.

    Objects that are hidden in the viewport count without modifiers and constraints.
    """
    found: list[Surface | None] = []
    for item in items:
        evaluated = item if layer.depsgraph is None else item.evaluated_get(layer.depsgraph)
        with shown_mesh(evaluated) as mesh:
            if mesh is None:
                found.append(None)
                continue
            mesh.calc_loop_triangles()
            position = np.empty((len(mesh.vertices), 3), dtype=np.float32)
            triangles = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
            mesh.vertices.foreach_get("co", position.ravel())
            mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
        found.append(surface_of(position, triangles, about_matrix(item, layer)))
    return found


def surfaces_in_render(scratch: bpy.types.Scene, items: Sequence[bpy.types.Object]) -> list[Surface | None]:
    """The surfaces of mesh objects in a render of the scratch scene; None for what does not render.

    Raises BakeError where Blender does not render.
    """
    wanted = set(items)
    found: dict[bpy.types.Object, Surface | None] = {}

    def read(shown: Any) -> None:
        for one in shown:
            if not one.is_instance and one.original in wanted and (shape := one.shape) is not None:
                found[one.original] = surface_of(shape.position, shape.triangles, one.matrix)

    read_render(scratch, read)
    return [found.get(item) for item in items]


class _Pairs:
    """What was found of pairs of surfaces, by their digests; the least recently asked for are dropped."""

    def __init__(self) -> None:
        self._found: OrderedDict[tuple[bytes, bytes], bool] = OrderedDict()

    def touch(self, one: Surface, other: Surface) -> bool:
        first, second = sorted((one, other), key=lambda each: each.digest)
        key = first.digest, second.digest
        if key not in self._found:
            self._found[key] = _touch(first, second)
            if len(self._found) > _KEPT:
                self._found.popitem(last=False)
        self._found.move_to_end(key)
        return self._found[key]


_pairs = _Pairs()


def touching_groups(surfaces: Sequence[Surface]) -> Ints:
    """Numbers of groups, (N,), the same for surfaces that touch, by way of others or not.

    They touch where they meet or come closer than half a per cent of the smaller one's size, or if one is
    inside the other's convex hull. Two versions of one thing in the same place, such as levels of detail, do
    not.
    """
    group = np.arange(len(surfaces))
    if len(surfaces) < 2:
        return group
    near = _NEAR * np.array([each.size for each in surfaces])
    low, high = np.stack([each.box for each in surfaces], axis=1)
    for one in range(len(surfaces) - 1):
        reach = np.minimum(near[one], near[one + 1 :])[:, None]
        meets = (low[one + 1 :] <= high[one] + reach) & (high[one + 1 :] >= low[one] - reach)
        for other in (np.flatnonzero(meets.all(axis=1)) + one + 1).tolist():
            if group[one] != group[other] and _pairs.touch(surfaces[one], surfaces[other]):
                group[group == group[other]] = group[one]
    return group


def _touch(one: Surface, other: Surface) -> bool:
    inside, around = _share_in_hull(one.samples, other), _share_in_hull(other.samples, one)
    if min(inside, around) >= _FILLED and (abs(one.box - other.box) <= _ALIKE * one.size).all():
        return False  # another level of detail, or what is baked from it
    return max(inside, around) >= _INSIDE or _come_close(one, other)


def _share_in_hull(points: Floats, other: Surface) -> float:
    """The share of points (N, 3) within the convex hull of a surface, which is cut by 49 pairs of planes."""
    along = points @ _DIRECTIONS.T
    return float(((along >= other.hull[0]) & (along <= other.hull[1])).all(axis=1).mean())


def _come_close(one: Surface, other: Surface) -> bool:
    near = _NEAR * min(one.size, other.size)
    box = np.stack([np.maximum(one.box[0], other.box[0]) - near, np.minimum(one.box[1], other.box[1]) + near])
    trees = one.tree_within(box), other.tree_within(box)
    if trees[0] is None or trees[1] is None:
        return False
    if trees[0].overlap(trees[1]):
        return True
    return any(
        tree.find_nearest(point, near)[0] is not None
        for tree, surface in zip(trees, (other, one), strict=True)
        for point in surface.samples_within(box).tolist()
    )


def _directions() -> Floats:
    """49 directions, (N, 3), one of each pair of opposite ones among the unit cube's lattice of fifths."""
    steps = np.arange(-2, 3)
    lattice = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    rim = lattice[np.abs(lattice).max(axis=1) == 2]
    half = rim[[tuple(each) > (0, 0, 0) for each in rim.tolist()]]
    found: Floats = half / np.linalg.norm(half, axis=1)[:, None]
    return found


_DIRECTIONS = _directions()
