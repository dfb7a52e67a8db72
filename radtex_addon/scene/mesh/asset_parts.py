# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Group surfaces into assets: those that touch, without what surrounds them, such as a floor or a room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Floats
from .touching import Surface, touching_groups

_FLAT = 0.03  # of its size: what is thinner is flat
_UPRIGHT = 0.7  # the height of a unit normal below which a flat thing stands upright
# So many times as large as the others, a thing is no part of their asset:
_FAR_LARGER = 8.0  # whatever its shape
_ENCLOSING = 2.0  # if all others are within its box, as in a room or before a studio's backdrop
_PLATE = 4.0  # if it is flat; the others are those that are not
_WALL = 1.5  # if it is flat and stands upright, or lies below all others
_SLACK = 0.02  # of its size, by which others may stick out of a box, or be lower than a floor


@dataclass(frozen=True, eq=False)
class _Shape:
    """What tells parts from surroundings: a box (2, 3), its diagonal, and whether it is flat, and upright."""

    box: Floats
    size: float
    flat: bool
    upright: bool

    @classmethod
    def of(cls, surface: Surface) -> _Shape:
        points = surface.samples - surface.samples.mean(axis=0)
        _, axes = np.linalg.eigh(points.T @ points)
        thickness = float(np.ptp(points @ axes[:, 0]))
        flat = thickness <= _FLAT * surface.size
        return cls(surface.box, surface.size, flat, abs(float(axes[2, 0])) < _UPRIGHT)

    def surrounds(self, others: Sequence[_Shape]) -> bool:
        """Whether it is a floor, a wall, a room or the like to the others, of which there is at least one."""
        slack = _SLACK * self.size
        largest = max(one.size for one in others)
        if self.size >= _FAR_LARGER * largest:
            return True
        if self.size >= _ENCLOSING * largest and all(self._contains(one, slack) for one in others):
            return True
        solid = [one for one in others if not one.flat]
        if not self.flat or not solid:
            return False
        below = all(self.box[1, 2] <= one.box[0, 2] + slack for one in others)
        most = _WALL if self.upright or below else _PLATE
        return self.size >= most * max(one.size for one in solid)

    def _contains(self, other: _Shape, slack: float) -> bool:
        return bool(
            (other.box[0] >= self.box[0] - slack).all() and (other.box[1] <= self.box[1] + slack).all()
        )


def asset_groups(surfaces: Sequence[Surface]) -> list[tuple[int, ...]]:
    """Indices of the surfaces that belong together, two or more in each group, in the order given.

    What touches is one asset, but for what is far larger than all else in it and flat, or encloses it.
    """
    shapes: dict[int, _Shape] = {}
    left = list(range(len(surfaces)))
    while True:
        numbers = touching_groups([surfaces[index] for index in left])
        groups = [
            tuple(index for index, number in zip(left, numbers, strict=True) if number == one)
            for one in dict.fromkeys(numbers.tolist())
        ]
        groups = [group for group in groups if len(group) > 1]
        for group in groups:
            shapes |= {index: _Shape.of(surfaces[index]) for index in group if index not in shapes}
        around = {
            index
            for group in groups
            for index in group
            if shapes[index].surrounds([shapes[other] for other in group if other != index])
        }
        if not around:
            return groups
        left = [index for group in groups for index in group if index not in around]
        left.sort()
