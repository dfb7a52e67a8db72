# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit a lobe's light: each cell's gain (how much of the surroundings it shows) and rest (all other light).

Weighted least squares, from coarse cells to fine ones; errors count relative to the brightness, as the eye
sees them. The gain starts from the paths' own weights.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..core.arrays import Bools, Floats
from ..core.hemisphere import square_to_direction
from ..core.octahedron import direction_to_octahedron
from ..core.shared import Axis
from .blocks import in_blocks, planes
from .excess import Excess, give_back
from .light_samples import mirrored, straight_through
from .plan import CapturePlan
from .pooling import Neighbours, Taps, upsampled
from .surroundings import Surroundings

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)  # of Rec.709

_STAGES = ((1, True), (4, True), (8, True), (8, False))  # cells along a side, pooled widely?; finest follow
_FINEST_ROUNDS = 2
_LEAST_TOLD = 4  # cells along a side: in coarser buckets the paths' weights give a better gain than the light
_PRIOR = 8.0  # weight, in samples, of the light that coarser cells give a cell
_PRIOR_OF_FEW = 2.0  # the same, where texels have few samples and sums are pooled widely
_PRIOR_OF_ALL = 0.02  # the same for whole buckets: nothing coarser gives their mean, and no light may be lost
_EYE = 1.1  # weights fall with this power of the brightness
_BRIGHTEST = 12.0  # a sample is limited to so many times the mean luminance …
_DOUBLE = 3.0  # … plus so many times its fit
_MOST_GAIN = 2.0  # highest gain, times the paths' weights
_LEAST_GAIN = 0.05  # the gain may always rise to this, whatever the paths' weights
_WHITE_LIMIT = 8.0  # times the mean weight of paths that end somewhere: higher weights are limited


@dataclass(frozen=True, eq=False)
class LobeSamples:
    """Samples along a lobe's axis, S for each of the plan's K texels.

    `square` (K, S, 2): bucket coordinates B of the viewers. `values` (K, S, 3): the light that they see, or
    how much of it the object lets through. `used` (K, S): which samples count.
    """

    plan: CapturePlan
    axis: Axis
    square: Floats
    values: Floats
    used: Bools

    def along(self, some: slice) -> tuple[Floats, Floats]:
        """The axes of some texels' samples, (3, k, S), and their places on the octahedron, (2, k, S)."""
        towards = mirrored if self.axis is Axis.MIRROR else straight_through
        axis = planes(towards(self.plan, self.square[some].astype(np.float32), some))
        return axis, planes(direction_to_octahedron(np.moveaxis(axis, 0, -1)))

    def seen(self, some: slice) -> Floats:
        """Some texels' values, (3, k, S); 0 for samples that do not count."""
        return np.where(self.used[some], planes(self.values[some]), np.float32(0))


def stages(n: int) -> list[tuple[int, bool]]:
    """The stages of `fit_gloss` for buckets of n x n cells: cells along a side, and whether pooled widely."""
    return [(cells, wide) for cells, wide in _STAGES if cells < n] + [(n, False)] * _FINEST_ROUNDS


def fit_gain(place: Floats, white: LobeSamples, single: Floats, neighbours: Neighbours, n: int) -> Floats:
    """The gain to start from: how much each cell lets through, the mean of its paths' weights: (3, K, n*n).

    `white` has the weights; paths that end nowhere count as 0. `place` (2, K, S) is the paths' axis on the
    octahedron's square, `single` (3,) the mean weight of the paths that end somewhere.
    """
    table = np.empty((4, len(white.used), n * n), dtype=np.float32)
    most = np.float32(_WHITE_LIMIT * float(single.mean()))

    def sum_up(some: slice) -> None:
        limited = np.minimum(white.seen(some), most)
        table[:, some] = Taps.of(place[:, some], n).scatter([*limited, white.used[some].astype(np.float32)])

    in_blocks(sum_up, *white.used.shape)
    table = neighbours.pool(table)
    whole = table.sum(axis=2, keepdims=True)
    prior = np.float32(max(1e-2 * float(table[3].mean()), 1e-12))
    gain, weight = table[:3], table[3] + prior
    gain += prior * (whole[:3] / np.maximum(whole[3], 1e-12))
    gain /= weight
    return gain


