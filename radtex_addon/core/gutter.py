# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gutter: texels that no island touches get the value of the nearest covered texel.

Without this dilation, bilinear lookups across an island's edge would see black.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .arrays import Bools, Floats, Ints
from .errors import InputError, ShapeError

LEAST_AGREEMENT = 0.85  # if `gutter_agreement` is lower, the bake was made on another UV layer

_LOOKED_AT = 4096  # about how many gutter texels `gutter_agreement` compares
_ALIKE = 10_000  # covered texels of one value that a gutter texel is compared with

Nearest: TypeAlias = tuple[Ints, Ints]


def nearest_covered(covered: Bools) -> Nearest:
    """The nearest covered texel of every texel: rows j and columns i, (H, W) int32 both.

    `covered` is (H, W). Distances are Euclidean, in texels, and exact; between equally near texels the lowest
    column wins, then the lowest row. A covered texel is its own nearest.
    Raises InputError if no texel is covered, ShapeError for another number of axes.

    Meijster, Roerdink and Hesselink, "A General Algorithm for Computing Distance Transforms in Linear Time"
    (2000): along columns first, then along rows; here all rows at once, one numpy call for each column.
    """
    if covered.ndim != 2:
        raise ShapeError(f"covered: expected shape (H, W), got {covered.shape}")
    if not covered.any():
        raise InputError("the UV layer covers no texel: give the bake more texels, or unwrap the mesh again")
    nearest_row = _nearest_in_column(covered)
    height, width = covered.shape
    gap = np.abs(nearest_row - np.arange(height, dtype=np.int32)[:, None])
    gap[:, ~covered.any(axis=0)] = height + width  # farther than any texel of another column
    i = _nearest_column(np.ascontiguousarray(gap.T))
    return np.take_along_axis(nearest_row, i, axis=1), i


def dilate(values: npt.NDArray[Any], nearest: Nearest) -> npt.NDArray[Any]:
    """Fill the gutter of `values` (H, W, ...) in place with copies of the nearest covered texels.

    `nearest` comes from `nearest_covered`. Returns `values`. Raises ShapeError if the sizes differ.
    """
    j, i = nearest
    if values.shape[:2] != j.shape:
        raise ShapeError(f"values: expected shape {(*j.shape, '...')}, got {values.shape}")
    columns = np.arange(j.shape[1])
    for row in range(j.shape[0]):  # row by row, since an atlas may be as large as memory
        gutter = np.flatnonzero((j[row] != row) | (i[row] != columns))
        values[row, gutter] = values[j[row, gutter], i[row, gutter]]
    return values


