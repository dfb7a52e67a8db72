# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Buckets as slices of a texture array, and how they are filtered."""

from __future__ import annotations

from collections.abc import Sequence
from math import isqrt

import numpy as np

from radtex_addon.core.arrangements import _halved
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.core.sampler import Filter, blend_buckets, checked_lookups


def from_slices(slices: Floats) -> Floats:
    """Inverse of `to_slices`, (H*n, W*n, C). Raises ShapeError if the number of layers is no square."""
    buckets = _to_buckets(slices)
    height, width, bucket = buckets.shape[:3]
    return AtlasLayout(width, height, bucket).from_buckets(buckets)


def mip_chain(slices: Floats) -> list[Floats]:
    """Slices (n*n, H, W, C) and all their mip levels, down to 1 x 1 pixel, by a box filter.

    A level has max(1, floor(size / 2)) pixels along each axis. A pixel is the mean of the level before over
    its own area: along an axis of even size of two pixels, along an axis of odd size of three, weighted by
    their overlap. So no level is shifted, and all have the same mean. float64 stays, other types become
    float32.
    """
    chain = [slices if slices.dtype == np.float64 else slices.astype(np.float32)]
    while max(chain[-1].shape[1:3]) > 1:
        chain.append(_halved(_halved(chain[-1], axis=1), axis=2))
    return chain


def sample_slices(chain: Sequence[Floats], uv: Floats, incidence: Floats, level: Floats) -> Floats:
    """The result of four trilinear GPU lookups: quadrilinear, linear between two mip levels.

    `chain` is from `mip_chain`, `uv` (K, 2) is clamped to the edge, `incidence` (K, 3) are unit vectors in
    the frame, `level` (K,) is clamped to [0, len(chain) - 1]. Filter weights are exact. The four cells around
    B, kept inside the bucket (`bleed_guard`), are blended bilinearly. Returns (K, C), float32 or float64 as
    `uv` is; NaN where `uv`, `incidence` or `level` is NaN. Raises ShapeError for shapes that do not fit.
    """
    uv, incidence = checked_lookups(uv, incidence)
    level = np.broadcast_to(np.asarray(level, dtype=uv.dtype), len(uv))
    result = np.full((len(uv), chain[0].shape[3]), np.nan, dtype=uv.dtype)
    known = np.isfinite(uv).all(axis=1) & np.isfinite(incidence).all(axis=1) & ~np.isnan(level)
    result[known] = 0
    level = np.clip(level, 0, len(chain) - 1)
    for number, slices in enumerate(chain):
        weight = np.maximum(1 - np.abs(level - number), 0)
        here = known & (weight > 0)
        texels = np.array(slices.shape[2:0:-1], dtype=uv.dtype)
        b = direction_to_square(incidence[here])
        value = blend_buckets(_to_buckets(slices), uv[here] * texels, b, texels, Filter.QUADRILINEAR)
        result[here] += weight[here, None] * value
    return result


def _bucket(slices: Floats) -> int:
    n = isqrt(len(slices))
    if slices.ndim != 4 or n < 1 or n * n != len(slices):
        raise ShapeError(f"slices: expected shape (n*n, H, W, C), got {slices.shape}")
    return n


def _to_buckets(slices: Floats) -> Floats:
    """A view (H, W, n, n, C), [j, i, q, p]."""
    n = _bucket(slices)
    return slices.reshape(n, n, *slices.shape[1:]).transpose(2, 3, 0, 1, 4)
