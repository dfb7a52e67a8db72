# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sharp lobe sees of a lamp that is a rectangle, a disc or a ball.

In the plane across its axis a lobe (see lobes.py) of a width² w, in units of √(2 w), is 1 / (π (1 + r²)²).
That is also how much of a small surface's light comes from each place of a plane before it, one unit away.
So how much of a lobe lies on a shape is known in closed form: it is the view factor of a rectangle, and of a
disc (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-4 and B-13).
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
FAR = 1e3  # times half of a lamp's side, or the distance to a ball: what lies further aside is not on it
LARGEST = 1e4  # half of a lamp's side, in a lobe's units


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

    def faces(self, towards: Floats) -> Floats:
        """Whether places see its bright side, with the lamp's middle (3, N) from there: 0 or 1 (N,)."""
        if self.kind == ShapeKind.BALL:
            return np.ones(towards.shape[1], dtype=np.float32)
        return (np.cross(self.across, self.up) @ towards > 0).astype(np.float32)

    def covered(self, towards: Floats, axis: Floats, variance: Floats) -> Floats:
        """The share of lobes about unit axes (3, N) that lies on it: (N,); `towards` as in `faces`."""
        sharp = 1 / np.sqrt(2 * variance)
        if self.kind == ShapeKind.BALL:
            along = (towards * axis).sum(axis=0)
            aside = towards / np.maximum(along, TINY) - axis
            radius = float(self.across @ self.across)
            wide = radius / np.maximum((towards * towards).sum(axis=0) - radius, TINY)
            apart = np.minimum((aside * aside).sum(axis=0), FAR * FAR)
            found = _disc(apart * sharp**2, np.minimum(wide, FAR) * sharp**2)
            return cast(Floats, np.where(along > 0, found, 0).astype(np.float32))
        normal = np.cross(self.across, self.up)
        facing = np.maximum(normal @ axis, TINY)
        reach = np.maximum(normal @ towards, 0) / facing
        met = reach * axis - towards
        x, y = (np.clip(line @ met / (line @ line), -FAR, FAR) for line in (self.across, self.up))
        across, up = (line[:, None] - axis * (line @ axis) for line in (self.across, self.up))
        near = facing / np.maximum(reach, TINY) * sharp  # the halves of its sides, in the lobe's units
        high, wide = (
            np.minimum(near / np.sqrt(np.maximum((line * line).sum(axis=0), TINY)), LARGEST)
            for line in (across, up)
        )
        if self.kind == ShapeKind.DISC:
            found = _disc(*_as_circle(x, y, wide, high))
        else:
            left, right, low, top = -(1 + x) * wide, (1 - x) * wide, -(1 + y) * high, (1 - y) * high
            found = _corner(right, top) - _corner(left, top) - _corner(right, low) + _corner(left, low)
        return cast(Floats, np.where(normal @ axis > 0, found, 0).astype(np.float32))


def _disc(distance: Floats, radius: Floats) -> Floats:
    """How much of the lobe lies on a disc at a squared distance from its axis, of a squared radius."""
    apart = distance - radius
    return 0.5 - 0.5 * (1 + apart) / np.sqrt(1 + 2 * (distance + radius) + apart * apart)


def _as_circle(x: Floats, y: Floats, wide: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The squared distance and radius of a circle for an ellipse, whose halves are `wide` and `high`.

    The axis meets its plane at (x, y), in units of these. In the middle and far away it is exact.
    """
    across, up, area = wide * wide, high * high, wide * high
    radius = area * (np.sqrt((1 + across) * (1 + up)) + area) / (1 + across + up)
    inside = x * x + y * y
    beyond = (x * x * across + y * y * up) * (1 - 1 / np.maximum(inside, 1))
    return radius * np.minimum(inside, 1) + beyond, radius


def _corner(x: Floats, y: Floats) -> Floats:
    """How much of the lobe lies between its axis and a corner at (x, y), below 0 in two of the quarters."""
    across, up = x / np.sqrt(1 + x * x), y / np.sqrt(1 + y * y)
    long, high = y / np.sqrt(1 + x * x), x / np.sqrt(1 + y * y)
    return (across * np.arctan(long) + up * np.arctan(high)) / (2 * np.pi)
