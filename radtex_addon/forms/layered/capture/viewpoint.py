# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From where the surroundings are pictured: the object's middle, or beside what stands there.

A vase in the middle of a table top has that middle inside: seen from there, all is dark, and the table would
not mirror the vase.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import cast

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ....bake.plan import CapturePlan
from ....core.arrays import Floats
from ....scene.mesh.render_contents import Shape, Shown, read_render
from ....scene.mesh.triangle_tree import triangle_tree
from .enclosed import even_directions

_RAYS = 32  # from a place, that tell whether a thing is around it
_AROUND = 0.75  # of the rays, at least
_POINTS = 256  # of the surface, beside which another place is looked for
_FEW = 32  # of these, that tell whether a thing is around the surface, too
_OFF = 0.1  # of the object's radius: how far another place is off the surface, and from the thing


def viewpoint(
    scratch: bpy.types.Scene,
    subjects: Collection[bpy.types.Object],
    plan: CapturePlan,
    middle: Floats,
    radius: float,
) -> Floats:
    """The `middle` (3,) of the plan's points, or a place near it if another thing is around that.

    What most of the surface lies in as well, such as a room, does not count, nor do the `subjects`, which are
    baked. `radius` is that of a sphere around the points. Raises BakeError where Blender does not render.
    """
    found = read_render(scratch, lambda shown: list(_with_inside(shown, frozenset(subjects), middle)))
    there = [_Thing.of(shape, matrix) for shape, matrix in found]  # not while the render is read
    if not there:
        return middle
    step = max(1, len(plan.points) // _POINTS)
    points, normals = plan.points[::step].astype(np.float64), plan.normal.reshape(-1, 3)
    normals = normals[: len(plan.points) : step]
    few = points[:: max(1, len(points) // _FEW)]
    things = [
        thing for thing in there if thing.is_around(middle) and np.mean([*map(thing.is_around, few)]) < 0.5
    ]
    if not things:
        return middle
    places = points + _OFF * radius * normals
    for place in places[np.argsort(np.linalg.norm(places - middle, axis=1))]:
        if not any(thing.is_around(place) or thing.is_near(place, _OFF * radius) for thing in things):
            return cast(Floats, place.astype(np.float32))
    return middle


@dataclass(frozen=True, eq=False)
class _Thing:
    """Triangles, in a space of their own, and the matrix (4, 4) from that to the world."""

    triangles: BVHTree
    matrix: Floats

    @classmethod
    def of(cls, shape: Shape, matrix: Floats) -> _Thing:
        return cls(triangle_tree(shape.position, shape.triangles), matrix)

    def is_around(self, place: Floats) -> bool:
        """Whether most rays from a place (3,) meet it."""
        turn = np.linalg.inv(self.matrix)
        start = Vector((turn[:3, :3] @ place + turn[:3, 3]).tolist())
        rays = even_directions(_RAYS)
        met = [self.triangles.ray_cast(start, Vector(ray.tolist()))[0] for ray in rays]
        return sum(found is not None for found in met) >= _AROUND * _RAYS

    def is_near(self, place: Floats, distance: float) -> bool:
        """Whether it comes as near to a place (3,) as that."""
        turn = np.linalg.inv(self.matrix)
        nearest = self.triangles.find_nearest(Vector((turn[:3, :3] @ place + turn[:3, 3]).tolist()))[0]
        if nearest is None:
            return False
        world = self.matrix[:3, :3] @ np.array(nearest) + self.matrix[:3, 3]
        return float(np.linalg.norm(world - place)) < distance


def _with_inside(
    shown: Iterator[Shown], subjects: frozenset[bpy.types.Object], place: Floats
) -> Iterator[tuple[Shape, Floats]]:
    """What gloss sees, and whose box has a place (3,) inside."""
    for one in shown:
        if one.owner in subjects or "glossy" not in one.seen_by:
            continue
        low, high = one.bounds.min(axis=0), one.bounds.max(axis=0)
        if not ((low < place) & (place < high)).all() or not np.isfinite(one.matrix).all():
            continue
        if abs(np.linalg.det(one.matrix[:3, :3])) > 0 and one.shape is not None:
            yield one.shape, one.matrix
