# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How diffuse light changes with N.V in each material: paint loses it at the rim, and cloth shines there."""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.computed_rows import computed
from ....bake.light_samples import LightSamples
from ....core.arrays import Bools, Floats, Ints
from .diffuse import fit_diffuse

_FAINT = 0.02  # of what a material mirrors: of less diffuse light no falloff is told
_MOST = 8.0  # times the light along the normal


def fit_falloffs(light: LightSamples, facing: Floats, material: Ints) -> tuple[Floats, Floats]:
    """Each material's falloff (M, B, 3), 1 along the normal, and the diffuse light there (K, 3), float32.

    `facing` (K, S): N.V of the samples that count, of others 0; `material` (K,): of the texels.
    """
    falloffs: list[Floats] = []
    diffuse = np.zeros((len(material), 3), dtype=np.float32)
    for number in range(int(material.max()) + 1):
        own = material == number
        falloff, found = fit_diffuse(light, _of_material(facing, own))
        shown = own.any() and found[own].mean() > _FAINT * _mean(light.mirrored, own)
        falloffs.append(np.clip(falloff, 0, _MOST) if shown else np.ones_like(falloff))
        diffuse[own] = found[own]
    return np.stack(falloffs), diffuse


def _of_material(facing: Floats, own: Bools) -> Floats:
    """N.V (K, S) of the texels that are `own` (K,), 0 of others."""
    return computed(facing.shape, lambda some: facing[some] * own[some][:, None])


def _mean(values: Floats, own: Bools) -> float:
    """The mean of the samples (K, S, 3) of texels that are `own` (K,)."""

    def add(some: slice) -> float:
        return float(values[some][own[some]].sum(dtype=np.float64))

    sums: list[float] = in_blocks(add, *values.shape[:2])
    mean: float = sum(sums) / (int(own.sum()) * values[0].size)
    return mean
