# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest: what the model does not explain of the light, in few cells, where it stands out from noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.pooling import upsampled
from ....core import large_arrays
from ....core.arrays import Bools, Floats
from ....core.colour_spaces import LUMINANCE
from .bucket_grid import Block, BucketGrid
from .rows import Places

_STEPS = (1, 2, 4, 8, 14)  # cells along a bucket's side; the last ones are pooled less widely, too
_COARSE = 2  # of these sides, up to which few of a texel's samples tell enough …
_THINNED = (5, 7, 11)  # … one in so many, if there are …
_MANY = 100  # … no fewer
_DOUBT = 0.7  # times a step's noise: where it is no larger, there is none …
_DOUBT_ALONE = 2.0  # … unless it is larger than this in one bucket
_CLEAR = 20.0  # times its noise: the most that a bucket's mean square counts among its neighbours'
_COLOURED = 0.25  # of a step's mean square: what it counts for though its luminance is 0
_PRIOR = 0.02  # of a cell's samples
BRIGHTEST = 12.0  # times the mean luminance: a sample that is brighter than its model by more is limited
BRIGHTER = 3.0  # times its model: more of it than that is limited, too
_EYE = 1.1  # power of the brightness that an error is relative to
_ADDED_AT_ONCE = 1 << 13  # buckets


def fit_rest(
    place: Places,
    light: Floats,
    used: Bools,
    shown: Floats,
    grid: BucketGrid,
    cells: int,
    level: np.float32,
    share: float = 1.0,
    brightest: float = BRIGHTEST,
) -> Floats:
    """What to add to `shown` (3, K, S) for `light` (K, S, 3), by bucket and direction: (3, B, cells * cells).

    `place`: of the samples; `used` (K, S): which count; `level`: their mean brightness; `brightest`: how many
    times that a sample may be above what is shown. Each step, from coarse cells to fine ones, is shrunk by
    its noise (James and Stein, 1961); of its variance only a `share` is left where more samples are there.
    """
    table = large_arrays.zeros((3, len(grid), cells * cells))
    if not level:
        return table
    stages = [(side, True) for side in _STEPS if side <= cells]
    for number, (side, wide) in enumerate((*stages, (stages[-1][0], False))):
        sums = large_arrays.empty((5, len(grid), side * side))
        each = _samples(used.shape[1], side, number)

        def sum_up(block: Block, side: int = side, each: slice = each, sums: Floats = sums) -> None:
            some, where = block.texels, place.some(block.texels, each)
            now = shown[:, some, each] + grid.gather(table, where, some)
            weight = used[some, each] * brightness_weight(now, level)
            most = BRIGHTER * np.maximum(now, 0) + brightest * level
            off = weight * (np.minimum(np.maximum(planes(light[some, each]), 0), most) - now)
            columns = [weight, *off, np.tensordot(LUMINANCE, off, axes=1) ** 2]
            sums[:, block.buckets] = block.scatter(where, side, columns)

        grid.in_blocks(sum_up, len(range(used.shape[1])[each]))
        pooled = partial(grid.neighbours.pool, wide=wide)
        _add_upsampled(table, grid.pool(sums, pooled, _step(sums, grid, wide, share, side > 1)))
    return table


def _samples(count: int, side: int, number: int) -> slice:
    """Which of a texel's samples a stage takes, by its number: few in coarse cells, each of which has many.

    Of samples in rows of equal length every so many: a number that does not divide the rows.
    """
    if side > _COARSE or count < _MANY:
        return slice(None)
    step = next((step for step in _THINNED if math.isqrt(count) % step), 1)
    return slice(number % step, None, step)


def _step(
    sums: Floats, grid: BucketGrid, wide: bool, share: float, shrunk: bool
) -> Callable[[Floats, Floats], Floats]:
    """How a stage's pooled `sums` (5, B, m) make its step: weight, what is off by it, and squares of that.

    `wide` as they are pooled, `share` as for `fit_rest`. The buckets around tell what is noise, since one
    bucket's values may be large by chance; but what stands out by far is kept.
    """
    prior = np.float32(_PRIOR * float(sums[0].mean()) + 1e-9)
    pooled_share = np.float32(grid.share(wide))

    def step(_: Floats, pooled: Floats) -> Floats:
        weight = pooled[0] + prior
        found: Floats = pooled[1:4] / weight
        if shrunk:
            noise = pooled_share * pooled[4] / weight**2
            size = np.tensordot(LUMINANCE, found, axes=1) ** 2 + _COLOURED * (found**2).mean(axis=0)
            size -= np.float32(1 - share) * noise
            clear = size / np.maximum(noise, np.float32(1e-12))
            bounded = np.clip(clear, 0, np.float32(_CLEAR))
            around, count = grid.neighbours.pool_further(np.stack([bounded, np.ones_like(bounded)]))
            found *= np.maximum(_kept(around / count, _DOUBT * share), _kept(clear, _DOUBT_ALONE * share))
        return found

    return step


def _kept(clear: Floats, doubt: float) -> Floats:
    """The share of values that is no noise, if squares are so many times that: James and Stein (1961)."""
    found: Floats = np.maximum(0, 1 - np.float32(doubt) / np.maximum(clear, np.float32(1e-6)))
    return found


def _add_upsampled(table: Floats, step: Floats) -> None:
    """Add a step in coarser cells to a table, in place."""
    cells = round(table.shape[2] ** 0.5)

    for first in range(0, table.shape[1], _ADDED_AT_ONCE):
        some = slice(first, first + _ADDED_AT_ONCE)
        table[:, some] += upsampled(np.ascontiguousarray(step[:, some]), cells)


def mean_brightness(light: Floats, used: Bools) -> np.float32:
    """The mean luminance of light samples (K, S, 3) that are `used` (K, S), above 0; 0 if none is."""

    def add(some: slice) -> tuple[float, int]:
        bright = np.tensordot(LUMINANCE, np.maximum(planes(light[some]), 0), axes=1)[used[some]]
        return float(bright.sum(dtype=np.float64)), len(bright)

    total, count = np.sum(in_blocks(add, *used.shape), axis=0) if len(used) else (0.0, 0)
    return np.float32(max(total / count, 1e-6) if count else 0)


def weighted_squares(light: Floats, told: Floats, judge: Floats, counted: Bools, level: np.float32) -> Floats:
    """The weighted squares of errors of N texels, (N,) float64, over samples that are `counted` (N, S).

    Of what is `told` (3, N, S) of their `light` (N, S, 3), neither above some brightness. Weights are by what
    `judge` (3, N, S) shows; `level`: the mean brightness of all.
    """
    most = np.float32(BRIGHTEST * level)
    off = np.minimum(planes(light), most) - np.minimum(told, most)
    weight = brightness_weight(judge.astype(np.float32), level) * counted
    found: Floats = (weight * np.tensordot(LUMINANCE, off * off, axes=1)).sum(axis=1, dtype=np.float64)
    return found


def brightness_weight(shown: Floats, level: np.float32) -> Floats:
    """What errors count for where so much light (3, ...) is shown, if its mean brightness is `level`."""
    bright = np.maximum(np.tensordot(LUMINANCE, shown, axes=1), 0)
    weight: Floats = (1 + bright * (3 / level)) ** np.float32(-_EYE)
    return weight
