# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays from all over a mesh's triangles, and regions of triangles that hang together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...bake.progress import Progress, Stage, Steps
from ...core.arrays import Bools, Floats, Ints, blocks
from ...core.frame import normalised
from ...core.islands import components
from ...core.surface import ray_offset

_AT_ONCE = 1 << 14  # rays between two reports of progress
_OFF = 0.05  # times a bake's ray offset: how far off a triangle rays start; thin walls must be thicker
_INSET = 0.1  # share of the way to the triangle's middle: keeps rays' starts away from its edges
_FARTHEST = 1e19  # Blender squares the distance in single floats
_GRAZING = 1e-3  # cosine: what is seen at less is not
_SPREAD = 3  # how often each triangle's value is averaged with its neighbours' values


def leaving_rays(
    position: Floats,
    triangles: Ints,
    tree: BVHTree,
    face: Ints,
    side: float,
    stop: bool = False,
    far: float = math.inf,
) -> Steps[Bools]:
    """Which rays from triangles `face` (K,) leave the `tree`, (K,); yields progress in rays.

    The triangles (F, 3) have vertices at `position` (V, 3). Rays start anywhere in them, cosine-distributed,
    in front for a `side` of 1, behind for -1. A ray that meets nothing before it is so `far` leaves. With
    `stop`, rays after the first that leave are not cast.
    """
    random = np.random.default_rng(0)
    starts = _Starts.drawn(position, triangles, face, random)
    anywhere = random.normal(size=(len(face), 3))
    cast: Any = tree.ray_cast
    reach = min(far, _FARTHEST)
    free = np.zeros(len(face), dtype=bool)
    for some in blocks(len(face), _AT_ONCE):
        yield Progress(Stage.EVALUATE, some.start, len(face))
        place, outwards = starts.at(some, side)
        ways = normalised(outwards + 0.999 * normalised(anywhere[some]))
        free[some] = [
            cast(Vector(start), Vector(way), reach)[0] is None
            for start, way in zip(place.tolist(), ways.tolist(), strict=True)
        ]
        if stop and free[some].any():
            break
    return free


def seen_from_points(
    position: Floats, triangles: Ints, tree: BVHTree, face: Ints, points: Floats
) -> Steps[Bools]:
    """Which places on triangles `face` (K,) are seen, from in front, from a point drawn of (P, 3): (K,).

    The triangles (F, 3) have vertices at `position` (V, 3); what is in the `tree` hides. Yields progress in
    rays.
    """
    random = np.random.default_rng(0)
    starts = _Starts.drawn(position, triangles, face, random)
    drawn = points[random.integers(0, len(points), len(face))]
    cast: Any = tree.ray_cast
    seen = np.zeros(len(face), dtype=bool)
    for some in blocks(len(face), _AT_ONCE):
        yield Progress(Stage.EVALUATE, some.start, len(face))
        place, outwards = starts.at(some, 1)
        way = drawn[some] - place
        length = np.linalg.norm(way, axis=1)
        way /= np.maximum(length, 1e-30)[:, None]
        facing = (way * outwards).sum(axis=1) > _GRAZING
        seen[some] = [
            ahead and cast(Vector(start), Vector(along), far)[0] is None
            for ahead, start, along, far in zip(
                facing.tolist(), place.tolist(), way.tolist(), length.tolist(), strict=True
            )
        ]
    return seen


@dataclass(frozen=True, eq=False)
class _Starts:
    """Where rays start on triangles `face` (K,): at random places, away from edges, a little off."""

    position: Floats
    triangles: Ints
    face: Ints
    root: Floats
    along: Floats
    off: float

    @classmethod
    def drawn(cls, position: Floats, triangles: Ints, face: Ints, random: np.random.Generator) -> _Starts:
        root, along = np.sqrt(random.random(len(face)))[:, None], random.random(len(face))[:, None]
        return cls(position, triangles, face, root, along, _OFF * ray_offset(position))

    def at(self, some: slice, side: float) -> tuple[Floats, Floats]:
        """Places and normals of some of them, (k, 3) each, on that `side` of the triangles."""
        corners = self.position[self.triangles[self.face[some]]].astype(np.float64)
        a, b, c = corners.transpose(1, 0, 2)
        outwards = side * normalised(np.cross(b - a, c - a))
        root, along = self.root[some], self.along[some]
        place = a * (1 - root) + root * ((1 - along) * b + along * c)
        place += _INSET * (corners.mean(axis=1) - place)
        place += self.off * outwards
        return place, outwards


def rays_per_triangle(area: Floats, total: int, least: int, most: int) -> Ints:
    """How many of about `total` rays start at each triangle, in proportion to `area` (F,): (F,)."""
    least = max(1, min(least, total // len(area)))
    found: Ints = np.clip(np.rint(total * area / area.sum()), least, most).astype(np.int64)
    return found


def spread_to_neighbours(values: Floats, first: Ints, second: Ints) -> Floats:
    """Values (F,) of triangles, averaged with their neighbours'; edges join `first` and `second` (E,)."""
    count = np.bincount(np.concatenate([first, second]), minlength=len(values)) + 1
    for _ in range(_SPREAD):
        total = values + np.bincount(first, values[second], len(values))
        values = (total + np.bincount(second, values[first], len(values))) / count
    return values


def having_neighbours(some: Bools, first: Ints, second: Ints) -> Bools:
    """The triangles that have a neighbour in `some`."""
    found = np.zeros_like(some)
    found[first[some[second]]] = True
    found[second[some[first]]] = True
    return found


def regions(some: Bools, first: Ints, second: Ints) -> Ints:
    """Labels (F,) of the connected regions of `some` triangles; each other triangle is its own region."""
    inside = some[first] & some[second]
    return components(np.stack([first[inside], second[inside]], axis=1), len(some))


def small_regions(some: Bools, first: Ints, second: Ints, area: Floats, least: Floats) -> Bools:
    """Those of `some` triangles whose connected region has less area than `least` (F,)."""
    label = regions(some, first, second)
    found: Bools = some & (np.bincount(label, area)[label] < least)
    return found
