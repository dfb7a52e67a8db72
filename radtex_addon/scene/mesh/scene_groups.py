# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Group the surfaces of a whole scene into few atlases: its shell, and what stands in it by nearness.

The shell is what is large and flat or encloses the rest, as floors, walls and rooms do, and what lies flat on
that: mirrors, pictures, rugs, skirting.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Bools, Floats
from .touching import Surface, touching_groups

_FLAT = 0.06  # of its size: what is thinner is flat
_LARGER = 1.5  # times the largest thing that is not flat: so large a flat thing is of the shell
_BOUNDING = 0.3  # of the size of all solid things: so large it is, if these are on one side of it
_ONE_SIDE = 0.95  # of the others: they are on one side
_ENCLOSED = 0.9  # of the others: what has so many within its box, and is …
_ENCLOSING = 2.0  # … times as large as the largest of them, encloses them
_SLACK = 0.02  # of a shell thing's size: what lies flat on it is no farther from it
_PARALLEL = 0.95  # the least cosine between the normals of what lies flat and that on which it lies
_MOST_GROUPS = 4  # of what stands in the shell, if few enough texels do
_SPREAD = 0.3  # of the size of all that stands: near things come closer, and share an atlas in any case


@dataclass(frozen=True)
class SceneGroup:
    """Surfaces, by their indices, that share an atlas; `is_shell`: they enclose, or carry, all others."""

    members: tuple[int, ...]
    is_shell: bool


@dataclass(frozen=True, eq=False)
class _Shapes:
    """Boxes (N, 2, 3) and sizes (N,) of all surfaces, normals (N, 3) across their flattest side, flatness."""

    boxes: Floats
    sizes: Floats
    normals: Floats
    flat: Bools

    @classmethod
    def of(cls, surfaces: Sequence[Surface]) -> _Shapes:
        boxes = np.stack([each.box for each in surfaces])
        sizes = np.array([each.size for each in surfaces])
        normals, thick = np.empty((len(surfaces), 3)), np.empty(len(surfaces))
        for index, each in enumerate(surfaces):
            points = each.samples - each.samples.mean(axis=0)
            normals[index] = np.linalg.eigh(points.T @ points)[1][:, 0]
            thick[index] = np.ptp(points @ normals[index])
        return cls(boxes, sizes, normals, thick <= _FLAT * sizes)

    @property
    def middles(self) -> Floats:
        """The middles of the boxes, (N, 3)."""
        found: Floats = self.boxes.mean(axis=1)
        return found

    def enclosing(self) -> Bools:
        """Which surfaces, not flat, have nearly all others in their box, and are much larger, (N,)."""
        found = np.zeros(len(self.sizes), dtype=bool)
        for one in np.flatnonzero(~self.flat):
            others = np.arange(len(self.sizes)) != one
            low, high = self.boxes[one]
            slack = _SLACK * self.sizes[one]
            inside = ((self.middles >= low - slack) & (self.middles <= high + slack)).all(axis=1)
            solid = others & inside & ~self.flat
            largest = self.sizes[solid].max(initial=0.0)
            found[one] = (
                others.any()
                and inside[others].mean() >= _ENCLOSED
                and self.sizes[one] >= _ENCLOSING * largest
            )
        return found

    def bounding(self, solid: Bools) -> Bools:
        """Which flat surfaces are large beside the `solid` things, or have them on one side, (N,)."""
        if not solid.any():
            return self.flat.copy()
        largest = float(self.sizes[solid].max())
        inner = self.boxes[solid]
        whole = float(np.linalg.norm(inner[:, 1].max(axis=0) - inner[:, 0].min(axis=0)))
        along = self.middles @ self.normals.T  # (N, N): of each middle along each normal
        beyond = along - np.diag(along) > 0
        above = beyond[solid].mean(axis=0)
        on_one_side = np.maximum(above, 1 - above) >= _ONE_SIDE
        at_least = _LARGER * largest
        large = self.sizes >= at_least
        large |= on_one_side & (self.sizes >= min(_BOUNDING * whole, at_least))
        found: Bools = self.flat & large
        return found

    def lie_on(self, one: int) -> Bools:
        """Which flat surfaces lie flat on the surface `one` of the shell, which is flat, or near its box."""
        reach = _SLACK * self.sizes[one]
        low, high = self.boxes[one]
        meets = (self.boxes[:, 0] <= high + reach) & (self.boxes[:, 1] >= low - reach)
        near = self.flat & meets.all(axis=1) & (self.sizes <= _ENCLOSING * self.sizes[one])
        if not self.flat[one]:  # a room in one piece: what is near one of the sides of its box
            sides = np.minimum(np.abs(self.boxes - low), np.abs(self.boxes - high)).max(axis=1)
            along = np.abs(self.normals).argmax(axis=1)
            found: Bools = near & (np.take_along_axis(sides, along[:, None], axis=1)[:, 0] <= 2 * reach)
            return found
        parallel = np.abs(self.normals @ self.normals[one]) >= _PARALLEL
        away = np.abs((self.middles - self.middles[one]) @ self.normals[one])
        thickness = np.abs((high - low) @ np.abs(self.normals[one])) / 2
        own = ((self.boxes[:, 1] - self.boxes[:, 0]) @ np.abs(self.normals[one])) / 2
        lies: Bools = near & parallel & (away <= thickness + own + reach)
        return lies


