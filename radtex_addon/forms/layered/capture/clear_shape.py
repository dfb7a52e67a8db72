# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The distance field of clear objects: of closed meshes of one glass, through which rays can be followed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ....core.arrays import Bools, Floats, Ints
from ....cycles.path_ends import Body
from ....scene.checks.see_through import colour_at, value_at
from ....scene.mesh.joined import values_in
from ....scene.mesh.panes import glass_in
from ....scene.mesh.triangle_tree import triangle_tree
from ..cells import FIELD_SAMPLES
from ..lookup.distance_field import DistanceField, FieldFacts
from .gloss_maps import width_of

_MARGIN = 2  # samples outside the objects' box at each end
_CLOSED = 0.95  # share of the samples on whose sign rays along all axes agree, at least
_OUTWARDS = 0.9  # share of the samples beside the surface that its normals point away from, or to, at least
_BESIDE = 1.0  # steps
_ON = 1e-4  # steps: behind a surface that was met
_APART = np.array([0.31, 0.53, 0.71]) * 1e-3  # steps: so that rays meet no edge of an even mesh
_ALIKE = 1e-3  # of an index of refraction, a roughness, and a colour
_DARKEST = 1e-3  # part of a colour


def find_distance_field(
    scene: bpy.types.Scene, bodies: Sequence[Body], middle: Floats
) -> DistanceField | None:
    """The field of bodies that are one glass, and closed; None of others. `middle` (3,): of the surroundings.

    Paths in it are as long as the scene lets them be.
    """
    glass = _glass_of(bodies)
    if glass is None:
        return None
    corners, normals = (np.concatenate(parts) for parts in zip(*map(_surface, bodies), strict=True))
    centre, step, axes = _axes(corners.reshape(-1, 3))
    corners = (corners - centre) / step  # in steps, about the middle: single floats tell little else
    tree = triangle_tree(
        corners.reshape(-1, 3).astype(np.float32), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    )
    signs = [_inside(tree, axes, axis, 4 * len(corners)) for axis in range(3)]
    inside = np.sum(signs, axis=0) >= 2
    if np.mean([(each == inside).mean() for each in signs]) < _CLOSED or not inside.any():
        return None
    place = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    near, face, distance = _nearest(tree, place)
    normal = _shaded(corners[face], normals[face], near)
    signed = np.where(inside.ravel(), -distance, distance)
    beside = (distance < _BESIDE) & (distance > 1e-3)
    away = np.where(inside.ravel(), -1, 1)[beside] * ((place - near)[beside] * normal[beside]).sum(axis=1)
    if not beside.any() or (away > 0).mean() < _OUTWARDS:
        return None
    values = np.concatenate([normal, signed[:, None]], axis=1).reshape(*map(len, axes), 4)
    bounces = int(cast(Any, scene).cycles.glossy_bounces)
    facts = FieldFacts(
        size=cast("tuple[int, int, int]", tuple(map(len, axes))),
        low=(centre - middle + step * np.array([axis[0] for axis in axes])).astype(np.float32),
        step=float(np.float32(step)),
        ior=float(np.float32(glass.ior)),
        slopes=float(width_of(np.array(glass.roughness))) / 4 if glass.roughness else 0.0,  # mirrors: twice
        reflections=min(bounces, int(cast(Any, scene).cycles.max_bounces)),
        tint=glass.tint,
        tints_reflections=glass.tints_reflections,
    )
    return DistanceField(np.ascontiguousarray(values.transpose(2, 1, 0, 3), dtype=np.float32), facts)


@dataclass(frozen=True, order=True)
class _Glass:
    """What glass is of; as in `FieldFacts`."""

    ior: float
    roughness: float
    tint: tuple[float, float, float]
    tints_reflections: bool


def _glass_of(bodies: Sequence[Body]) -> _Glass | None:
    """All that bodies show; None if that is not one glass. Where it has several colours, it has no tint."""
    found: list[_Glass] = []
    for material in set[bpy.types.Material | None]().union(*(body.shown_materials for body in bodies)):
        glass = None if material is None else glass_in(material, 1.0)
        if glass is None:
            return None
        found.append(_read_glass(glass))
    if not found or min(found).ior < 1 + _ALIKE:
        return None
    first, *others = sorted(found)
    if any(max(abs(one.ior - first.ior), abs(one.roughness - first.roughness)) > _ALIKE for one in others):
        return None
    colours = np.array([[*one.tint, one.tints_reflections] for one in found])
    return first if np.ptp(colours, axis=0).max() < _ALIKE else replace(first, tint=(1.0, 1.0, 1.0))


