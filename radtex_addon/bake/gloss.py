# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting a lobe's light: each cell's gain, how much of the surroundings it shows, and rest, what else.

Weighted least squares, from coarse cells to fine ones; errors count as the eye sees them, relative to the
light there is. The paths' own weights say what the gain is to begin with.
"""

from __future__ import annotations

import numpy as np

from ..core.arrays import Floats, Ints
from .ends import LobePaths
from .pooling import Neighbours, Taps, upsampled
from .surroundings import Surroundings

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)  # of Rec.709

_STAGES = ((1, True), (4, True), (8, True), (8, False))  # cells of a bucket, pooled widely? the finest follow
_FINEST_ROUNDS = 2
_LEAST_TOLD = 4  # cells of a bucket: in fewer the paths' weights tell the gain better than the light does
_PRIOR = 8.0  # samples that a cell's light by coarser cells counts for
_EYE = 1.1  # power of the brightness that an error is relative to
_BRIGHTEST = 12.0  # times the mean luminance: a sample that is brighter than its fit by more is limited
_DOUBLE = 3.0  # times its fit: more of it than that is limited, too
_MOST_GAIN = 2.0  # times the paths' weights
_LEAST_GAIN = 0.05  # that a cell may be given, whatever its paths say
_WHITE_LIMIT = 8.0  # times the mean weight of those that end: a path that lets more through is limited


def fit_gain(paths: LobePaths, white: Floats, neighbours: Neighbours, n: int) -> Floats:
    """How much each cell lets through, in the mean of its paths' weights `white` (P, 3): (K*n*n, 3).

    Paths that end nowhere count, too: they let nothing through.
    """
    texels = len(neighbours.plan.texel)
    limited = np.minimum(white, _WHITE_LIMIT * float(weight_of_ending(white).mean()))
    taps = Taps.of(paths.axis, paths.owner, texels, n)
    table = neighbours.pool(taps.scatter([*limited.T, np.ones(len(limited), np.float32)]))
    whole = table.reshape(texels, n * n, 4).sum(axis=1)
    usual = np.repeat(whole[:, :3] / np.maximum(whole[:, 3:], 1e-12), n * n, axis=0)
    prior = max(1e-2 * float(table[:, 3].mean()), 1e-12)
    return ((table[:, :3] + prior * usual) / (table[:, 3:] + prior)).astype(np.float32)


def weight_of_ending(white: Floats) -> Floats:
    """The mean of the paths' weights `white` (P, 3) without those that end nowhere: (3,)."""
    some = white[white.any(axis=1)]
    return some.mean(axis=0) if len(some) else np.zeros(3, dtype=np.float32)


def fit_gloss(
    axis: Floats,
    owner: Ints,
    light: Floats,
    ends: Floats,
    gain: Floats,
    single: Floats,
    around: Surroundings,
    neighbours: Neighbours,
) -> tuple[Floats, Floats, float]:
    """Gain and rest of each cell, (K*n*n, 3) both, and the light cut off as fireflies, a sum over samples.

    `light` (P, 3) are samples along `axis` (P, 3) of the texels `owner` (P,); `ends` as of `fit_ends`, `gain`
    as of `fit_gain`, `single` (3,) as of `weight_of_ending`: glass mirrors one path in twenty, but that one
    wholly.
    """
    texels = len(neighbours.plan.texel)
    n = round((len(ends) / texels) ** 0.5)
    most, rest = np.maximum(_MOST_GAIN * gain, _LEAST_GAIN), np.zeros_like(gain)
    if not len(light):
        return gain, rest, 0.0
    stages = [(cells, wide) for cells, wide in _STAGES if cells < n] + [(n, False)] * _FINEST_ROUNDS
    taps = {cells: Taps.of(axis, owner, texels, cells) for cells in {*dict(stages), n}}
    there = taps[n].gather(ends)
    met = around.look(axis + there[:, :3], there[:, 3])
    level = max(float((light @ LUMINANCE).mean()), 1e-6)
    single_met, weight = single * met, np.ones(len(light), dtype=np.float32)
    for cells, wide in stages:
        shown = taps[n].gather(gain) * met + taps[n].gather(rest)
        weight = _weight(shown, level) if wide else weight  # by no fit that has seen the sample's own noise
        missing = np.minimum(light, _limit(shown, single_met, level)) - shown
        if cells >= _LEAST_TOLD:
            step = _gain_step(met, missing, weight, level, taps[cells], neighbours, wide)
            new = np.clip(gain + upsampled(step, texels, cells, n), 0, most)
            missing -= taps[n].gather(new - gain) * met
            gain = new
        rest += upsampled(_rest_step(missing, weight, taps[cells], neighbours, wide), texels, cells, n)
    shown = taps[n].gather(gain) * met + taps[n].gather(rest)
    cut = np.maximum(light - _limit(shown, single_met, level), 0)
    return gain, rest, float(cut.sum(dtype=np.float64))


def _limit(shown: Floats, single: Floats, level: float) -> Floats:
    """The brightest that samples may be; `shown` is their fit, `single` what one path shows, (P, 3) all."""
    most: Floats = _DOUBLE * np.maximum(np.maximum(shown, single), 0) + np.float32(_BRIGHTEST * level)
    return most


def _weight(shown: Floats, level: float) -> Floats:
    bright = np.maximum(shown @ LUMINANCE, 0)
    return (1 / (1 + 3 * bright / level) ** _EYE).astype(np.float32)


def _gain_step(
    met: Floats, missing: Floats, weight: Floats, level: float, taps: Taps, neighbours: Neighbours, wide: bool
) -> Floats:
    """What to add to the gain, (count, 3), by least squares of each cell's gain and rest together."""
    columns = [weight]
    for channel in range(3):
        there, off = met[:, channel], missing[:, channel]
        columns += [weight * there, weight * there**2, weight * off, weight * off * there]
    table = neighbours.pool(taps.scatter(columns), wide)
    prior = max(_PRIOR * float(weight.mean()), 1e-12)
    w = table[:, 0] + prior
    gain = np.empty((taps.count, 3), dtype=np.float32)
    for channel in range(3):
        s, ss, y, sy = table[:, 1 + 4 * channel : 5 + 4 * channel].T
        ss = ss + prior * level**2
        gain[:, channel] = (sy * w - y * s) / (ss * w - s * s)
    return gain


def _rest_step(missing: Floats, weight: Floats, taps: Taps, neighbours: Neighbours, wide: bool) -> Floats:
    """What to add to the rest, (count, 3), by least squares of each cell, when the gain stands."""
    table = neighbours.pool(taps.scatter([*(weight[:, None] * missing).T, weight]), wide)
    step: Floats = table[:, :3] / (table[:, 3:] + max(_PRIOR * float(weight.mean()), 1e-12))
    return step
