# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack shapes that are made of whole cells into a rectangle, with exactly so many free cells between them.

Each shape goes to the lowest free place, of equally low ones the leftmost, the largest shapes first. What is
free is found by correlating a shape with all that is taken, by Fourier transforms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .arrays import Bools, Floats, Ints


@dataclass(frozen=True)
class Spot:
    """Where a shape went: the cell of its lower left corner, and if it was turned a quarter to the left."""

    column: int
    row: int
    turned: bool


def place(masks: Sequence[Bools], width: int, height: int, gap: int) -> list[Spot] | None:
    """Places in `width` x `height` cells for shapes, masks (h, w), with `gap` free cells around each.

    None if they do not fit. The gap counts along rows, columns and diagonals; along the rectangle's edges
    there is none.
    """
    taken = np.zeros((height, width), dtype=bool)
    spots: list[Spot | None] = [None] * len(masks)
    order = sorted(range(len(masks)), key=lambda k: (-masks[k].size, -masks[k].shape[0], k))
    for number in order:
        spot = _lowest(taken, masks[number])
        if spot is None:
            return None
        _take(taken, _as_placed(masks[number], spot.turned), spot, gap)
        spots[number] = spot
    return [spot for spot in spots if spot is not None]


def _as_placed(mask: Bools, turned: bool) -> Bools:
    # rows run upwards, so that numpy's quarter turn to the right is one to the left
    return np.rot90(mask, -1) if turned else mask


def _lowest(taken: Bools, mask: Bools) -> Spot | None:
    """The lowest free place, by the shape's upper end, of the shape as it is or turned."""
    height, width = taken.shape
    spectrum = None if mask.all() else np.fft.rfft2(taken)
    found: list[tuple[int, int, int, bool]] = []
    for turned in (False, True):
        shape = _as_placed(mask, turned)
        rows, columns = shape.shape
        if rows > height or columns > width:
            continue
        if spectrum is None:
            hits: Floats = _taken_in_boxes(taken, rows, columns).astype(np.float64)
        else:
            other = np.fft.rfft2(shape, taken.shape)
            hits = np.fft.irfft2(spectrum * np.conj(other), taken.shape)[
                : height - rows + 1, : width - columns + 1
            ]
        free = np.flatnonzero(hits.ravel() < 0.5)
        if len(free):
            row, column = divmod(int(free[0]), hits.shape[1])
            found.append((row + rows, column, row, turned))
    if not found:
        return None
    _, column, row, turned = min(found)
    return Spot(column, row, turned)


def _taken_in_boxes(taken: Bools, rows: int, columns: int) -> Ints:
    """How many cells are taken in each box of so many rows and columns, by its lower left cell."""
    sums = np.zeros((taken.shape[0] + 1, taken.shape[1] + 1), dtype=np.int64)
    sums[1:, 1:] = taken.cumsum(axis=0).cumsum(axis=1)
    found: Ints = (
        sums[rows:, columns:] - sums[:-rows, columns:] - sums[rows:, :-columns] + sums[:-rows, :-columns]
    )
    return found


def _take(taken: Bools, shape: Bools, spot: Spot, gap: int) -> None:
    """Mark the shape's cells, and those within `gap` of them, as taken."""
    grown = np.pad(shape, gap)
    for axis in (0, 1):
        grown = np.any([np.roll(grown, step, axis=axis) for step in range(-gap, gap + 1)], axis=0)
    low = spot.row - gap, spot.column - gap
    inner = [slice(max(start, 0), start + size) for start, size in zip(low, grown.shape, strict=True)]
    cut = [slice(max(-start, 0), None) for start in low]
    window = taken[tuple(inner)]
    window |= grown[tuple(cut)][: window.shape[0], : window.shape[1]]