def _read_glass(node: Any) -> _Glass:
    """A Glass shader has its colour at each surface, a Principled one its square root where it refracts."""
    principled = node.type == "BSDF_PRINCIPLED"
    ior, roughness = (cast(float, value_at(node.inputs[name], ())) for name in ("IOR", "Roughness"))
    colour = colour_at(node.inputs["Base Color" if principled else "Color"], ()) or (1.0, 1.0, 1.0)
    red, green, blue = np.clip(np.sqrt(colour) if principled else colour, _DARKEST, 1).tolist()
    return _Glass(ior, roughness, (red, green, blue), not principled)


def _surface(body: Body) -> tuple[Floats, Floats]:
    """A body's triangles, and their corners' shading normals, not of unit length: (F, 3, 3), world space."""
    normal = values_in(cast(Any, body.mesh).corner_normals, "vector", 3).astype(np.float64)
    turned = normal @ np.linalg.inv(body.matrix[:3, :3])
    return body.places[body.shape.triangles], turned.reshape(-1, 3, 3)


def _axes(place: Floats) -> tuple[Floats, float, list[Floats]]:
    """The middle (3,) of the samples, the step between them, and how many steps from there they lie.

    The latter along x, y and z.
    """
    low, high = place.min(axis=0), place.max(axis=0)
    step = float((high - low).max()) / (FIELD_SAMPLES - 1 - 2 * _MARGIN)
    counts = np.ceil((high - low) / step - 1e-6).astype(int) + 1 + 2 * _MARGIN
    return (low + high) / 2, step, [np.arange(count) - (count - 1) / 2 for count in counts]


def _inside(tree: BVHTree, axes: Sequence[Floats], axis: int, most: int) -> Bools:
    """Which samples (x, y, z) lie behind an odd number of surfaces, along one axis; `most`: met by a ray."""
    first, second = (other for other in range(3) if other != axis)
    along = axes[axis]
    found = np.zeros((len(axes[first]), len(axes[second]), len(along)), dtype=bool)
    way = np.zeros(3)
    way[axis] = 1.0
    start = np.zeros(3)
    start[axis] = along[0] - 1
    for row, one in enumerate(axes[first] + _APART[0]):
        for column, other in enumerate(axes[second] + _APART[1]):
            start[first], start[second] = one, other
            met = _crossings(tree, start, way, axis, most)
            found[row, column] = np.searchsorted(met, along + _APART[2]) % 2 == 1
    return np.moveaxis(found, 2, axis)


def _crossings(tree: BVHTree, start: Floats, way: Floats, axis: int, most: int) -> Floats:
    """Where along an axis a ray meets surfaces, in order, no more than `most`."""
    place, met = Vector(start.tolist()), list[float]()
    towards = Vector(way.tolist())
    while (hit := tree.ray_cast(place, towards)[0]) is not None and len(met) < most:
        met.append(hit[axis])
        place[axis] = max(hit[axis], place[axis]) + _ON
    return np.array(met)


def _nearest(tree: BVHTree, place: Floats) -> tuple[Floats, Ints, Floats]:
    """The nearest places (N, 3) of the surface to places (N, 3), their triangles and distances (N,)."""
    find = cast(Any, tree).find_nearest
    found = [find(one) for one in place.tolist()]
    near = np.array([tuple(one[0]) for one in found])
    return near, np.array([one[2] for one in found]), np.array([one[3] for one in found])


def _shaded(corners: Floats, normals: Floats, place: Floats) -> Floats:
    """Unit shading normals (N, 3) at places (N, 3) of triangles; `corners` and their `normals` (N, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    one, other, to = b - a, c - a, place - a
    squared, across, along = ((x * y).sum(axis=1) for x, y in ((one, one), (one, other), (other, other)))
    to_one, to_other = (to * one).sum(axis=1), (to * other).sum(axis=1)
    whole = np.maximum(squared * along - across**2, 1e-30)
    second = np.clip((along * to_one - across * to_other) / whole, 0, 1)
    third = np.clip((squared * to_other - across * to_one) / whole, 0, 1)
    shares = np.stack([np.maximum(1 - second - third, 0), second, third], axis=1)
    mixed = (shares[..., None] * normals).sum(axis=1)
    unit: Floats = mixed / np.maximum(np.linalg.norm(mixed, axis=1, keepdims=True), 1e-12)
    return unit
