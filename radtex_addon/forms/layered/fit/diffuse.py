# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse light: its falloff with N.V in each material, and each texel's irradiance, without grain.

Paint loses diffuse light at the rim, and cloth shines there. A texel's own estimate is kept as far as it
stands out from its noise.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import LightSamples
from ....bake.pooling import SHARE, Neighbours
from ....core import large_arrays
from ....core.arrays import Floats, Ints
from ....core.colour_spaces import LUMINANCE
from ....core.hemisphere import square_to_direction
from ..lookup.lobes import falloff_at

_DOUBT = 1.5  # times the noise: a difference no larger than that is none
DARK = 1e-3  # a colour's channel, below which it tells nothing of the light
_FAINT = 0.02  # of what a material mirrors: of less diffuse light no falloff is told
_MOST = 64.0  # times the light along the normal: sheen alone comes to 25
_STEEP = 1.25  # times the light along the normal: of a falloff that comes to more, sums are taken
FALLOFF_SIZE = 16
GRAZING = 0.1  # N.I below which a sample is not fitted: the facet's own horizon is near


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
        shown = found.mean() > _FAINT * mean_of(light.mirrored, own)
        falloffs.append(np.clip(falloff, 0, _MOST) if shown else np.ones_like(falloff))
        diffuse[own] = found
    return np.stack(falloffs), diffuse


def mean_of(values: Floats, own: Ints) -> float:
    """The mean of the samples (K, S, 3) of some texels, `own` (k,)."""

    def add(some: slice) -> float:
        return float(values[own[some]].sum(dtype=np.float64))

    sums: list[float] = in_blocks(add, len(own), values.shape[1])
    mean: float = sum(sums) / (len(own) * values[0].size)
    return mean


def facing_of(light: LightSamples) -> Floats:
    """N.I of the samples, (K, S); 0 for those that do not count."""
    facing = large_arrays.empty(light.seen.shape)

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


def estimate_frontal(light: LightSamples, facing: Floats, falloff: Floats, material: Ints) -> Floats:
    """The diffuse light along the normal of each texel, and that estimate's variance: (2, 3, K).

    By least squares; where light rises steeply towards the rim, as of sheen, the sum of the light over that
    of the falloff: squares would count the rim most, where each base colour has another falloff. Arguments
    as for `fit_irradiance`.
    """
    steep = falloff.max(axis=1) > _STEEP * falloff[:, -1]

    def estimate(some: slice) -> Floats:
        used = facing[some] > 0
        shown = planes(light.diffuse[some]) * used
        kind = np.repeat(material[some], facing.shape[1])
        curve = planes(falloff_at(falloff, kind, facing[some].ravel()).reshape(*used.shape, 3)) * used
        against = np.maximum((curve * curve).sum(axis=2), 1e-6)
        frontal = (shown * curve).sum(axis=2) / against
        off = ((shown - frontal[..., None] * curve) ** 2).sum(axis=2) / against
        by_sums = steep[material[some]].T
        if by_sums.any():
            total = np.maximum(curve.sum(axis=2), 1e-6)
            frontal = np.where(by_sums, shown.sum(axis=2) / total, frontal)
            squares = ((shown - frontal[..., None] * curve) ** 2).sum(axis=2)
            off = np.where(by_sums, squares * used.sum(axis=1) / total**2, off)
        return np.stack([frontal, off / np.maximum(used.sum(axis=1) - 1, 1)])

    return np.concatenate(in_blocks(estimate, *facing.shape), axis=2)


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
    frontal, noise = estimate_frontal(light, facing, falloff, material)
    divisor = np.maximum(colour.T, DARK)
    lit = (colour.T > DARK)[..., None]
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
