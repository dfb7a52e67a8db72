# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest: what the model does not explain of the light, in few cells, where it stands out from noise."""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.pooling import SHARE, WIDER, Neighbours, Taps, upsampled
from ....core.arrays import Bools, Floats
from ....core.colour_spaces import LUMINANCE

_STEPS = (1, 2, 4, 8, 14)  # cells along a bucket's side; the last ones are pooled less widely, too
_DOUBT = 1.0  # times a step's noise: what is no larger is none
_COLOURED = 0.25  # of a step's mean square: what it counts for though its luminance is 0
_PRIOR = 0.02  # of a cell's samples
BRIGHTEST = 12.0  # times the mean luminance: a sample that is brighter than its model by more is limited
_DOUBLE = 3.0  # times its model: more of it than that is limited, too
_EYE = 1.1  # power of the brightness that an error is relative to


def fit_rest(
    place: Floats, light: Floats, used: Bools, shown: Floats, neighbours: Neighbours, cells: int
) -> Floats:
    """What to add to `shown` (3, K, S) for `light` (K, S, 3), by texel and direction: (3, K, cells * cells).

    `place` (2, K, S): the samples' places on the octahedron's square; `used` (K, S): which count. Each step,
    from coarse cells to fine ones, is shrunk by its noise (James and Stein, 1961).
    """
    table = np.zeros((3, len(used), cells * cells), dtype=np.float32)
    if not used.any():
        return table
    level = mean_brightness(light, used)
    stages = [(side, True) for side in _STEPS if side <= cells]
    for side, wide in (*stages, (stages[-1][0], False)):
        sums = np.empty((5, len(used), side * side), dtype=np.float32)

        def sum_up(some: slice, side: int = side, sums: Floats = sums, table: Floats = table) -> None:
            now = shown[:, some] + Taps.of(place[:, some], cells).gather(table[:, some])
            weight = used[some] * brightness_weight(now, level)
            most = _DOUBLE * np.maximum(now, 0) + BRIGHTEST * level
            off = weight * (np.minimum(np.maximum(planes(light[some]), 0), most) - now)
            columns = [weight, *off, np.tensordot(LUMINANCE, off, axes=1) ** 2]
            sums[:, some] = Taps.of(place[:, some], side).scatter(columns)

        in_blocks(sum_up, *used.shape)
        prior = np.float32(_PRIOR * float(sums[0].mean()) + 1e-9)
        sums = neighbours.pool(sums, wide)
        weight = sums[0] + prior
        step = sums[1:4] / weight
        if side > 1:
            noise = SHARE * (WIDER if wide else 1.0) * sums[4] / weight**2
            size = np.tensordot(LUMINANCE, step, axes=1) ** 2 + _COLOURED * (step**2).mean(axis=0)
            step *= np.maximum(0, 1 - _DOUBT * noise / np.maximum(size, 1e-12))
        table = (table + upsampled(step.astype(np.float32), cells)).astype(np.float32)
    return table


def mean_brightness(light: Floats, used: Bools) -> np.float32:
    """The mean luminance of light samples (K, S, 3) that are `used` (K, S), above 0."""
    bright = np.tensordot(LUMINANCE, np.maximum(planes(light), 0), axes=1)[used].mean(dtype=np.float64)
    return np.float32(max(float(bright), 1e-6))


def brightness_weight(shown: Floats, level: np.float32) -> Floats:
    """What errors count for where so much light (3, ...) is shown, if its mean brightness is `level`."""
    bright = np.maximum(np.tensordot(LUMINANCE, shown, axes=1), 0)
    weight: Floats = (1 + bright * (3 / level)) ** np.float32(-_EYE)
    return weight
