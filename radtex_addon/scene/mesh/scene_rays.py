# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cast rays at all that a render shows, and tell which side of what they meet."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.arrays import Bools, Floats, Ints
from ...core.islands import weld
from ...core.surface import is_closed
from ..checks.see_through import is_see_through, materials_of
from .mesh_checks import FARTHEST
from .render_contents import Shape, Shown, read_render
from .triangle_tree import triangle_tree

_MOST = 1_000  # things that rays are cast at: the largest
_FLAT = 1e-30  # determinant of a matrix that leaves no volume
_LEAST = 1e-12  # component of a direction
_SAME = 1e-5  # times the extent of all things: faces that are less apart are in one place
_MARGIN = 1e-5  # times the size of a box: room around it for what is rounded


@dataclass(frozen=True, eq=False)
class Thing:
    """A shape in the world: its `matrix` (4, 4) to the world, and a `tree` of its triangles in object space.

    `low`, `high` (3,): its box in the world. `solid`: it encloses a volume, and its front sides are outside.
    """

    shape: Shape
    matrix: Floats
    tree: BVHTree
    solid: bool
    low: Floats
    high: Floats

    @classmethod
    def of(cls, shape: Shape, matrix: Floats, known: dict[Shape, tuple[BVHTree, bool]]) -> Thing:
        """The thing; trees that are `known` are not made again."""
        if shape not in known:
            solid = _volume(shape) > 0 and is_closed(weld(shape.position)[shape.triangles])
            known[shape] = triangle_tree(shape.position, shape.triangles), solid
        place = shape.position[np.unique(shape.triangles)] @ matrix[:3, :3].T + matrix[:3, 3]
        return cls(shape, matrix, *known[shape], place.min(axis=0), place.max(axis=0))

    @cached_property
    def position(self) -> Floats:
        """Its vertices in the world, (V, 3) float64."""
        found: Floats = self.shape.position.astype(np.float64) @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return found

    @property
    def triangles(self) -> Ints:
        """Its triangles, (F, 3), the way round that they have in the world."""
        mirrored = np.linalg.det(self.matrix[:3, :3]) < 0
        return self.shape.triangles[:, ::-1] if mirrored else self.shape.triangles


@dataclass(frozen=True, eq=False)
class Met:
    """What K rays meet first: which `thing`, and which of its triangles; -1 where they leave the scene.

    `distance` is in scene units, infinite where they leave; `front`: they meet a front side; `solid`: the
    inside of what encloses a volume.
    """

    distance: Floats
    thing: Ints
    triangle: Ints
    front: Bools
    solid: Bools

    @property
    def leaves(self) -> Bools:
        """Which rays leave the scene."""
        found: Bools = self.thing < 0
        return found


def read_things(scratch: bpy.types.Scene, without: Collection[bpy.types.Object]) -> list[Thing]:
    """All faces that camera rays meet in a render of a scratch scene, but those of the objects `without`.

    Clear materials are left out, as they hide nothing; of very many things the largest are taken. Raises
    BakeError where Blender does not render.
    """
    placed = read_render(scratch, lambda shown: list(_opaque(shown, frozenset(without))))
    size = np.array([extent for _, _, extent in placed])
    known: dict[Shape, tuple[BVHTree, bool]] = {}
    largest = np.sort(np.argsort(-size, kind="stable")[:_MOST]).tolist()
    return [Thing.of(placed[index][0], placed[index][1], known) for index in largest]


def extent_of(things: Sequence[Thing]) -> float:
    """The diagonal of the box around all things, in scene units."""
    low, high = (np.array([getattr(thing, end) for thing in things]) for end in ("low", "high"))
    return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))


def cast_rays(things: Sequence[Thing], start: Floats, way: Floats) -> Met:
    """What rays from `start` (K, 3) along unit vectors `way` (K, 3), in the world, meet first.

    Of two faces in one place, as where a box stands on a floor, the one that a ray meets from behind counts.
    """
    if not things:
        return _nothing(len(start))
    same = _SAME * extent_of(things)
    found = _nothing(len(start))
    distance, front = found.distance, found.front
    for index, thing in enumerate(things):
        cast: Any = thing.tree.ray_cast
        into = np.linalg.inv(thing.matrix)
        own, along = start @ into[:3, :3].T + into[:3, 3], way @ into[:3, :3].T
        stretch = np.linalg.norm(along, axis=1)
        for ray in np.flatnonzero(_enters(thing, start, way) < distance + same).tolist():
            length, before = float(stretch[ray]), float(distance[ray])
            reach = min((before + same) * length, FARTHEST)
            _, normal, face, there = cast(Vector(own[ray]), Vector(along[ray] / length), reach)
            if there is None:
                continue
            here, is_front = there / length, normal.dot(Vector(along[ray])) < 0
            if here < before - same or (front[ray], before) > (is_front, here):
                distance[ray], front[ray] = here, is_front
                found.thing[ray], found.triangle[ray] = index, face
                found.solid[ray] = thing.solid and not is_front
    return found


def _nothing(rays: int) -> Met:
    """What rays meet that leave the scene at once."""
    nothing = np.full((2, rays), -1, dtype=np.int64)
    return Met(np.full(rays, np.inf), nothing[0], nothing[1], *np.zeros((2, rays), dtype=bool))


def _opaque(
    shown: Iterator[Shown], without: frozenset[bpy.types.Object]
) -> Iterator[tuple[Shape, Floats, float]]:
    """Shapes that camera rays meet, their matrices (4, 4) to the world, and their extents there."""
    for one in shown:
        if "camera" not in one.seen_by or (one.original in without and not one.is_instance):
            continue
        corners = one.bounds
        if not (np.abs(corners) < FARTHEST).all() or abs(np.linalg.det(one.matrix[:3, :3])) < _FLAT:
            continue
        clear = any(map(_is_clear, materials_of(one.original)))
        shape = one.shape_without(_is_clear) if clear else one.shape
        if shape is not None:
            yield shape, one.matrix, float(np.ptp(corners, axis=0).max())


def _is_clear(material: bpy.types.Material) -> bool:
    return is_see_through(material, glass=True)


def _volume(shape: Shape) -> float:
    """Six times the volume that the shape encloses, below 0 if its front sides are inside."""
    middle = shape.position.mean(axis=0)
    a, b, c = (shape.position.astype(np.float64) - middle)[shape.triangles].transpose(1, 0, 2)
    return float((np.cross(a, b) * c).sum())


def _enters(thing: Thing, start: Floats, way: Floats) -> Floats:
    """At which distance rays enter the thing's box, (K,): 0 if they start in it, infinite if they miss it."""
    along = np.where(np.abs(way) < _LEAST, _LEAST, way)
    margin = _MARGIN * (thing.high - thing.low).max()
    one, other = (thing.low - margin - start) / along, (thing.high + margin - start) / along
    enter = np.maximum(np.minimum(one, other).max(axis=1), 0)
    return np.where(enter <= np.maximum(one, other).min(axis=1), enter, np.inf)
