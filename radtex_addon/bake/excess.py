# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give back the light that a fit cut off its brightest samples.

Few paths meet a small lamp or a bright window, and each is far brighter than the mean. A fit limits such
samples, or they would show as dots; but viewers see the sum of their light. It is given back to the
directions that it came from, spread over as many texels as it takes for enough paths to agree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..core.arrays import Floats
from .blocks import in_blocks
from .pooling import SHARE, WIDER, Neighbours, Taps, upsampled

_NEAR = 8  # first stage: cells along a bucket's side, pooled over neighbouring texels
_OF_ALL = (8, 4, 1)  # later stages: cells along a bucket's side, the same for all texels
_FEWEST = 16  # a path may have at most 1 / _FEWEST of a lobe's excess: the rest of its light is lost
_DOUBT = 16.0  # number of equally bright paths at which a cell keeps half of their light
_TINY = 1e-12

_Pool = Callable[[Floats, Callable[[Floats], Floats]], Floats]


@dataclass(frozen=True, eq=False)
class Excess:
    """The light cut off S samples of each of K texels.

    `light` (3, K, S) is at least 0; `give_back` overwrites it. `place` (2, K, S): the samples' places on the
    octahedron's square; `met` (3, K, S): the surroundings that they show; `facing` (K, S): N.I, or 0 for
    samples that do not count.
    """

    place: Floats
    met: Floats
    facing: Floats
    light: Floats


def give_back(
    excess: Excess, shown: float, gain: Floats, most: Floats, rest: Floats, neighbours: Neighbours
) -> tuple[Floats, Floats, float]:
    """Add the excess to gain and rest; returns both, (3, K, n*n), and the sum of light that is still lost.

    The gain takes what the surroundings explain, up to `most` (3, K, n*n), twice the paths' weights; the rest
    takes what is left. The amount is chosen so that the object emits as much light as its samples show,
    summed as radiance times N.I. The only light that is lost is that of single paths that no others confirm,
    and light beyond `shown`, the sum of all other light.
    """
    total = float(excess.light.sum(dtype=np.float64))
    if total == 0:
        return gain, rest, 0.0
    giving = _Giving(excess, gain, most, rest)
    kept = giving.limit(shown)
    giving.give(_NEAR, partial(_near, neighbours))
    for cells in _OF_ALL:
        giving.give(cells, _of_all)
    return giving.gain, giving.rest, max(total - kept, 0.0)


def highest_confirmed(bright: Floats) -> float:
    """The highest limit for values (P,) so that none exceeds 1 / _FEWEST of their limited sum.

    0 if there are fewer than `_FEWEST` values.
    """
    ranked = np.sort(bright)[::-1].astype(np.float64)
    if len(ranked) < _FEWEST:
        return 0.0
    if ranked[0] * _FEWEST <= ranked.sum():
        return float(ranked[0])
    cut = np.arange(1, _FEWEST)  # how many values are limited to one height
    height = (ranked.sum() - np.cumsum(ranked[: _FEWEST - 1])) / (_FEWEST - cut)
    fits = height >= ranked[cut]
    highest = np.minimum(height, ranked[cut - 1])[fits]
    return float(highest.max(initial=ranked[_FEWEST - 1]))


