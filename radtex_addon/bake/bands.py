# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Assemble the atlas in bands of rows, with gutters and hidden cells filled, so that memory stays small.

A missing cell takes the value of the same cell in the nearest texel that has it, by distance in texels. For
hidden cells the nearest texel differs between directions: it is searched for one direction after another, and
the result is kept in the store until the bands are assembled.
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
from .hidden_cells import HiddenCells
from .piece_store import MemoryStore, PieceStore
from .plan import CapturePlan
from .progress import Progress, Stage

_BAND_BYTES = 1 << 25  # size of a band's cells
_HELD_BYTES = 1 << 25  # keep fill sources in memory up to this size; a resumed bake recomputes them
_PAIRS = "pairs"  # the array's name in a direction's piece


@dataclass(frozen=True, eq=False)
class Band:
    """Rows of texels from row `first` on: `buckets` (h, W, n, n, C) float32, with nothing left to fill."""

    first: int
    buckets: Floats

    @property
    def end(self) -> int:
        """The row after the last one."""
        return self.first + len(self.buckets)


@dataclass(frozen=True, eq=False)
class Bands:
    """Assembles the bands of an atlas.

    `nearest` (H*W,) int32: each texel's index in the plan, or for a gutter texel that of the nearest covered
    one. `instead` has the directions [q, p] with hidden cells. For each, a piece of the store has pairs
    (E, 2): a texel's flat index, ascending, and the plan's index of the texel that fills this cell; the
    values of `instead` (H + 1,) say where each row's pairs begin.
    """

    plan: CapturePlan
    cells: Cells
    store: PieceStore
    nearest: Ints
    instead: dict[tuple[int, int], Ints]

    @property
    def rows(self) -> int:
        """The most rows of texels in a band."""
        layout = self.plan.layout
        return max(1, _BAND_BYTES // (layout.width * layout.bucket**2 * self.cells.channels * 4))

    def __len__(self) -> int:
        return ceil(self.plan.layout.height / self.rows)

    def downwards(self) -> Iterator[Band]:
        """All bands, from the top. Raises BakeError where cells can no longer be read."""
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
        most = self.rows * width  # buckets in memory, beside the band's own
        for some in np.array_split(order, ceil(len(order) / most)) if len(order) else ():
            place, where = np.unique(source[some], return_inverse=True)
            values = self.cells.take(place).reshape(len(place), n * n, -1)
            flat = buckets.reshape(len(buckets), n * n, -1)
            flat[texel[some] - first * width, cell[some]] = values[where.ravel(), cell[some]]
        return Band(first, buckets.reshape(end - first, width, n, n, -1))

    def _instead(self, first: int, end: int) -> tuple[Ints, Ints, Ints]:
        """What fills hidden cells of these rows: texels' flat indices, cells q * n + p, sources: (E,) each.

        A source is the plan's index of the texel whose cell is taken instead.
        """
        pairs, cells = [np.empty((0, 2), dtype=np.int32)], [np.empty(0, dtype=np.int32)]
        for (q, p), starts in self.instead.items():
            begin, count = int(starts[first]), int(starts[end] - starts[first])
            if count:
                pairs.append(self.store.rows(_name(q, p), _PAIRS, begin, count))
                cells.append(np.full(count, q * self.plan.layout.bucket + p, dtype=np.int32))
        texel, source = np.concatenate(pairs).T
        return texel, np.concatenate(cells), source


def find_bands(
    plan: CapturePlan, cells: Cells, store: PieceStore, hidden: HiddenCells | None
) -> Generator[Progress, None, Bands]:
    """Find what fills gutters and `hidden` cells; yields progress in directions.

    A cell that is hidden in all texels keeps its value. Large results are stored by the `store`.
    """
    layout = plan.layout
    place = np.zeros(layout.height * layout.width, dtype=np.int32)
    place[plan.texel] = np.arange(len(plan.texel))
    nearest = place[_flat_nearest(plan.covered)]
    instead: dict[tuple[int, int], Ints] = {}
    directions = [] if hidden is None else list(hidden.directions())
    if len(nearest) * len(directions) * 8 <= _HELD_BYTES:
        store = MemoryStore()
    for done, (q, p) in enumerate(directions):
        yield Progress(Stage.FILL, done, len(directions))
        assert hidden is not None  # otherwise there are no directions
        kept = store.found(_name(q, p))
        if kept is None:
            kept = {_PAIRS: _pairs(plan, place, nearest, hidden.of_direction(q, p))}
            store.keep(_name(q, p), kept)
        rows = np.arange(layout.height + 1) * layout.width
        instead[q, p] = np.searchsorted(kept[_PAIRS][:, 0], rows)
    return Bands(plan, cells, store, nearest, instead)


def _pairs(plan: CapturePlan, place: Ints, nearest: Ints, hidden: Bools) -> npt.NDArray[np.int32]:
    """The pairs (E, 2) of a direction that is `hidden` in some texels (K,): texels to fill, and sources."""
    texel = np.flatnonzero(hidden[nearest])
    seen = plan.covered.copy()
    seen.ravel()[plan.texel[hidden]] = False
    return np.stack([texel, place[_flat_nearest(seen)][texel]], axis=1).astype(np.int32)


def _flat_nearest(covered: Bools) -> Ints:
    """Flat index of the nearest covered texel for every texel: (H*W,)."""
    j, i = nearest_covered(covered)
    flat: Ints = (j.astype(np.int64) * covered.shape[1] + i).ravel()
    return flat


def _name(q: int, p: int) -> str:
    return f"fill-{q:03d}-{p:03d}"
