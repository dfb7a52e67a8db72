# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks of hidden cells, one bit each: a byte for each cell of a large atlas would take too much memory.

They, and gutters, are filled from the nearest texel that has the cell.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..core.arrays import Bools, Floats
from ..core.gutter import dilate, nearest_covered
from .progress import Progress, Stage


def fill_missing(
    buckets: Floats, covered: Bools, hidden: Bools | None = None
) -> Generator[Progress, None, None]:
    """Fill buckets (H, W, n, n, C) in place where texels are not `covered` (H, W) or cells are `hidden`.

    A missing cell takes the value of the same cell in the nearest texel that has it, by distance in texels.
    `hidden` is (H, W, n, n); only covered texels count. A cell that is hidden in all texels keeps its value.
    Yields progress in directions, as each direction with hidden cells has its own nearest texels.
    """
    everywhere = nearest_covered(covered)
    dilate(buckets, everywhere)
    if hidden is None:
        return
    directions = np.argwhere((hidden & covered[..., None, None]).any(axis=(0, 1)))
    for done, (q, p) in enumerate(directions):
        yield Progress(Stage.FILL, done, len(directions))
        seen = covered & ~hidden[:, :, q, p]
        if seen.any():
            dilate(buckets[:, :, q, p], nearest_covered(seen))


@dataclass(frozen=True, eq=False)
class HiddenCells:
    """Hidden cells of K texels: `bits` (K, ceil(n * n / 8)), the marks of cells [q, p] packed row by row."""

    bits: npt.NDArray[np.uint8]
    bucket: int

    @classmethod
    def of(cls, cells: Bools) -> HiddenCells:
        """Pack marks (K, n, n)."""
        return cls(np.packbits(cells.reshape(len(cells), -1), axis=1), cells.shape[1])

    def __len__(self) -> int:
        return len(self.bits)

    @property
    def cells(self) -> Bools:
        """A mark for every cell: (K, n, n)."""
        n = self.bucket
        marks = np.unpackbits(self.bits, axis=1, count=n * n)
        return marks.view(bool).reshape(-1, n, n)

    @property
    def buried(self) -> Bools:
        """Marks of the texels whose cells are all hidden: (K,)."""
        full = np.packbits(np.ones(self.bucket**2, dtype=bool))
        found: Bools = (self.bits == full).all(axis=1)
        return found

    def of_texels(self, chosen: Bools) -> HiddenCells:
        """The marks of the `chosen` (K,) texels only."""
        return HiddenCells(self.bits[chosen], self.bucket)

    def directions(self) -> Iterator[tuple[int, int]]:
        """The cells [q, p] that are hidden in some texels, but not in all."""
        n = self.bucket
        some = np.unpackbits(np.bitwise_or.reduce(self.bits, axis=0), count=n * n).astype(bool)
        every = np.unpackbits(np.bitwise_and.reduce(self.bits, axis=0), count=n * n).astype(bool)
        for cell in np.flatnonzero(some & ~every).tolist():
            q, p = divmod(cell, n)
            yield q, p

    def of_direction(self, q: int, p: int) -> Bools:
        """Marks of the texels whose cell [q, p] is hidden: (K,)."""
        byte, bit = divmod(q * self.bucket + p, 8)
        found: Bools = (self.bits[:, byte] & (0x80 >> bit)).astype(bool)
        return found
