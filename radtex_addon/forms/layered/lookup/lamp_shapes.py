# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sharp lobe sees of a lamp that is a rectangle, a disc or a ball.

In the plane across its axis a lobe (see lobes.py) of a width² w, in units of √(2 w), is 1 / (π (1 + r²)²).
That is also how much of a small surface's light comes from each place of a plane before it, one unit away, by
its cosine. So how much of a lobe lies on a polygon is Lambert's formula for polygons, once what lies across
the axis is stretched by 1 / √(2 w) (Heitz et al., "Real-Time Polygonal-Light Shading with Linearly
Transformed Cosines", 2016). A disc is a polygon; what a lobe sees of a ball is a disc's view factor (Howell,
"A Catalog of Radiation Heat Transfer Configuration Factors", B-13).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import cast

import numpy as np

from ....core.arrays import Floats

SHARP = 8.0  # times the width² of a lamp's size: that of lobes which see its shape
MOST_SHARP = 0.04  # and no more than that: wide lobes are not flat
TINY = 1e-12
SHARPEST = 1e-6  # radians²: no lobe is narrower to a ball, as where clear things turn no ray
FAR = 1e3  # times the distance to a ball: what lies further aside is not on it
SIDES = 12  # of the polygon for a disc
DISC = float(np.sqrt(2 * np.pi / SIDES / np.sin(2 * np.pi / SIDES)))  # its radius: as large as the disc
BRIGHTEST = 4.0  # times as bright as from the middle: a lamp that is seen more squarely
# An angle up to 90° over the root of 1 - its cosine, by powers of that (Abramowitz and Stegun, 4.4.46).
ANGLE = (
    1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
    0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911,
)  # fmt: skip


class ShapeKind(StrEnum):
    """What a lamp is."""

    RECTANGLE = "rectangle"
    DISC = "disc"
    BALL = "ball"


@dataclass(frozen=True, eq=False)
class LampShape:
    """The shape of a lamp that is equally bright all over, and on one side alone unless it is a ball.

    `across` and `up` (3,): from its middle to the middles of two of its sides, so that their cross product
    points to the other side than the one that is bright; of a ball `across` is as long as its radius, and
    `up` 0. `solid`: how large it is as seen from the middle of what was baked, in steradians.
    """

    kind: ShapeKind
    across: Floats
    up: Floats
    solid: float

    def share(self, variance: Floats, size: Floats) -> Floats:
        """How far lobes of variances (N,) see the shape, 0 to 1: (N,). `size` (N,) is the lamp's variance."""
        most = np.minimum(SHARP * size, MOST_SHARP)
        return cast(Floats, np.clip(2 - variance / most, 0, 1).astype(np.float32))

    def facing(self, towards: Floats, place: Floats) -> Floats:
        """How bright it is as a blur, by how squarely it is seen: (N,), 1 from the middle, 0 from behind.

        `towards` (3, N) is its middle as seen from the places, `place` (3,) from the middle of the baked.
        """
        if self.kind == ShapeKind.BALL:
            return np.ones(towards.shape[1], dtype=np.float32)
        back = np.cross(self.across, self.up)
        here = back @ towards / np.maximum(np.linalg.norm(towards, axis=0), TINY)
        there = back @ place / np.linalg.norm(place)
        return cast(Floats, np.clip(here / max(float(there), TINY), 0, BRIGHTEST).astype(np.float32))

    def corners(self) -> Floats:
        """The corners of the polygon that it is, from its middle, (K, 3)."""
        count, radius = (SIDES, DISC) if self.kind == ShapeKind.DISC else (4, np.sqrt(2))
        turn = (np.arange(count) + 0.5) * 2 * np.pi / count
        around = np.cos(turn)[:, None] * self.across + np.sin(turn)[:, None] * self.up
        return np.asarray(radius * around, dtype=np.float32)

    def covered(self, towards: Floats, axis: Floats, variance: Floats) -> Floats:
        """The share of lobes about unit axes (3, N) that lies on it: (N,); `towards` as in `facing`."""
        if self.kind == ShapeKind.BALL:
            along = (towards * axis).sum(axis=0)
            aside = towards / np.maximum(along, TINY) - axis
            radius = float(self.across @ self.across)
            wide = radius / np.maximum((towards * towards).sum(axis=0) - radius, TINY)
            apart = np.minimum((aside * aside).sum(axis=0), FAR * FAR)
            wider = 2 * np.maximum(variance, SHARPEST)
            found = _disc(apart / wider, np.minimum(wide, FAR) / wider)
            return cast(Floats, np.where(along > 0, found, 0).astype(np.float32))
        blunt = np.sqrt(2 * variance) - 1
        seen = []
        for corner in self.corners():
            way = towards + corner[:, None]
            way = way + blunt * (way * axis).sum(axis=0) * axis
            seen.append(way / np.maximum(np.sqrt((way * way).sum(axis=0)), TINY))
        edges = [_edge(one, seen[number - 1], axis) for number, one in enumerate(seen)]
        found = np.sum(edges, axis=0)
        return cast(Floats, np.clip(found / (-2 * np.pi), 0, 1).astype(np.float32))


def _disc(distance: Floats, radius: Floats) -> Floats:
    """How much of the lobe lies on a disc at a squared distance from its axis, of a squared radius."""
    apart = distance - radius
    return 0.5 - 0.5 * (1 + apart) / np.sqrt(1 + 2 * (distance + radius) + apart * apart)


def _edge(one: Floats, other: Floats, axis: Floats) -> Floats:
    """Of a polygon's edge between unit vectors (3, N), the angle times its normal's part along the axis."""
    cosine = (one * other).sum(axis=0)
    near = np.abs(cosine)
    over = np.polyval(ANGLE[::-1], near) / np.sqrt(1 + near)  # the angle over its sine
    wide = np.pi / np.sqrt(np.maximum(1 - cosine * cosine, TINY)) - over
    normal = np.cross(one, other, axis=0)
    return cast(Floats, (normal * axis).sum(axis=0) * np.where(cosine < 0, wide, over))
