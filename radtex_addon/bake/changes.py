# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where light has changed: few new paths held against an atlas that is there.

One path a cell is mostly noise, so texels are judged with their neighbours in the atlas: the mean of all
differences around, in units of its standard error, as the differences themselves spread.
"""

from __future__ import annotations

import numpy as np

from ..core.arrays import Bools, Floats
from .plan import CapturePlan

_RADIUS = 3  # texels around that are judged together
_SURE = 3.5  # standard errors of a mean: below that it may be noise
_VISIBLE = 0.02  # of the light that is there: below that nobody sees it


def changed_texels(plan: CapturePlan, probe: Floats, before: Floats) -> Bools:
    """Which of the plan's texels show other light than before: (K,), in the order of `plan.texel`.

    `probe` (K, m, m, C) are cells of one path each, `before` (K, m, m, C) the same cells' means in the atlas;
    the first three channels count.
    """
    difference = (probe[..., :3] - before[..., :3]).sum(axis=-1, dtype=np.float64)
    count, cells = len(difference), difference[0].size
    sums = np.stack(
        [
            np.full(count, float(cells)),
            difference.sum(axis=(1, 2)),
            (difference**2).sum(axis=(1, 2)),
            before[..., :3].sum(axis=(1, 2, 3), dtype=np.float64),
        ],
        axis=-1,
    )
    number, total, squares, light = np.moveaxis(_around(plan.placed(sums)), -1, 0)
    mean = np.divide(total, number, out=np.zeros_like(total), where=number > 0)
    spread = np.divide(squares, number, out=np.zeros_like(total), where=number > 0) - mean**2
    error = np.sqrt(np.maximum(spread, 0) / np.maximum(number, 1))
    seen = np.abs(total) > _VISIBLE * np.abs(light)
    found: Bools = (seen & (np.abs(mean) > _SURE * error)).ravel()[plan.texel]
    return found


def _around(image: Floats) -> Floats:
    """Sums over the square of texels around each, of (H, W, C)."""
    padded = np.pad(image, ((_RADIUS + 1, _RADIUS), (_RADIUS + 1, _RADIUS), (0, 0)))
    sums = padded.cumsum(axis=0).cumsum(axis=1)
    side = 2 * _RADIUS + 1
    found: Floats = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
    return found
