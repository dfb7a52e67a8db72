# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cast rays at all that a render shows, and tell which side of what they meet."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...core.arrays import Bools, Floats, Ints
from ...core.islands import weld
from ...core.surface import is_closed
from ..checks.see_through import is_see_through, materials_of
from .evaluated import EvaluatedMesh
from .mesh_checks import FARTHEST
from .render_contents import Shape, Shown, read_render
from .triangle_tree import triangle_tree

_MOST = 1_000  # things that rays are cast at: the largest
_FLAT = 1e-30  # determinant of a matrix that leaves no volume
_LEAST = 1e-12  # component of a direction
_MARGIN = 1e-5  # times the size of a box: room around it for what is rounded


@dataclass(frozen=True, eq=False)
class Thing:
    """Triangles in the world: the `cast` of a tree of them in object space, and `into` (4, 4) that space.

    `low`, `high` (3,): its box in the world. `solid`: it encloses a volume, and its front sides are outside.
    """

    cast: Any
    into: Floats
    low: Floats
    high: Floats
    solid: bool


@dataclass(frozen=True, eq=False)
class Met:
    """What K rays meet first: the `thing`'s number, -1 where they leave the scene, and at which `distance`.

    `distance` is in scene units, infinite where they leave; `front`: they meet a front side; `solid`: the
    inside of what encloses a volume.
    """

    distance: Floats
    thing: Ints
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
    places = [
        shape.position.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3] for shape, matrix in placed
    ]
    size = np.array([np.ptp(place, axis=0).max() for place in places])
    trees: dict[Shape, tuple[Any, bool]] = {}
    found = []
    for index in np.sort(np.argsort(-size, kind="stable")[:_MOST]).tolist():
        shape, matrix = placed[index]
        if shape not in trees:
            trees[shape] = _tree_of(shape.position, shape.triangles)
        cast, solid = trees[shape]
        place = places[index]
        found.append(Thing(cast, np.linalg.inv(matrix), place.min(axis=0), place.max(axis=0), solid))
    return found


def thing_of(mesh: EvaluatedMesh) -> Thing:
    """The mesh as a thing, whatever its materials."""
    place = mesh.world_position[np.unique(mesh.triangles)]
    cast, solid = _tree_of(mesh.position, mesh.triangles)
    return Thing(cast, np.linalg.inv(mesh.matrix_world), place.min(axis=0), place.max(axis=0), solid)


def cast_rays(things: Sequence[Thing], start: Floats, way: Floats) -> Met:
    """What rays from `start` (K, 3) along unit vectors `way` (K, 3), in the world, meet first."""
    distance = np.full(len(start), np.inf)
    number = np.full(len(start), -1, dtype=np.int64)
    front, solid = np.zeros((2, len(start)), dtype=bool)
    for index, thing in enumerate(things):
        enter = _enters(thing, start, way)
        own = start @ thing.into[:3, :3].T + thing.into[:3, 3]
        along = way @ thing.into[:3, :3].T
        stretch = np.linalg.norm(along, axis=1)
        for ray in np.flatnonzero(enter < distance).tolist():
            length = float(stretch[ray])
            reach = min(float(distance[ray]) * length, FARTHEST)
            _, normal, _, there = thing.cast(Vector(own[ray]), Vector(along[ray] / length), reach)
            if there is not None:
                distance[ray], number[ray] = there / length, index
                front[ray] = normal.dot(Vector(along[ray])) < 0
                solid[ray] = thing.solid and not front[ray]
    return Met(distance, number, front, solid)


def _opaque(shown: Iterator[Shown], without: frozenset[bpy.types.Object]) -> Iterator[tuple[Shape, Floats]]:
    """Shapes that camera rays meet, and their matrices (4, 4) to the world."""
    for one in shown:
        if "camera" not in one.seen_by or (one.original in without and not one.is_instance):
            continue
        if not (np.abs(one.bounds) < FARTHEST).all() or abs(np.linalg.det(one.matrix[:3, :3])) < _FLAT:
            continue
        clear = any(map(_is_clear, materials_of(one.original)))
        shape = one.shape_without(_is_clear) if clear else one.shape
        if shape is not None:
            yield shape, one.matrix


def _is_clear(material: bpy.types.Material) -> bool:
    return is_see_through(material, glass=True)


def _tree_of(position: Floats, triangles: Ints) -> tuple[Any, bool]:
    """The `cast` and `solid` of `Thing`."""
    a, b, c = (position.astype(np.float64) - position.mean(axis=0))[triangles].transpose(1, 0, 2)
    volume = float((np.cross(a, b) * c).sum())
    solid = volume > 0 and is_closed(weld(position)[triangles])
    return triangle_tree(position, triangles).ray_cast, solid


def _enters(thing: Thing, start: Floats, way: Floats) -> Floats:
    """At which distance rays enter the thing's box, (K,): 0 if they start in it, infinite if they miss it."""
    along = np.where(np.abs(way) < _LEAST, _LEAST, way)
    margin = _MARGIN * (thing.high - thing.low).max()
    one, other = (thing.low - margin - start) / along, (thing.high + margin - start) / along
    enter = np.maximum(np.minimum(one, other).max(axis=1), 0)
    return np.where(enter <= np.maximum(one, other).min(axis=1), enter, np.inf)
