# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting a lobe's light: each cell's gain, how much of the surroundings it shows, and rest, what else.

Weighted least squares, from coarse cells to fine ones; errors count as the eye sees them, relative to the
light there is. The paths' own weights say what the gain is to begin with.
"""

from __future__ import annotations

import numpy as np

from ..core.arrays import Floats
from .ends import LobePaths
from .pooling import Neighbours, Taps, upsampled
from .surroundings import Surroundings

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)  # of Rec.709

_STAGES = ((4, True), (8, True), (8, False))  # cells of a bucket, pooled widely? the finest follow
_FINEST_ROUNDS = 2
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
    some = white[white > 0]
    limited = np.minimum(white, _WHITE_LIMIT * (float(some.mean()) if len(some) else 1.0))
    taps = Taps.of(paths.axis, paths.owner, texels, n)
    table = neighbours.pool(taps.scatter([*limited.T, np.ones(len(limited), np.float32)]))
    whole = table.reshape(texels, n * n, 4).sum(axis=1)
    usual = np.repeat(whole[:, :3] / np.maximum(whole[:, 3:], 1e-12), n * n, axis=0)
    prior = max(1e-2 * float(table[:, 3].mean()), 1e-12)
    return ((table[:, :3] + prior * usual) / (table[:, 3:] + prior)).astype(np.float32)


def fit_gloss(
    paths: LobePaths, light: Floats, ends: Floats, gain: Floats, around: Surroundings, neighbours: Neighbours
) -> tuple[Floats, Floats, float]:
    """Gain and rest of each cell, (K*n*n, 3) both, and the light cut off as fireflies, a sum over samples.

    `paths` are the samples of `light` (P, 3), their ends unused; `ends` as of `fit_ends`, `gain` as of
    `fit_gain`.
    """
    texels = len(neighbours.plan.texel)
    n = round((len(ends) / texels) ** 0.5)
    most, rest = np.maximum(_MOST_GAIN * gain, _LEAST_GAIN), np.zeros_like(gain)
    if not len(light):
        return gain, rest, 0.0
    stages = [(cells, wide) for cells, wide in _STAGES if cells < n] + [(n, False)] * _FINEST_ROUNDS
    taps = {cells: Taps.of(paths.axis, paths.owner, texels, cells) for cells in {*dict(stages), n}}
    there = taps[n].gather(ends)
    met = around.look(paths.axis + there[:, :3], there[:, 3])
    level = max(float((light @ LUMINANCE).mean()), 1e-6)
    for cells, wide in stages:
        shown = taps[n].gather(gain) * met + taps[n].gather(rest)
        kept = np.minimum(light, _limit(shown, level))
        bright = np.maximum(shown @ LUMINANCE, 0)
        weight = (1 / (1 + 3 * bright / level) ** _EYE).astype(np.float32)
        steps = _steps(met, kept - shown, weight, level, taps[cells], neighbours, wide)
        more = upsampled(np.concatenate(steps, axis=1), texels, cells, n)
        gain, rest = gain + more[:, :3], rest + more[:, 3:]
    gain = np.clip(gain, 0, most)
    shown = taps[n].gather(gain) * met + taps[n].gather(rest)
    cut = np.maximum(light - _limit(shown, level), 0)
    return gain, rest, float(cut.sum(dtype=np.float64))


def _limit(shown: Floats, level: float) -> Floats:
    most: Floats = _DOUBLE * np.maximum(shown, 0) + np.float32(_BRIGHTEST * level)
    return most


def _steps(
    met: Floats, missing: Floats, weight: Floats, level: float, taps: Taps, neighbours: Neighbours, wide: bool
) -> tuple[Floats, Floats]:
    """What to add to gain and rest, (count, 3) both, by least squares of each cell and colour."""
    columns = [weight]
    for channel in range(3):
        there, off = met[:, channel], missing[:, channel]
        columns += [weight * there, weight * there**2, weight * off, weight * off * there]
    table = neighbours.pool(taps.scatter(columns), wide)
    prior = max(_PRIOR * float(weight.mean()), 1e-12)
    w = table[:, 0] + prior
    gain, rest = (np.empty((taps.count, 3), dtype=np.float32) for _ in range(2))
    for channel in range(3):
        s, ss, y, sy = table[:, 1 + 4 * channel : 5 + 4 * channel].T
        ss = ss + prior * level**2
        determinant = ss * w - s * s
        gain[:, channel] = (sy * w - y * s) / determinant
        rest[:, channel] = (ss * y - s * sy) / determinant
    return gain, rest
