# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mip levels of an image that comes a band of rows at a time, for it may be larger than memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from .arrays import Floats

Halving: TypeAlias = Callable[[int, Floats], tuple[Floats, int]]
"""Of a level's rows, from a number on: the next level's rows that they make, and how many that uses up."""

Take: TypeAlias = Callable[[int, int, Floats], None]
"""Takes a level's number, that of its first row, and rows (..., k, W, C)."""


class RowChain:
    """Hands each level's rows on, in their order, as soon as there are any.

    `halvings` are one for each level but the last. A level holds back no more rows than its halving needs.
    """

    def __init__(self, halvings: Sequence[Halving], take: Take) -> None:
        self._halvings, self._take = halvings, take
        self._first = [0] * (len(halvings) + 1)  # the next row of each level
        self._held: list[Floats | None] = [None] * len(halvings)

    def push(self, rows: Floats, level: int = 0) -> None:
        """Add rows (..., k, W, C), float32, to those of the largest level."""
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
