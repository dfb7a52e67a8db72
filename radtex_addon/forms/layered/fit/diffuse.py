# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse light: how it falls off with N.V, and each texel's along the normal."""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import LightSamples
from ....core.arrays import Floats, Ints
from ....core.colour_spaces import LUMINANCE
from ....core.hemisphere import square_to_direction

FALLOFF_SIZE = 16
GRAZING = 0.1  # N.I below which a sample is not fitted: the facet's own horizon is near


def facing_of(light: LightSamples) -> Floats:
    """N.I of the samples, (K, S); 0 for those that do not count."""
    facing = np.empty(light.seen.shape, dtype=np.float32)

    def look(some: slice) -> None:
        cosine = _cosine(light.square[some])
        facing[some] = np.where(light.seen[some] & (cosine > GRAZING), cosine, 0)

    in_blocks(look, *facing.shape)
    return facing


def fit_diffuse(samples: LightSamples, facing: Floats, texels: Ints) -> tuple[Floats, Floats]:
    """Fit the falloff (B, 3) of diffuse light in some `texels` (k,), and its radiance along normals (k, 3).

    `facing` (K, S): N.I of all samples, 0 for those that do not count. Returns the falloff first.
    """
    count, each = len(texels), facing.shape[1]

    def light(some: slice) -> Floats:
        own = texels[some]
        return np.where(facing[own] > 0, planes(samples.diffuse[own]), np.float32(0))

    def average(some: slice) -> Floats:
        number = np.maximum(np.count_nonzero(facing[texels[some]], axis=1), 1)
        found: Floats = light(some).sum(axis=2, dtype=np.float64) / number
        return found

    mean = np.concatenate(in_blocks(average, count, each), axis=1)
    if not mean.any():
        return np.ones((FALLOFF_SIZE, 3), dtype=np.float32), np.zeros((count, 3), dtype=np.float32)
    level = LUMINANCE @ mean
    weight = 1 / (level + level.mean() / 4)

    def sum_up(some: slice) -> Floats:
        cosine = facing[texels[some]]
        step = np.minimum((cosine * FALLOFF_SIZE).astype(np.intp), FALLOFF_SIZE - 1).ravel()
        texel = (weight * mean)[:, some, None] * (cosine > 0)
        columns = [*texel, *(weight[some, None] * light(some))]
        return np.stack([np.bincount(step, column.ravel(), FALLOFF_SIZE) for column in columns])

    seen, shown = np.split(sum(in_blocks(sum_up, count, each), np.zeros((6, FALLOFF_SIZE))), 2)
    curve = np.divide(shown, seen, where=seen > 0, out=np.ones_like(seen))
    known = np.flatnonzero((seen >= 1e-3 * seen.max(axis=1, keepdims=True)).all(axis=0))
    for channel in curve:
        channel[:] = np.interp(np.arange(FALLOFF_SIZE), known, channel[known])
    falloff = (curve / np.maximum(curve[:, -1:], 1e-6)).T.astype(np.float32)

    def fit(some: slice) -> Floats:
        cosine = facing[texels[some]]
        part = planes(sample_falloff(falloff, cosine.ravel())).reshape(3, *cosine.shape)
        part *= cosine > 0
        against = (part * part).sum(axis=2, dtype=np.float64)
        found: Floats = (part * light(some)).sum(axis=2, dtype=np.float64) / np.maximum(against, 1e-6)
        return found

    frontal = np.concatenate(in_blocks(fit, count, each), axis=1)
    return falloff, frontal.T.astype(np.float32)


def _cosine(square: Floats) -> Floats:
    """N.I of viewers at bucket coordinates (..., 2): (...) float32."""
    return square_to_direction(square)[..., 2].astype(np.float32)


def sample_falloff(falloff: Floats, cosine: Floats) -> Floats:
    """The falloff curve (B, 3) at cosines (K,), interpolated linearly: (K, 3)."""
    place = np.clip(cosine * len(falloff) - 0.5, 0, len(falloff) - 1)
    low = np.minimum(place.astype(np.int32), len(falloff) - 2)
    part = (place - low)[:, None].astype(falloff.dtype)
    between: Floats = falloff[low] * (1 - part) + falloff[low + 1] * part
    return between
