# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare two atlases of the same surface in the shared layout."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ..core.hemisphere import square_to_direction
from ..core.shared import SharedAtlas, sample_shared
from .light_samples import spread_shifts
from .plan import CapturePlan

_LOOKUPS = 40_000  # enough for 0.1 dB
_AT_ONCE = 4000
_GAMMA = 2.2
_STEEP = 0.8  # largest bucket coordinate compared: at grazing angles beyond, differences hardly matter


def agreement(one: SharedAtlas, other: SharedAtlas, plan: CapturePlan) -> Generator[None, None, float]:
    """PSNR in dB between what viewers see of the two atlases; values are clipped to 0..1, gamma 2.2.

    Viewers look at all covered texels, from directions spread over each hemisphere. Yields between blocks of
    work.
    """
    count = len(plan.texel)
    chosen = np.arange(_LOOKUPS) % count if count < _LOOKUPS else np.arange(0, count, count // _LOOKUPS)
    square = ((spread_shifts(len(chosen), seed=0) * 2 - 1) * _STEEP).astype(np.float32)
    local = square_to_direction(square)
    axes = (axis.reshape(-1, 3)[:count][chosen] for axis in (plan.tangent, plan.bitangent, plan.normal))
    viewer = np.einsum("kc,ckx->kx", local, np.stack(list(axes))).astype(np.float32)
    width = plan.layout.width
    texel = plan.texel[chosen]
    within = spread_shifts(len(chosen), seed=1)  # inside the texel: the colour image is finer than texels
    uv = (np.stack([texel % width, texel // width], axis=-1) + within) / [width, plan.layout.height]
    looks = uv.astype(np.float32), plan.normals[chosen], viewer
    off = np.empty((len(chosen), 3), dtype=np.float32)
    for first in range(0, len(chosen), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        seen = [
            np.clip(sample_shared(atlas, *(look[some] for look in looks)), 0, 1) ** (1 / _GAMMA)
            for atlas in (one, other)
        ]
        off[some] = seen[0] - seen[1]
        yield
    error = float(np.mean(off**2, dtype=np.float64))
    return float(-10 * np.log10(max(error, 1e-10)))
