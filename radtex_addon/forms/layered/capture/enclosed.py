# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects inside a clear one, such as a bubble or a thing cast in glass.

Light that comes through the clear object may meet them on its way, so they belong to what it passes through,
not to the surroundings: a picture of those from the middle would be taken among them, or inside one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ....core.arrays import Floats
from ....core.errors import InputError
from ....cycles.path_ends import Body, black_material
from ....scene.checks.see_through import is_see_through, materials_of
from ....scene.lights.light import without_emission
from ....scene.mesh.copy import baked_mesh
from ....scene.mesh.evaluated import evaluate
from ....scene.mesh.render_contents import Shown, read_render
from ....scene.mesh.triangle_tree import triangle_tree

_HALF = 0.5  # of an object's box
_RAYS = 32  # from its middle, evenly over the sphere
_ENCLOSED = 0.75  # of them that meet the clear object, where it lies inside
_LEAST = 1e-9  # length of a box's side


def is_clear(item: bpy.types.Object) -> bool:
    """Whether a material of the object lets light through: transparent, glass, or refractive."""
    return any(is_see_through(material, glass=True) for material in materials_of(item))


@contextmanager
def enclosed(scratch: bpy.types.Scene, bodies: Sequence[Body]) -> Iterator[tuple[Body, ...]]:
    """The mesh objects of the scratch scene that lie inside clear ones of the `bodies`, as further bodies.

    Those that let no light through are black: paths end there. What emits light is left out: the surroundings
    show a lamp sharper than the rest of the light could. The bodies' meshes are removed at the end.
    """
    hulls = [_Hull.of(body) for body in bodies if is_clear(body.original)]
    baked = {body.original for body in bodies}

    def inside(shown: Iterator[Shown]) -> list[bpy.types.Object]:
        meshes = (one for one in shown if not one.is_instance and one.original.type == "MESH")
        others = (one for one in meshes if one.original not in baked and not _shines(one.original))
        return [one.original for one in others if any(hull.has_inside(one.bounds) for hull in hulls)]

    found: list[Body] = []
    try:
        there = read_render(scratch, inside) if hulls else []
        found.extend(body for item in there if (body := _body(scratch, item)))
        yield tuple(found)
    finally:
        bpy.data.batch_remove([body.mesh for body in found])


def _shines(item: bpy.types.Object) -> bool:
    return any(without_emission(material) is not material for material in materials_of(item))


@dataclass(frozen=True, eq=False)
class _Hull:
    """A clear object: its box, `low` and `high` (3,), and its triangles, in world space."""

    low: Floats
    high: Floats
    triangles: BVHTree

    @classmethod
    def of(cls, body: Body) -> _Hull:
        places = body.places
        vertices = np.empty(3 * len(body.mesh.polygons), dtype=np.int32)
        cast(Any, body.mesh.loops).foreach_get("vertex_index", vertices)
        tree = triangle_tree(places.astype(np.float32), vertices.reshape(-1, 3))
        return cls(places.min(axis=0), places.max(axis=0), tree)

    def has_inside(self, corners: Floats) -> bool:
        """Whether half of a box with corners (8, 3) is in this one's, and triangles are around its middle."""
        if not np.isfinite(corners).all():
            return False
        low, high = corners.min(axis=0), corners.max(axis=0)
        inside = np.clip(np.minimum(high, self.high) - np.maximum(low, self.low), 0, None)
        size = np.maximum(high - low, _LEAST)
        if np.prod(np.maximum(inside, _LEAST) / size) < _HALF:
            return False
        middle = Vector(((low + high) / 2).tolist())
        met = [self.triangles.ray_cast(middle, Vector(ray.tolist()))[0] for ray in _directions(_RAYS)]
        return sum(place is not None for place in met) >= _ENCLOSED * _RAYS


def _directions(count: int) -> Floats:
    """Unit vectors (count, 3), evenly over the sphere: a spiral by the golden angle."""
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = np.arange(count) * np.pi * (3 - 5**0.5)
    wide = np.sqrt(1 - height**2)
    return np.stack([wide * np.cos(turn), wide * np.sin(turn), height], axis=1)


def _body(scratch: bpy.types.Scene, item: bpy.types.Object) -> Body | None:
    """The object as a body; None if Cycles shows another mesh than can be read."""
    try:
        mesh = evaluate(scratch, item)
    except InputError:
        return None
    shown = baked_mesh(mesh, np.zeros((len(mesh.triangles), 3, 2), dtype=np.float32))
    if not is_clear(item):
        shown.materials.clear()
        shown.materials.append(black_material())
    return Body(item, shown, mesh.matrix_world)