class _Giving:
    """Gain and rest so far.

    `bright` (K, S): each sample's light, summed over channels; `missing` (3, K, S): light still to be given.
    """

    def __init__(self, excess: Excess, gain: Floats, most: Floats, rest: Floats) -> None:
        self.excess, self.missing = excess, excess.light
        self.gain, self.most, self.rest = gain, np.maximum(most, gain), rest
        self.let_through = most / 2
        self.n = round(gain.shape[2] ** 0.5)
        self.bright = np.empty(excess.facing.shape, dtype=np.float32)

    def limit(self, most: float) -> float:
        """Limit each sample to what others confirm, and their sum to `most`; returns the sum that is left."""

        def look(some: slice) -> Floats:
            self.bright[some] = self.missing[:, some].sum(axis=0)
            found: Floats = self.bright[some][self.bright[some] > 0]
            return found

        bright = np.concatenate(in_blocks(look, *self.bright.shape))
        limit = np.float32(highest_confirmed(bright))
        share = np.float32(
            min(1.0, most / max(float(np.minimum(bright, limit).sum(dtype=np.float64)), _TINY))
        )

        def scale(some: slice) -> None:
            left = share * np.minimum(self.bright[some], limit)
            self.missing[:, some] *= left / np.maximum(self.bright[some], np.float32(_TINY))
            self.bright[some] = left

        in_blocks(scale, *self.bright.shape)
        return float(self.bright.sum(dtype=np.float64))

    def give(self, cells: int, pool: _Pool) -> None:
        """Give light that enough paths agree on, in buckets of cells x cells: to the gain, then the rest."""
        shares = [
            self._solved(partial(self._of_gain, channel), 4, cells, pool, _gain_step) for channel in range(3)
        ]
        gain = np.minimum(self.gain + upsampled(np.concatenate(shares), self.n) * self.let_through, self.most)
        more, self.gain = gain - self.gain, gain
        self._take(lambda some, taps: taps.gather(more[:, some]) * self.excess.met[:, some])
        step = upsampled(self._solved(self._of_rest, 6, cells, pool, _rest_step), self.n)
        self.rest = self.rest + step
        self._take(lambda some, taps: taps.gather(step[:, some]))

    def _take(self, given: Callable[[slice, Taps], Floats]) -> None:
        """Subtract the light that was given from `missing`."""

        def take(some: slice) -> None:
            taps = Taps.of(self.excess.place[:, some], self.n)
            self.missing[:, some] -= given(some, taps) * (self.excess.facing[some] > 0)

        in_blocks(take, *self.bright.shape)

    def _solved(
        self,
        columns: Callable[[slice], Iterator[Floats]],
        count: int,
        cells: int,
        pool: _Pool,
        solve: Callable[[Floats], Floats],
    ) -> Floats:
        """Sum `count` columns of the samples in buckets of cells x cells, then pool and solve the sums."""
        table = np.empty((count, len(self.bright), cells * cells), dtype=np.float32)

        def sum_up(some: slice) -> None:
            table[:, some] = Taps.of(self.excess.place[:, some], cells).scatter(columns(some))

        in_blocks(sum_up, *self.bright.shape)
        return pool(table, solve)

    def _of_both(self, some: slice) -> Iterator[Floats]:
        yield self.bright[some]
        yield self.bright[some] ** 2

    def _of_gain(self, channel: int, some: slice) -> Iterator[Floats]:
        one = slice(channel, channel + 1)
        (let,) = Taps.of(self.excess.place[:, some], self.n).gather(self.let_through[one, some])
        yield from self._of_both(some)
        yield self.excess.facing[some] * self.missing[channel, some]
        yield self.excess.facing[some] * let * self.excess.met[channel, some]

    def _of_rest(self, some: slice) -> Iterator[Floats]:
        yield from self._of_both(some)
        yield self.excess.facing[some]
        yield from self.excess.facing[some] * self.missing[:, some]


def _near(neighbours: Neighbours, table: Floats, solve: Callable[[Floats], Floats]) -> Floats:
    def in_paths(sums: Floats) -> Floats:
        sums[1] *= SHARE * WIDER  # pooling reduces the variance by this factor
        return solve(sums)

    return neighbours.pool(table, True, in_paths)


def _of_all(table: Floats, solve: Callable[[Floats], Floats]) -> Floats:
    """Solve the sums over all texels; the same result for each texel."""
    sums = table.sum(axis=1, keepdims=True, dtype=np.float64)
    if sums.shape[2] == 1:  # the last stage: give all that is left
        sums[:2] = [[[1.0]], [[0.0]]]
    found = solve(sums).astype(np.float32)
    return np.broadcast_to(found, (len(found), *table.shape[1:]))


def _agreed(sums: Floats) -> Floats:
    """The share of their light that paths keep in their cell, 0 to 1: from the effective number of paths.

    The effective number is that of equally bright paths which would vary as much.
    """
    bright, squared = sums[:2]
    number = bright * bright / np.maximum(squared, _TINY)
    agreed: Floats = number / (number + _DOUBT)
    return agreed


def _gain_step(sums: Floats) -> Floats:
    """What to add to a channel's gain, as a share of the paths' weights, (1, K, m)."""
    missing, shown = sums[2:]
    found: Floats = (_agreed(sums) * np.clip(missing / np.maximum(shown, _TINY), 0, 1))[None]
    return found


def _rest_step(sums: Floats) -> Floats:
    """What to add to the rest, (3, K, m)."""
    found: Floats = _agreed(sums) * sums[3:] / np.maximum(sums[2], _TINY)
    return found
