# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums over samples, in the cells of octahedral buckets, and over neighbouring texels.

A fit works on K texels of n x n cells; their tables are (K*n*n, C), flat index k n² + y n + x.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..core.arrays import Floats, Ints
from ..core.octahedron import direction_to_octahedron, octahedron_taps
from .plan import CapturePlan

_KERNEL = np.array([0.054489, 0.244201, 0.402620, 0.244201, 0.054489], dtype=np.float32)  # sigma 1 texel
_WIDE = 3  # texels between the taps of the second, wider blur
_NEAR = 6.0  # times the usual distance of texels: farther ones belong to another island
SHARE = float((_KERNEL**2).sum() ** 2)  # of the variance of a sum that is left after pooling


@dataclass(frozen=True, eq=False)
class Taps:
    """Where samples fall in buckets of n x n cells: four cells each, (P,), and their weights."""

    cells: tuple[tuple[Ints, Floats], ...]
    count: int

    @classmethod
    def of(cls, axis: Floats, owner: Ints, texels: int, n: int) -> Taps:
        """`axis` (P, 3) of samples of the texels `owner` (P,), of `texels` in all."""
        found = octahedron_taps(direction_to_octahedron(axis), n)
        cells = ((cell + owner * np.int32(n * n), weight.astype(np.float32)) for cell, weight in found)
        return cls(tuple(cells), texels * n * n)

    def gather(self, table: Floats) -> Floats:
        """The table's values at the samples: (count, C) -> (P, C)."""
        total = np.zeros((len(self.cells[0][0]), table.shape[1]), dtype=np.float32)
        for cell, weight in self.cells:
            total += weight[:, None] * table[cell]
        return total

    def scatter(self, columns: list[Floats]) -> Floats:
        """Sums of the samples' columns, (P,) each, in the cells: (count, C) float32."""
        table = np.empty((self.count, len(columns)), dtype=np.float32)
        for index, column in enumerate(columns):
            sums = np.zeros(self.count)
            for cell, weight in self.cells:
                sums += np.bincount(cell, weight * column, self.count)
            table[:, index] = sums
        return table


@dataclass
class Neighbours:
    """The texels around each of a plan's, on the same piece of surface."""

    plan: CapturePlan
    _found: dict[int, list[tuple[Ints, Floats]]] = field(default_factory=dict)

    def pool(self, table: Floats, wide: bool = False) -> Floats:
        """Each texel's sums (K*n*n, C) with its neighbours', at the same world direction.

        A Gaussian of one texel; `wide`: of about three.
        """
        texels = table.reshape(len(self.plan.texel), -1)
        for step in (1, _WIDE) if wide else (1,):
            total = np.zeros_like(texels)
            for other, weight in self._around(step):
                total += weight[:, None] * texels[other]
            texels = total
        return texels.reshape(table.shape)

    def _around(self, step: int) -> list[tuple[Ints, Floats]]:
        """Texel numbers (K,) and weights (K,) of a kernel whose taps are `step` texels apart."""
        if step in self._found:
            return self._found[step]
        layout, count = self.plan.layout, len(self.plan.texel)
        place = self.plan.points
        reach = len(_KERNEL) // 2 * step
        number = np.full((layout.height + 2 * reach, layout.width + 2 * reach), -1, dtype=np.int32)
        j, i = self.plan.texel // layout.width + reach, self.plan.texel % layout.width + reach
        number[j, i] = np.arange(count)

        def offset(dy: int, dx: int) -> tuple[Ints, Floats]:
            other = number[j + dy, i + dx]
            apart = np.linalg.norm(place - place[np.maximum(other, 0)], axis=1)
            return other, np.where(other >= 0, apart, np.inf)

        _, apart = offset(0, 1) if layout.width > 1 else offset(1, 0)
        usual = float(np.median(apart[np.isfinite(apart)])) if np.isfinite(apart).any() else 0.0
        found = []
        for y, along_y in enumerate(_KERNEL):
            for x, along_x in enumerate(_KERNEL):
                dy, dx = (y - len(_KERNEL) // 2) * step, (x - len(_KERNEL) // 2) * step
                other, apart = offset(dy, dx)
                near = apart <= _NEAR * usual * max(step, float(np.hypot(dx, dy)))
                if near.any():
                    found.append((np.maximum(other, 0), (along_y * along_x * near).astype(np.float32)))
        self._found[step] = found
        return found


def upsampled(table: Floats, texels: int, n: int, finer: int) -> Floats:
    """Buckets of n x n cells looked up at the cells of finer ones: (K*n*n, C) -> (K*finer*finer, C)."""
    if n == finer:
        return table
    middle = ((np.arange(finer) + 0.5) / finer).astype(np.float32)
    place = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)
    buckets = table.reshape(texels, n * n, -1)
    total = np.zeros((texels, finer * finer, buckets.shape[2]), dtype=np.float32)
    for cell, weight in octahedron_taps(place, n):
        total += weight[None, :, None] * buckets[:, cell]
    return total.reshape(texels * finer * finer, -1)


def sums(index: Ints, values: npt.NDArray[Any], count: int) -> Floats:
    """Sums of values (P, C) by index: (count, C) float64."""
    columns = [np.bincount(index, values[:, c], count) for c in range(values.shape[1])]
    total: Floats = np.stack(columns, axis=-1).astype(np.float64)
    return total
