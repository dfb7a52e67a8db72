# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance without grain: each texel's own estimate, kept as far as it stands out from its noise."""

from __future__ import annotations

from typing import cast

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import LightSamples
from ....bake.pooling import SHARE, Neighbours
from ....core.arrays import Floats, Ints
from ..lookup.falloffs import falloff_at

_DOUBT = 1.5  # times the noise: a difference no larger than that is none
_DARK = 1e-3  # a colour's channel, below which it tells nothing of the light


def fit_irradiance(
    light: LightSamples,
    facing: Floats,
    falloff: Floats,
    material: Ints,
    colour: Floats,
    neighbours: Neighbours,
    share: float = 1.0,
) -> Floats:
    """The diffuse light over its `colour` (K, 3), along the normal: (K, 3) float32.

    `facing` (K, S): N.V of the samples that count, of others 0; `falloff` (M, B, 3) is by `material`
    (K,). From a wide mean to the texel's own, each step is shrunk by its noise (James and Stein, 1961), of
    whose variance only a `share` is left where the samples are that share of all.
    """

    def estimate(some: slice) -> Floats:
        used = facing[some] > 0
        shown = planes(light.diffuse[some]) * used
        kind = np.repeat(material[some], facing.shape[1])
        curve = planes(falloff_at(falloff, kind, facing[some].ravel()).reshape(*used.shape, 3)) * used
        against = np.maximum((curve * curve).sum(axis=2), 1e-6)
        frontal = (shown * curve).sum(axis=2) / against
        off = ((shown - frontal[..., None] * curve) ** 2).sum(axis=2) / against
        return np.stack([frontal, off / np.maximum(used.sum(axis=1) - 1, 1)])

    frontal, noise = np.concatenate(in_blocks(estimate, *facing.shape), axis=2)
    divisor = np.maximum(colour.T, _DARK)
    lit = (colour.T > _DARK)[..., None]
    own = np.where(lit, (frontal / divisor)[..., None], 0).astype(np.float32)
    variance = np.where(lit, (noise / divisor**2)[..., None], 0).astype(np.float32)
    counted = lit.astype(np.float32)

    def pooled(values: Floats, wide: bool) -> Floats:
        sums = neighbours.pool(np.concatenate([values * counted, counted]), wide)
        return cast(Floats, sums[:3] / np.maximum(sums[3:], 1e-6))

    near, wide = pooled(own, False), pooled(own, True)
    noise_near, noise_wide = pooled(variance, False), pooled(variance, True)
    step = near - wide
    step *= _kept(pooled(step**2, True), SHARE * noise_wide, share)
    last = own - near
    last *= _kept(pooled(last**2, False), (1 - SHARE) * noise_near, share)
    smooth: Floats = np.where(lit, wide + step + last, 0)[..., 0].T.astype(np.float32)
    return smooth


def _kept(squared: Floats, noise: Floats, share: float) -> Floats:
    """What is kept of a step whose mean square is `squared`, with the samples' own `noise` in it."""
    expected = np.maximum(squared - (1 - share) * noise, 1e-12)  # with all samples
    kept: Floats = np.maximum(0, 1 - _DOUBT * share * noise / expected)
    return kept