def fit_gloss(
    samples: LobeSamples,
    ends: Floats,
    gain: Floats,
    single: Floats,
    around: Surroundings,
    neighbours: Neighbours,
) -> Generator[None, None, tuple[Floats, Floats, float]]:
    """Fit gain and rest of each cell, (3, K, n*n) both; returns them and the sum of light lost as fireflies.

    `ends` is the result of `fit_ends`, `gain` of `fit_gain`. `single` (3,) is the weight of a single path,
    which may be far above the gain: glass mirrors only one path in twenty, but that path fully. Yields after
    each stage.
    """
    if not samples.used.any():
        return gain, np.zeros_like(gain), 0.0
    fit = _GlossFit(samples, gain, single, neighbours)
    fit.meet(ends, around)
    for cells, wide in stages(fit.n):
        fit.improve(cells, wide)
        yield
    return give_back(*fit.excess(), fit.gain, fit.most, fit.rest, neighbours)


class _GlossFit:
    """Gain and rest so far (3, K, n*n).

    Of the samples: `place` (2, K, S) on the octahedron's square; `met` (3, K, S), the surroundings that they
    show; `weight` (K, S); `missing` (3, K, S), their light minus the fit; `level`, their mean luminance.
    """

    def __init__(self, samples: LobeSamples, gain: Floats, single: Floats, neighbours: Neighbours) -> None:
        shape = samples.used.shape
        self.samples, self.neighbours, self.gain = samples, neighbours, gain
        self.single = single[:, None, None].astype(np.float32)
        self.n = round(gain.shape[2] ** 0.5)
        self.most, self.rest = np.maximum(_MOST_GAIN * gain, _LEAST_GAIN), np.zeros_like(gain)
        self.place = np.empty((2, *shape), dtype=np.float32)
        self.met, self.missing = (np.empty((3, *shape), dtype=np.float32) for _ in range(2))
        self.weight = samples.used.astype(np.float32)
        self.number = int(np.count_nonzero(samples.used))
        self.level = 1.0

    def meet(self, ends: Floats, around: Surroundings) -> None:
        """Look up the surroundings that samples show, using `ends` (4, K, n*n), and set `level`."""

        def look(some: slice) -> float:
            axis, self.place[:, some] = self.samples.along(some)
            there = Taps.of(self.place[:, some], self.n).gather(ends[:, some])
            met = around.look((axis + there[:3]).reshape(3, -1).T, there[3].ravel())
            self.met[:, some] = met.T.reshape(axis.shape)
            return float(_luminance(self.light(some)).sum(dtype=np.float64))

        total = sum(in_blocks(look, *self.weight.shape))
        self.level = max(total / self.number, 1e-6)

    def light(self, some: slice) -> Floats:
        """The light of some texels' samples, (3, k, S)."""
        return np.maximum(self.samples.seen(some), 0)

    def shown(self, some: slice) -> tuple[Floats, Floats]:
        """The fit of some texels' samples, and the limit of their light, (3, k, S) both."""
        taps, met = Taps.of(self.place[:, some], self.n), self.met[:, some]
        shown = taps.gather(self.gain[:, some]) * met + taps.gather(self.rest[:, some])
        most = _DOUBLE * np.maximum(np.maximum(shown, self.single * met), 0) + np.float32(
            _BRIGHTEST * self.level
        )
        return shown, most

    def improve(self, cells: int, wide: bool) -> None:
        """Improve the gain, then the rest, in buckets of cells x cells."""
        prior = self._compare(cells, wide)
        if cells >= _LEAST_TOLD:
            solve = partial(_gain_step, prior=prior, level=self.level)
            steps = [  # channel by channel, as the sums are large
                self._solved(partial(self._gain_columns, channel), 5, cells, wide, solve)
                for channel in range(3)
            ]
            self._add_to_gain(np.concatenate(steps))
            del steps
        step = self._solved(self._rest_columns, 4, cells, wide, partial(_rest_step, prior=prior))
        self.rest += upsampled(step, self.n)

    def _compare(self, cells: int, wide: bool) -> np.float32:
        """Compute `missing` and the samples' weights; returns the weight of a cell's prior."""

        def compare(some: slice) -> float:
            shown, most = self.shown(some)
            if wide:  # otherwise the fit contains the sample's own noise
                bright = np.maximum(_luminance(shown), 0)
                weight = (1 + bright * np.float32(3 / self.level)) ** np.float32(-_EYE)
                self.weight[some] = self.samples.used[some] * weight
            self.missing[:, some] = np.minimum(self.light(some), most) - shown
            return float(self.weight[some].sum(dtype=np.float64))

        total = sum(in_blocks(compare, *self.weight.shape))
        prior = _PRIOR_OF_FEW if self.neighbours.few else _PRIOR
        if cells == 1:
            prior = _PRIOR_OF_ALL
        return np.float32(max(prior * total / self.number, 1e-12))

    def _solved(
        self,
        columns: Callable[[slice], Iterable[Floats]],
        count: int,
        cells: int,
        wide: bool,
        solve: Callable[[Floats], Floats],
    ) -> Floats:
        """Sum `count` columns of the samples in buckets of cells x cells, then pool and solve the sums."""
        table = np.empty((count, len(self.weight), cells * cells), dtype=np.float32)

        def sum_up(some: slice) -> None:
            table[:, some] = Taps.of(self.place[:, some], cells).scatter(columns(some))

        in_blocks(sum_up, *self.weight.shape)
        return self.neighbours.pool(table, wide, solve)

    def _gain_columns(self, channel: int, some: slice) -> Iterator[Floats]:
        weight, met = self.weight[some], self.met[channel, some]
        there, off = weight * met, weight * self.missing[channel, some]
        yield from (weight, there, there * met, off, off * met)

    def _rest_columns(self, some: slice) -> Iterator[Floats]:
        weight = self.weight[some]
        yield weight
        yield from weight * self.missing[:, some]

    def _add_to_gain(self, step: Floats) -> None:
        """Add a step (3, K, m) to the gain, within its limits, and update `missing`."""
        more = upsampled(step, self.n)
        more += self.gain
        np.clip(more, 0, self.most, out=more)
        more -= self.gain
        self.gain = self.gain + more

        def change(some: slice) -> None:
            taps = Taps.of(self.place[:, some], self.n)
            self.missing[:, some] -= taps.gather(more[:, some]) * self.met[:, some]

        in_blocks(change, *self.weight.shape)

    def excess(self) -> tuple[Excess, float]:
        """The light above the samples' limits, and the sum of the light below them.

        Overwrites `missing` and `weight`, to save memory.
        """

        def cut(some: slice) -> float:
            light = self.light(some)
            excess = np.maximum(light - self.shown(some)[1], 0)
            self.missing[:, some] = excess
            cosine = square_to_direction(self.samples.square[some])[..., 2]
            self.weight[some] = np.where(self.samples.used[some], cosine, 0)
            return float((light - excess).sum(dtype=np.float64))

        within = sum(in_blocks(cut, *self.weight.shape))
        return Excess(self.place, self.met, self.weight, self.missing), within


def _luminance(light: Floats) -> Floats:
    """The luminance of light (3, ...): (...)."""
    luminance: Floats = np.tensordot(LUMINANCE, light, axes=1)
    return luminance


def _gain_step(sums: Floats, prior: np.float32, level: float) -> Floats:
    """What to add to a channel's gain, (1, K, m): least squares for each cell's gain and rest together."""
    w, s, ss, y, sy = sums
    w, ss = w + prior, ss + prior * np.float32(level**2)
    gain: Floats = (sy * w - y * s) / (ss * w - s * s)
    return gain[None]


def _rest_step(sums: Floats, prior: np.float32) -> Floats:
    """What to add to the rest, (3, K, m): least squares for each cell, with the gain fixed."""
    step: Floats = sums[1:] / (sums[0] + prior)
    return step
