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

from ....core.arrays import Bools, Floats, Ints
from ....scene.checks.see_through import is_see_through
from ....scene.lights.linking import shadows
from ....scene.mesh.mesh_checks import FARTHEST
from ....scene.mesh.render_contents import Shape, Shown, read_render
from ....scene.mesh.triangle_tree import triangle_tree
from .enclosed import is_clear

_POINTS = 4096  # of the surface, from which is asked: a sun through a window is seen by few
_APART = 1e-4  # of the surface's size: what is nearer to a ray's start is what the point lies on
_LEAST = 1e-12  # component of a direction


@dataclass(frozen=True, eq=False)
class HideableLamp:
    """A lamp that may be hidden: the `item`, the `place` (3,) where renders have it, and its `radius`."""

    item: bpy.types.Object
    place: Floats
    radius: float


@dataclass(frozen=True, eq=False)
class Sights:
    """Rays from points of the baked surface: to which `lamp` (R,), from `start` (R, 3), `along` (R, 3)."""

    lamp: Ints
    start: Floats
    along: Floats

    @classmethod
    def of(cls, points: Floats, normals: Floats, lamps: Sequence[HideableLamp]) -> Sights:
        """From points (P, 3) that face the lamps by their unit normals (P, 3), to the lamps' near sides."""
        step = max(1, len(points) // _POINTS)
        points, normals = points[::step].astype(np.float64), normals[::step]
        apart = _APART * float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
        numbers, starts, alongs = [], [], []
        for number, lamp in enumerate(lamps):
            along = lamp.place - points
            distance = np.linalg.norm(along, axis=1, keepdims=True)
            some = ((along * normals).sum(axis=1) > 0) & (distance[:, 0] > lamp.radius + 2 * apart)
            unit, length = along[some] / distance[some], distance[some] - lamp.radius
            starts.append(points[some] + apart * unit)
            alongs.append((length - 2 * apart) * unit)
            numbers.append(np.full(len(unit), number))
        return cls(np.concatenate(numbers), np.concatenate(starts), np.concatenate(alongs))


def hidden_lamps(
    scene: bpy.types.Scene,
    subjects: Collection[bpy.types.Object],
    points: Floats,
    normals: Floats,
    lamps: Sequence[HideableLamp],
) -> Floats:
    """From which share of the points that face it each of some `lamps` is hidden: (L,), 0 if none faces it.

    `points` (P, 3) and their unit `normals` (P, 3) are in world space. The `subjects` hide nothing here, nor
    does what lets light through, what shadow rays do not see, or what a lamp's shadows or shadow linking
    leave out. Raises BakeError where Blender does not render.
    """
    sights = Sights.of(points, normals, lamps)
    blocked = np.zeros(len(sights.lamp), dtype=bool)
    trees: dict[Shape, BVHTree] = {}
    for between in read_render(scene, lambda shown: list(_between(shown, frozenset(subjects), sights))):
        shadowed = np.array([shadows(lamp.item, between.owner) for lamp in lamps])
        if between.shape not in trees:
            trees[between.shape] = triangle_tree(between.shape.position, between.shape.triangles)
        turn = np.linalg.inv(between.matrix)
        start = sights.start @ turn[:3, :3].T + turn[:3, 3]
        along = sights.along @ turn[:3, :3].T
        for ray in np.flatnonzero(~blocked & between.rays & shadowed[sights.lamp]):
            length = float(np.linalg.norm(along[ray]))
            met = trees[between.shape].ray_cast(Vector(start[ray]), Vector(along[ray] / length), length)
            blocked[ray] = met[0] is not None
    every = np.bincount(sights.lamp, minlength=len(lamps))
    found: Floats = np.bincount(sights.lamp, blocked, minlength=len(lamps)) / np.maximum(every, 1)
    return found


@dataclass(frozen=True, eq=False)
class _Between:
    """Faces in the way of `rays` (R,): whose they are, their `shape`, its `matrix` (4, 4) to the world."""

    owner: bpy.types.Object
    shape: Shape
    matrix: Floats
    rays: Bools


def _between(
    shown: Iterator[Shown], subjects: frozenset[bpy.types.Object], sights: Sights
) -> Iterator[_Between]:
    """Things whose boxes rays pass, and that may hide something."""
    for one in shown:
        if one.owner in subjects or "shadow" not in one.seen_by:
            continue
        corners = one.bounds
        if not (np.abs(corners) < FARTHEST).all() or abs(np.linalg.det(one.matrix[:3, :3])) < _LEAST**3:
            continue
        passing = _pass(sights, corners.min(axis=0), corners.max(axis=0))
        if not passing.any():
            continue
        shape = one.shape_without(_lets_through) if is_clear(one.original) else one.shape
        if shape is not None:
            yield _Between(one.owner, shape, one.matrix, passing)


def _lets_through(material: bpy.types.Material) -> bool:
    return is_see_through(material, glass=True)


def _pass(sights: Sights, low: Floats, high: Floats) -> Bools:
    """Which rays pass a box, (R,): by the slabs between its sides."""
    along = np.where(np.abs(sights.along) < _LEAST, _LEAST, sights.along)
    one, other = (low - sights.start) / along, (high - sights.start) / along
    enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    passed: Bools = (enter <= leave) & (leave >= 0) & (enter <= 1)
    return passed
