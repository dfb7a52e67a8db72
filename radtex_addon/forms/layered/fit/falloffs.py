# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How diffuse light changes with N.V in each material: paint loses it at the rim, and cloth shines there."""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.light_samples import LightSamples
from ....core.arrays import Floats, Ints
from .diffuse import FALLOFF_SIZE, fit_diffuse

_FAINT = 0.02  # of what a material mirrors: of less diffuse light no falloff is told
_MOST = 8.0  # times the light along the normal


def fit_falloffs(light: LightSamples, facing: Floats, material: Ints) -> tuple[Floats, Floats]:
    """Each material's falloff (M, B, 3), 1 along the normal, and the diffuse light there (K, 3), float32.

    `facing` (K, S): N.V of the samples that count, of others 0; `material` (K,): of the texels.
    """
    falloffs: list[Floats] = []
    diffuse = np.zeros((len(material), 3), dtype=np.float32)
    for number in range(int(material.max()) + 1):
        own = np.flatnonzero(material == number)
        if not len(own):
            falloffs.append(np.ones((FALLOFF_SIZE, 3), dtype=np.float32))
            continue
        falloff, found = fit_diffuse(light, facing, own)
        shown = found.mean() > _FAINT * _mean(light.mirrored, own)
        falloffs.append(np.clip(falloff, 0, _MOST) if shown else np.ones_like(falloff))
        diffuse[own] = found
    return np.stack(falloffs), diffuse


def _mean(values: Floats, own: Ints) -> float:
    """The mean of the samples (K, S, 3) of some texels, `own` (k,)."""

    def add(some: slice) -> float:
        return float(values[own[some]].sum(dtype=np.float64))

    sums: list[float] = in_blocks(add, len(own), values.shape[1])
    mean: float = sum(sums) / (len(own) * values[0].size)
    return mean
