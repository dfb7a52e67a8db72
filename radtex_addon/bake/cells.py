# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The captured cells of a plan's texels: stored tile by tile, and read when needed."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator

import numpy as np

from ..core.arrays import Floats, Ints
from .piece_store import PieceStore
from .plan import CapturePlan, Tile

_CELLS = "cells"  # the array's name in a tile's piece
GAP = 16  # texels: gaps up to this are read too, which is faster than two reads


class Cells:
    """Cells (K, n, n, C) float32 of a plan's texels, in the plan's order; added in tiles of whole rows."""

    def __init__(self, plan: CapturePlan, store: PieceStore, channels: int) -> None:
        self.channels = channels
        self._plan, self._store = plan, store
        self._there = np.zeros(plan.rows, dtype=bool)
        self._starts: list[int] = []  # the tiles' first texels, in ascending order, and their pieces' names
        self._names: list[str] = []

    @property
    def texels(self) -> int:
        """The number of texels captured so far."""
        return min(int(self._there.sum()) * self._plan.columns, len(self._plan.texel))

    def restore(self) -> Iterator[tuple[Tile, Floats]]:
        """Use the tiles that an earlier session stored; yields each with its cells (k, n, n, C)."""
        shape = (self._plan.layout.bucket, self._plan.layout.bucket, self.channels)
        for name in self._store.names():
            tile = _tile(name)
            if tile is None or not 0 < tile.end <= len(self._there):
                continue
            if not tile.rows or self._there[tile.first_row : tile.end].any():
                continue
            kept = self._store.found(name)
            count = len(self._plan.texels_of(tile))
            cells = None if kept is None else kept.get(_CELLS)
            if cells is not None and cells.shape == (count, *shape) and cells.dtype == np.float32:
                self._add(tile, name)
                yield tile, cells

    def put(self, tile: Tile, cells: Floats) -> None:
        """Store a tile's cells (k, n, n, C). Raises BakeError where the system refuses."""
        name = f"tile-{tile.first_row:06d}-{tile.rows}"
        self._store.keep(name, {_CELLS: np.ascontiguousarray(cells, dtype=np.float32)})
        self._add(tile, name)

    def missing(self, most: int) -> Tile | None:
        """The first rows that are missing, at most `most` and within one sheet; None if there are none."""
        if self._there.all():
            return None
        first = int(np.argmin(self._there))
        after = self._there[first:]
        free = int(np.argmax(after)) if after.any() else len(after)
        height = self._plan.sheet_rows
        return Tile(first, min(most, free, height - first % height))

    def take(self, index: Ints) -> Floats:
        """Cells (k, n, n, C) of the texels with these indices in the plan, (k,), ascending.

        Raises BakeError where they can no longer be read.
        """
        n = self._plan.layout.bucket
        found: Floats = np.empty((len(index), n, n, self.channels), dtype=np.float32)
        done = 0
        while done < len(index):
            place = bisect_right(self._starts, index[done]) - 1
            start = self._starts[place]
            end = self._starts[place + 1] if place + 1 < len(self._starts) else len(self._plan.texel)
            of_tile = index[done : done + int(np.searchsorted(index[done:], end))]
            breaks = np.flatnonzero(np.diff(of_tile) > GAP) + 1
            for run in np.split(of_tile, breaks):
                first = int(run[0])
                rows = self._store.rows(self._names[place], _CELLS, first - start, int(run[-1]) - first + 1)
                found[done : done + len(run)] = rows[run - first]
                done += len(run)
        return found

    def _add(self, tile: Tile, name: str) -> None:
        start = tile.first_row * self._plan.columns
        place = bisect_right(self._starts, start)
        self._starts.insert(place, start)
        self._names.insert(place, name)
        self._there[tile.first_row : tile.end] = True


def _tile(name: str) -> Tile | None:
    """The tile in the piece of this name; None if it is not a tile's."""
    found = re.fullmatch(r"tile-(\d+)-(\d+)", name)
    return Tile(int(found[1]), int(found[2])) if found else None
