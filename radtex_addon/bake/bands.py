# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The atlas in bands of rows: texels in their places, gutters and hidden cells filled, never all at once.

A missing cell takes the value that the nearest texel, in texels, has for the same cell. Which texel that is
depends on the direction wherever some texel's cell is hidden: it is found for one direction after another,
and lies with the keeper until its band comes.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
import numpy.typing as npt

from ..core.arrays import Bools, Floats, Ints
from ..core.gutter import nearest_covered
from .cells import Cells
from .hidden import HiddenCells
from .keeper import Keeper, Pile
from .plan import CapturePlan
from .progress import Progress, Stage

_BAND_BYTES = 1 << 25  # of a band's cells
_HELD_BYTES = 1 << 25  # of texels that fill others: less is quicker found again than kept
_PAIRS = "pairs"  # the array's name in a direction's piece


@dataclass(frozen=True, eq=False)
class Band:
    """Rows of texels from `first` on: `buckets` (h, W, n, n, C) float32, whole."""

    first: int
    buckets: Floats

    @property
    def end(self) -> int:
        """The row behind its last."""
        return self.first + len(self.buckets)


@dataclass(frozen=True, eq=False)
class Bands:
    """Makes bands of an atlas; `nearest` (H*W,) int32 is each texel's place in the plan, or its nearest's.

    For the directions [q, p] in `instead`, a piece of the keeper has pairs (E, 2) of a texel's flat index,
    ascending, and the place of another that serves it there; `instead` says where each row's pairs begin.
    """

    plan: CapturePlan
    cells: Cells
    keeper: Keeper
    nearest: Ints
    instead: dict[tuple[int, int], Ints]

    @property
    def rows(self) -> int:
        """Of texels in a band, at most."""
        layout = self.plan.layout
        return max(1, _BAND_BYTES // (layout.width * layout.bucket**2 * self.cells.channels * 4))

    def __len__(self) -> int:
        return ceil(self.plan.layout.height / self.rows)

    def downwards(self) -> Iterator[Band]:
        """All bands, the top one first. Raises BakeError where cells can no longer be read."""
        height = self.plan.layout.height
        for number in reversed(range(len(self))):
            first = number * self.rows
            yield self._band(first, min(first + self.rows, height))

    def _band(self, first: int, end: int) -> Band:
        width, n = self.plan.layout.width, self.plan.layout.bucket
        place, where = np.unique(self.nearest[first * width : end * width], return_inverse=True)
        buckets = self.cells.take(place)[where.ravel()]
        texel, cell, source = self._instead(first, end)
        order = np.argsort(source, kind="stable")
        most = self.rows * width  # buckets in hand, beside the band's own
        for some in np.array_split(order, ceil(len(order) / most)) if len(order) else ():
            place, where = np.unique(source[some], return_inverse=True)
            values = self.cells.take(place).reshape(len(place), n * n, -1)
            flat = buckets.reshape(len(buckets), n * n, -1)
            flat[texel[some] - first * width, cell[some]] = values[where.ravel(), cell[some]]
        return Band(first, buckets.reshape(end - first, width, n, n, -1))

    def _instead(self, first: int, end: int) -> tuple[Ints, Ints, Ints]:
        """Flat indices of texels, cells q * n + p of theirs, and the places that serve them: (E,) each."""
        pairs, cells = [np.empty((0, 2), dtype=np.int32)], [np.empty(0, dtype=np.int32)]
        for (q, p), starts in self.instead.items():
            begin, count = int(starts[first]), int(starts[end] - starts[first])
            if count:
                pairs.append(self.keeper.rows(_name(q, p), _PAIRS, begin, count))
                cells.append(np.full(count, q * self.plan.layout.bucket + p, dtype=np.int32))
        texel, source = np.concatenate(pairs).T
        return texel, np.concatenate(cells), source


def find_bands(
    plan: CapturePlan, cells: Cells, keeper: Keeper, hidden: HiddenCells | None
) -> Generator[Progress, None, Bands]:
    """Find what fills gutters, and the cells that are `hidden`; yields progress in directions.

    A cell that is hidden everywhere keeps what it holds. The `keeper` is given what is found, if it is much.
    """
    layout = plan.layout
    place = np.zeros(layout.height * layout.width, dtype=np.int32)
    place[plan.texel] = np.arange(len(plan.texel))
    nearest = place[_flat_nearest(plan.covered)]
    instead: dict[tuple[int, int], Ints] = {}
    directions = [] if hidden is None else list(hidden.directions())
    if len(nearest) * len(directions) * 8 <= _HELD_BYTES:
        keeper = Pile()
    for done, (q, p) in enumerate(directions):
        yield Progress(Stage.FILL, done, len(directions))
        assert hidden is not None  # or there were no directions
        kept = keeper.found(_name(q, p))
        if kept is None:
            kept = {_PAIRS: _pairs(plan, place, nearest, hidden.of_direction(q, p))}
            keeper.keep(_name(q, p), kept)
        rows = np.arange(layout.height + 1) * layout.width
        instead[q, p] = np.searchsorted(kept[_PAIRS][:, 0], rows)
    return Bands(plan, cells, keeper, nearest, instead)


def _pairs(plan: CapturePlan, place: Ints, nearest: Ints, hidden: Bools) -> npt.NDArray[np.int32]:
    """Texels whose nearest one's cell is `hidden` (K,), and the places of those that have it."""
    texel = np.flatnonzero(hidden[nearest])
    seen = plan.covered.copy()
    seen.ravel()[plan.texel[hidden]] = False
    return np.stack([texel, place[_flat_nearest(seen)][texel]], axis=1).astype(np.int32)


def _flat_nearest(covered: Bools) -> Ints:
    """Flat index of every texel's nearest covered one: (H*W,)."""
    j, i = nearest_covered(covered)
    flat: Ints = (j.astype(np.int64) * covered.shape[1] + i).ravel()
    return flat


def _name(q: int, p: int) -> str:
    return f"fill-{q:03d}-{p:03d}"