def scene_groups(
    surfaces: Sequence[Surface], needs: Floats, most: float, apart: Bools | None = None
) -> list[SceneGroup]:
    """Groups of all surfaces, the shell's first, each with the members in the order given.

    `needs` (N,) are the texels that each wants, and a group has at most `most`, unless one surface, or those
    of one thing whose parts touch, want more. What is `apart` (N,), such as panes of glass, is no part of the
    shell. What touches is in one group; groups that are near each other are joined until four are left, and
    then only if they are very near. The same surfaces make the same groups.
    """
    if not len(surfaces):
        return []
    shapes = _Shapes.of(surfaces)
    shell = _shell(shapes, apart if apart is not None else np.zeros(len(surfaces), dtype=bool))
    inside = np.flatnonzero(~shell).tolist()
    numbers = touching_groups([surfaces[index] for index in inside])
    things = [
        [index for index, number in zip(inside, numbers, strict=True) if number == one]
        for one in dict.fromkeys(numbers.tolist())
    ]
    walls = _joined([[index] for index in np.flatnonzero(shell).tolist()], shapes, needs, most, 1)
    furniture = _joined(things, shapes, needs, most, _MOST_GROUPS)
    return [
        SceneGroup(tuple(sorted(members)), is_shell)
        for groups, is_shell in ((walls, True), (furniture, False))
        for members in sorted(groups, key=min)
    ]


def _shell(shapes: _Shapes, apart: Bools) -> Bools:
    """Which surfaces are of the shell, (N,)."""
    around = shapes.enclosing() & ~apart
    solid = ~shapes.flat & ~around
    found: Bools = (around | shapes.bounding(solid)) & ~apart
    left = list(np.flatnonzero(found))
    while left:  # what lies flat on it, and on that
        more = shapes.lie_on(int(left.pop())) & ~found & ~apart
        found |= more
        left += list(np.flatnonzero(more))
    return found


def _joined(
    groups: Sequence[list[int]], shapes: _Shapes, needs: Floats, most: float, count: int
) -> list[list[int]]:
    """The groups, the nearest two of which are joined again and again while they want few enough texels.

    Nearest are those that have the smallest common box. Where no more than `count` are left, only those
    that are very near each other are joined, or all, if one is to be left.
    """
    found = [list(group) for group in groups]
    if len(found) < 2:
        return found
    low = np.stack([shapes.boxes[group, 0].min(axis=0) for group in found])
    high = np.stack([shapes.boxes[group, 1].max(axis=0) for group in found])
    need = np.array([needs[group].sum() for group in found])
    whole = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))

    def common(one: int) -> Floats:
        """The diagonals of the boxes of one group with each, (G,); infinite where they may not be joined."""
        size = np.linalg.norm(np.maximum(high, high[one]) - np.minimum(low, low[one]), axis=1)
        size[(need + need[one] > most) | ~there | ~there[one]] = np.inf
        size[one] = np.inf
        return np.asarray(size)

    there = np.ones(len(found), dtype=bool)
    sizes = np.stack([common(one) for one in range(len(found))])
    while there.sum() > 1:
        one, other = sorted(int(index) for index in np.unravel_index(sizes.argmin(), sizes.shape))
        if not np.isfinite(sizes[one, other]):
            break
        if there.sum() <= count and sizes[one, other] > _SPREAD * whole:
            break
        found[one] += found[other]
        low[one], high[one] = np.minimum(low[one], low[other]), np.maximum(high[one], high[other])
        need[one] += need[other]
        there[other] = False
        sizes[other] = sizes[:, other] = np.inf
        sizes[one] = sizes[:, one] = common(one)
    return [group for group, is_there in zip(found, there, strict=True) if is_there]
