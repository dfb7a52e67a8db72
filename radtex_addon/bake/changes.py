# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find texels whose light has changed, by comparing a few new paths with the existing atlas.

One path per cell is mostly noise, so a texel is judged together with its neighbours in the atlas: by the mean
of all their differences, in units of its standard error, which is estimated from the same differences.
"""

from __future__ import annotations

import numpy as np

from ..core.arrays import Bools, Floats
from .plan import CapturePlan

_RADIUS = 3  # texels on each side that are judged together
_SURE = 3.5  # standard errors of a mean: smaller differences may be noise
_VALUES = 4  # that are judged: the channels, for a colour may change alone, and their sum
_VISIBLE = 0.02  # fraction of the atlas's light: smaller differences are invisible


def changed_texels(plan: CapturePlan, probe: Floats, before: Floats) -> Bools:
    """Which of the plan's texels show different light than before: (K,), in the order of `plan.texel`.

    `probe` (K, m, m, C) are cells of one path each, `before` (K, m, m, C) the means of the same cells in the
    atlas; only the first three channels count.
    """
    difference = _with_sum((probe[..., :3] - before[..., :3]).astype(np.float64))
    count, cells = len(difference), difference[0, ..., 0].size
    sums = np.concatenate(
        [
            difference.sum(axis=(1, 2)),
            (difference**2).sum(axis=(1, 2)),
            before[..., :3].sum(axis=(1, 2, 3), dtype=np.float64)[:, None],
            np.full((count, 1), float(cells)),
        ],
        axis=1,
    )
    total, squares, light, number = np.split(
        _around(plan.placed(sums)), [_VALUES, 2 * _VALUES, 2 * _VALUES + 1], axis=-1
    )
    mean = np.divide(total, number, out=np.zeros_like(total), where=number > 0)
    spread = np.divide(squares, number, out=np.zeros_like(total), where=number > 0) - mean**2
    error = np.sqrt(np.maximum(spread, 0) / np.maximum(number, 1))
    seen = np.abs(total) > _VISIBLE * np.abs(light)
    found: Bools = (seen & (np.abs(mean) > _SURE * error)).any(axis=-1).ravel()[plan.texel]
    return found


def _with_sum(colour: Floats) -> Floats:
    """The channels (..., 3) and their sum behind them, (..., 4): noise of single channels is larger."""
    return np.concatenate([colour, colour.sum(axis=-1, keepdims=True)], axis=-1)


def _around(image: Floats) -> Floats:
    """For each texel of (H, W, C) the sum over the square of 2 * _RADIUS + 1 texels around it."""
    padded = np.pad(image, ((_RADIUS + 1, _RADIUS), (_RADIUS + 1, _RADIUS), (0, 0)))
    sums = padded.cumsum(axis=0).cumsum(axis=1)
    side = 2 * _RADIUS + 1
    found: Floats = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
    return found
