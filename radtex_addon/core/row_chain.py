# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mip levels of an image that arrives in bands of rows, since it may be larger than memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from .arrays import Floats

Halving: TypeAlias = Callable[[int, Floats], tuple[Floats, int]]
"""Halves rows of a level: (first row's number, rows) -> (rows of the next level, number of rows used up)."""

Take: TypeAlias = Callable[[int, int, Floats], None]
"""Receives rows: (level, number of the first row, rows (..., k, W, C))."""


class RowChain:
    """Compute mip levels from bands of rows; `take` receives each level's rows in order, as soon as possible.

    There is one of the `halvings` for each level but the last. A level buffers only the rows that its halving
    has not used up.
    """

    def __init__(self, halvings: Sequence[Halving], take: Take) -> None:
        self._halvings, self._take = halvings, take
        self._first = [0] * (len(halvings) + 1)  # the next row of each level
        self._held: list[Floats | None] = [None] * len(halvings)

    def push(self, rows: Floats, level: int = 0) -> None:
        """Append rows (..., k, W, C), float32, to the level, by default the largest one."""
        if not rows.shape[-3]:
            return
        self._take(level, self._first[level], rows)
        self._first[level] += rows.shape[-3]
        if level == len(self._halvings):
            return
        held = self._held[level]
        waiting = rows if held is None else np.concatenate([held, rows], axis=-3)
        halved, used = self._halvings[level](self._first[level] - waiting.shape[-3], waiting)
        self._held[level] = waiting[..., used:, :, :].copy()
        self.push(halved, level + 1)
