# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lamps other things hide from the baked objects: behind a wall, or a sun outside a closed room."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ....bake.plan import CapturePlan
from ....core.arrays import Bools, Floats, Ints
from ....scene.lights.linking import shadows
from ....scene.mesh.evaluated import FARTHEST
from ....scene.mesh.render_contents import Placed, Shape, Shown, read_render
from ....scene.mesh.triangle_tree import triangle_tree
from .enclosed import is_clear

_POINTS = 64  # of the surface, from which is asked
_APART = 1e-4  # of a ray's length: at its start it meets what the point lies on
_LEAST = 1e-12  # component of a direction


@dataclass(frozen=True, eq=False)
class Sights:
    """Rays from points of the baked surface: to which `lamp` (R,), from `start` (R, 3), `along` (R, 3)."""

    lamp: Ints
    start: Floats
    along: Floats

    @classmethod
    def of(cls, plan: CapturePlan, lamps: Sequence[tuple[Floats, float]]) -> Sights:
        """From points of the plan that face the lamps, places (3,) and radii, to the lamps' near sides."""
        step = max(1, len(plan.texel) // _POINTS)
        points = plan.points[::step].astype(np.float64)
        normals = plan.normal.reshape(-1, 3)[: len(plan.texel) : step]
        numbers, starts, alongs = [], [], []
        for number, (place, radius) in enumerate(lamps):
            along = place - points
            distance = np.linalg.norm(along, axis=1, keepdims=True)
            some = ((along * normals).sum(axis=1) > 0) & (distance[:, 0] > radius)
            along = along[some] * (1 - radius / distance[some])
            starts.append(points[some] + _APART * along)
            alongs.append((1 - _APART) * along)
            numbers.append(np.full(len(along), number))
        return cls(np.concatenate(numbers), np.concatenate(starts), np.concatenate(alongs))


def hidden_lamps(
    scene: bpy.types.Scene,
    subjects: Collection[bpy.types.Object],
    plan: CapturePlan,
    lamps: Sequence[tuple[bpy.types.Object, Floats, float]],
) -> Bools:
    """Whether each of some lamps is hidden from most points of the plan that face it: (L,).

    `lamps` are objects, places (3,) and radii. The `subjects`, which are baked, hide nothing here, nor does
    what lets light through or casts no shadow in a lamp's light. Raises BakeError where Blender does not
    render.
    """
    sights = Sights.of(plan, [(place, radius) for _, place, radius in lamps])
    blocked = np.zeros(len(sights.lamp), dtype=bool)
    trees: dict[Shape, BVHTree] = {}
    between = read_render(scene, lambda shown: list(_between(shown, frozenset(subjects), sights)))
    for item, placed in between:
        hides = np.array([shadows(lamp, item) for lamp, _, _ in lamps])
        if placed.shape not in trees:
            trees[placed.shape] = triangle_tree(placed.shape.position, placed.shape.triangles)
        turn = np.linalg.inv(placed.matrix)
        start = sights.start @ turn[:3, :3].T + turn[:3, 3]
        along = sights.along @ turn[:3, :3].T
        for ray in np.flatnonzero(~blocked & hides[sights.lamp]):
            length = float(np.linalg.norm(along[ray]))
            met = trees[placed.shape].ray_cast(Vector(start[ray]), Vector(along[ray] / length), length)
            blocked[ray] = met[0] is not None
    every = np.bincount(sights.lamp, minlength=len(lamps))
    return np.bincount(sights.lamp, blocked, minlength=len(lamps)) > every / 2


def _between(
    shown: Iterator[Shown], subjects: frozenset[bpy.types.Object], sights: Sights
) -> Iterator[tuple[bpy.types.Object, Placed]]:
    """Things whose boxes rays pass, and that may hide something."""
    for one in shown:
        if one.owner in subjects or "shadow" not in one.seen_by or is_clear(one.original):
            continue
        corners = one.bounds
        if not (np.abs(corners) < FARTHEST).all() or abs(np.linalg.det(one.matrix[:3, :3])) < _LEAST**3:
            continue
        if _pass(sights, corners.min(axis=0), corners.max(axis=0)).any() and one.shape is not None:
            yield one.original, Placed(one.shape, one.matrix, one.seen_by)


def _pass(sights: Sights, low: Floats, high: Floats) -> Bools:
    """Which rays pass a box, (R,): by the slabs between its sides."""
    along = np.where(np.abs(sights.along) < _LEAST, _LEAST, sights.along)
    one, other = (low - sights.start) / along, (high - sights.start) / along
    enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    passed: Bools = (enter <= leave) & (leave >= 0) & (enter <= 1)
    return passed
