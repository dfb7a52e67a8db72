# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Giving back the light that a fit cut off its brightest samples.

A small lamp or a bright window is met by few paths, each far brighter than the mean. A fit limits them, or
they would show as dots; but their sum is light that viewers see. It goes back to the directions that it came
from, over as many texels as it takes for enough paths to agree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..core.arrays import Floats
from .blocks import in_blocks
from .pooling import SHARE, WIDER, Neighbours, Taps, upsampled

_NEAR = 8  # cells of a bucket, pooled over neighbouring texels
_OF_ALL = (8, 4, 1)  # cells of a bucket, the same for all texels
_FEWEST = 16  # no path may bring more than one part in so many of a lobe's excess: what is beyond is lost
_DOUBT = 16.0  # so many paths, all alike, have half of what they bring kept by their cell
_TINY = 1e-12

_Pool = Callable[[Floats, Callable[[Floats], Floats]], Floats]


@dataclass(frozen=True, eq=False)
class Excess:
    """What was cut off S samples of each of K texels, `light` (3, K, S), at least 0; it is spent meanwhile.

    `place` (2, K, S) on the octahedron's square; `met` (3, K, S), the surroundings that they show; `facing`
    (K, S), N.I of the samples that count, of others 0.
    """

    place: Floats
    met: Floats
    facing: Floats
    light: Floats


def give_back(
    excess: Excess, shown: float, gain: Floats, most: Floats, rest: Floats, neighbours: Neighbours
) -> tuple[Floats, Floats, float]:
    """Gain and rest, (3, K, n*n) both, with the excess, and the sum of what is lost all the same.

    The gain, up to `most` (3, K, n*n), twice what paths are let through, takes what the surroundings tell of;
    the rest takes what is left. So much is given that the object sends out as much light as its samples show,
    radiance times N.I. Lost is only what single paths bring that no others confirm, and what is more than
    `shown`, the sum of all other light.
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
    """The highest limit of values (P,) above which none is more than its share of their limited sum.

    That share is one part in `_FEWEST`: 0 where there are fewer values.
    """
    ranked = np.sort(bright)[::-1].astype(np.float64)
    if len(ranked) < _FEWEST:
        return 0.0
    if ranked[0] * _FEWEST <= ranked.sum():
        return float(ranked[0])
    cut = np.arange(1, _FEWEST)  # so many are limited to one height
    height = (ranked.sum() - np.cumsum(ranked[: _FEWEST - 1])) / (_FEWEST - cut)
    fits = height >= ranked[cut]
    highest = np.minimum(height, ranked[cut - 1])[fits]
    return float(highest.max(initial=ranked[_FEWEST - 1]))


class _Giving:
    """Gain and rest so far; `bright` (K, S) is what a sample brought, `missing` what is still to be given."""

    def __init__(self, excess: Excess, gain: Floats, most: Floats, rest: Floats) -> None:
        self.excess, self.missing = excess, excess.light
        self.gain, self.most, self.rest = gain, np.maximum(most, gain), rest
        self.let_through = most / 2
        self.n = round(gain.shape[2] ** 0.5)
        self.bright = np.empty(excess.facing.shape, dtype=np.float32)

    def limit(self, most: float) -> float:
        """Limit what a sample brings to what others confirm, and all to `most`; the sum of what is left."""

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
        """Give, in buckets of cells x cells, what enough paths agree on: to the gain, then to the rest."""
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
        """Take what was given from what is missing."""

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
        """Sums of so many columns of samples in buckets of cells x cells, pooled and solved."""
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
        sums[1] *= SHARE * WIDER  # pooled, a single path counts for that much of one
        return solve(sums)

    return neighbours.pool(table, True, in_paths)


def _of_all(table: Floats, solve: Callable[[Floats], Floats]) -> Floats:
    """All texels' sums, at each texel."""
    sums = table.sum(axis=1, keepdims=True, dtype=np.float64)
    if sums.shape[2] == 1:  # nothing wider is left, so nothing is doubted
        sums[:2] = [[[1.0]], [[0.0]]]
    found = solve(sums).astype(np.float32)
    return np.broadcast_to(found, (len(found), *table.shape[1:]))


def _agreed(sums: Floats) -> Floats:
    """How much of what paths bring stays with them, 0 to 1: by how many, all alike, would vary as they do."""
    bright, squared = sums[:2]
    number = bright * bright / np.maximum(squared, _TINY)
    agreed: Floats = number / (number + _DOUBT)
    return agreed


def _gain_step(sums: Floats) -> Floats:
    """By which share of what paths are let through a channel's gain has to grow, (1, K, m)."""
    missing, shown = sums[2:]
    found: Floats = (_agreed(sums) * np.clip(missing / np.maximum(shown, _TINY), 0, 1))[None]
    return found


def _rest_step(sums: Floats) -> Floats:
    """What to add to the rest, (3, K, m)."""
    found: Floats = _agreed(sums) * sums[3:] / np.maximum(sums[2], _TINY)
    return found