def covered_in_coarser(covered: Bools, shape: tuple[int, ...], step: float) -> Bools:
    """Which texels of a map of `shape` (h, w), each of `step` x `step`, hold one that is `covered` (H, W).

    A row or column that is left over belongs to the last one.
    """
    rows, columns = ((place // step).astype(np.int64) for place in np.nonzero(covered))
    found = np.zeros(shape, dtype=bool)
    found[np.minimum(rows, shape[0] - 1), np.minimum(columns, shape[1] - 1)] = True
    return found


def means_in(values: Floats, height: int, width: int) -> Floats:
    """The means of a map (H, W, C) in the texels of one of as many or fewer rows and columns: (h, w, C)."""
    for axis, count in ((0, height), (1, width)):
        size = values.shape[axis]
        starts = -(-np.arange(count) * size // count)
        each = np.diff([*starts, size]).astype(np.float32)
        shape = [1, 1, 1]
        shape[axis] = count
        values = np.add.reduceat(values, starts, axis, dtype=np.float32) / each.reshape(shape)
    return values


def gutter_agreement(covered: Bools, texels: Floats, loss: float = 0.0) -> float:
    """How well a UV layer that covers the texels `covered` (H, W) agrees with a bake's `texels` (H, W, K).

    The texels of G cells, each of which has its own gutter, are (H, W, G, K): their mean is returned.

    Returns the share, 0 to 1, of gutter values that are copies of the nearest covered texel's. Values count
    as copies if they differ by at most `loss` times the larger. Covered texels that nobody sees, which are
    cut out or buried in another part, may be copies themselves, so that the gutter beside them has a farther
    texel's value: that counts, too.
    Raises ShapeError if the sizes differ.
    """
    if texels.shape[:2] != covered.shape:
        raise ShapeError(f"texels: expected shape {(*covered.shape, '...')}, got {texels.shape}")
    if texels.ndim == 4:
        return float(np.mean([gutter_agreement(covered, cell, loss) for cell in np.moveaxis(texels, 2, 0)]))
    if not covered.any():
        return 0.0
    gutter = np.flatnonzero(~covered)
    gutter = gutter[:: len(gutter) // _LOOKED_AT + 1]
    if not len(gutter):
        return 1.0
    nearest = np.ravel_multi_index(nearest_covered(covered), covered.shape).ravel()[gutter]
    flat = texels.reshape(covered.size, -1)
    ours, theirs = (flat[place].astype(np.float32) for place in (gutter, nearest))
    allowed = loss * np.maximum(np.abs(ours), np.abs(theirs))
    agree = (np.abs(ours - theirs) <= allowed).mean(axis=1)
    doubtful = np.flatnonzero(agree < 1)
    agree[doubtful[_copies_farther_ones(covered, flat, gutter[doubtful])]] = 1
    return float(agree.mean())


def _copies_farther_ones(covered: Bools, flat: Floats, gutter: Ints) -> Bools:
    """Which flat `gutter` texels (G,) copy a covered texel, with none between that is no copy itself.

    `flat` (H*W, K) are the values. A covered texel whose value others have, too, may be a copy of them.
    """
    width = covered.shape[1]
    inside = np.flatnonzero(covered)
    keys, which, times = np.unique(_value_keys(flat[inside]), return_inverse=True, return_counts=True)
    own = np.zeros_like(covered)
    own.ravel()[inside[times[which] == 1]] = True
    if not own.any():
        return np.zeros(len(gutter), dtype=bool)
    order = inside[np.argsort(which, kind="stable")]
    ends = times.cumsum()
    nearest = np.ravel_multi_index(nearest_covered(own), own.shape).ravel()[gutter]
    limit = _squared_distance(gutter, nearest, width)
    wanted = _value_keys(flat[gutter])
    number = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    found: Bools = keys[number] == wanted
    for place in np.flatnonzero(found):
        alike = order[ends[number[place]] - times[number[place]] : ends[number[place]]][:_ALIKE]
        found[place] = _squared_distance(gutter[place], alike, width).min() <= limit[place]
    return found


def _squared_distance(first: Ints, second: Ints, width: int) -> Ints:
    """Between the middles of flat texels, element by element."""
    rows, columns = (a - b for a, b in zip(np.divmod(first, width), np.divmod(second, width), strict=True))
    squared: Ints = rows * rows + columns * columns
    return squared


def _value_keys(values: Floats) -> npt.NDArray[np.uint64]:
    """A number (N,) for each row of values (N, K): equal rows have equal numbers, others hardly ever."""
    bits = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32).astype(np.uint64)
    odd = np.random.default_rng(0).integers(2**63, size=values.shape[1], dtype=np.uint64) * np.uint64(2) + 1
    keys: npt.NDArray[np.uint64] = (bits * odd).sum(axis=1, dtype=np.uint64)
    return keys


def _nearest_in_column(covered: Bools) -> Ints:
    """Row of the nearest covered texel in the same column, the lower of two; any row in an empty column."""
    height = len(covered)
    rows = np.arange(height, dtype=np.int32)[:, None]
    far = np.int32(2 * height)
    below = np.maximum.accumulate(np.where(covered, rows, -far), axis=0)
    above = np.minimum.accumulate(np.where(covered, rows, far)[::-1], axis=0)[::-1]
    nearest: Ints = np.where(rows - below <= above - rows, below, above)
    return np.clip(nearest, 0, height - 1)


def _nearest_column(gap: Ints) -> Ints:
    """For every texel the column i' with the least (i - i')^2 + gap^2; `gap` (W, H), the result (H, W).

    Builds the lower envelope of each row's parabolas: parabola q belongs to `column[q]` and is the lowest
    from `start[q]` on; `top` is the last q.
    """
    width, height = gap.shape
    square = gap.astype(np.int64) ** 2
    column, start = np.zeros((2, width, height), dtype=np.int32)
    top = np.zeros(height, dtype=np.int64)
    rows = np.arange(height)
    for i in range(1, width):
        left = rows
        while len(left):  # drop the parabolas that the new one undercuts where they begin
            q = top[left]
            x, other = start[q, left].astype(np.int64), column[q, left].astype(np.int64)
            undercut = (x - other) ** 2 + square[other, left] > (x - i) ** 2 + square[i, left]
            left = left[undercut]
            top[left] -= 1
            left = left[top[left] >= 0]
        emptied = np.flatnonzero(top < 0)
        top[emptied], column[0, emptied], start[0, emptied] = 0, i, 0
        last = column[top, rows].astype(np.int64)
        # the new parabola is lower from here on; where it replaced the whole envelope, `last` is the new one
        begin = 1 + (i * i - last * last + square[i] - square[last, rows]) // np.maximum(2 * (i - last), 1)
        added = np.flatnonzero((last != i) & (begin < width))
        top[added] += 1
        column[top[added], added], start[top[added], added] = i, begin[added]
    nearest = np.empty((height, width), dtype=np.int32)
    for i in range(width - 1, -1, -1):
        nearest[:, i] = column[top, rows]
        top -= start[top, rows] == i
    return nearest
