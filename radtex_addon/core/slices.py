# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The atlas as slices: one image of all texels per cell, so that a GPU's own filters and mipmaps work.

Layer q*n + p holds the cell (p, q) of every texel: W x H pixels. Images have row 0 at the bottom (v = 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isqrt

import numpy as np

from .arrays import Floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .hemisphere import direction_to_square
from .row_chain import Halving
from .sampler import Filter, blend_buckets, checked_lookups

LAYERS = 2048  # the limit of an array texture on desktop GPUs; WebGL 2 and WebGPU guarantee 256


def to_slices(image: Floats, layout: AtlasLayout) -> Floats:
    """An atlas (H*n, W*n, C) as slices (n*n, H, W, C); the dtype stays.

    Raises ShapeError for an image that does not fit, and as `check_slices` does.
    """
    n = layout.bucket
    check_slices(n)
    cells = layout.to_buckets(image).transpose(2, 3, 0, 1, 4)
    return cells.reshape(n * n, layout.height, layout.width, image.shape[2])


def check_slices(bucket: int) -> None:
    """Raise ShapeError if a bucket has more cells than an array texture can have layers."""
    if bucket * bucket > LAYERS:
        cells = f"{bucket} x {bucket} cells need {bucket * bucket} layers"
        raise ShapeError(f"slices: {cells}, textures have {LAYERS}; export the matrix")


def from_slices(slices: Floats) -> Floats:
    """Inverse of `to_slices`, (H*n, W*n, C). Raises ShapeError if the number of layers is no square."""
    buckets = _to_buckets(slices)
    height, width, bucket = buckets.shape[:3]
    return AtlasLayout(width, height, bucket).from_buckets(buckets)


def mip_chain(slices: Floats) -> list[Floats]:
    """Slices (n*n, H, W, C) and all their mip levels, down to 1 x 1 pixel, by a box filter.

    A level has max(1, floor(size / 2)) pixels along each axis. A pixel is the mean of the level before over
    its own area: of two pixels along an axis of even size, of three, weighted by their overlap, along one of
    odd size. So no level is shifted, and all have the same mean. float64 stays, other types become float32.
    """
    chain = [slices if slices.dtype == np.float64 else slices.astype(np.float32)]
    while max(chain[-1].shape[1:3]) > 1:
        chain.append(_halved(_halved(chain[-1], axis=1), axis=2))
    return chain


def image_halving(height: int) -> Halving:
    """The step of a `RowChain` from a level of `height` rows to the next level of `mip_chain`."""

    def halved(first: int, rows: Floats) -> tuple[Floats, int]:
        if height == 1:
            return _halved(rows, axis=-2), 1
        count = (rows.shape[-3] - height % 2) // 2
        used = rows[..., : 2 * count + height % 2, :, :]
        return _halved(_halved(used, -3, height, first // 2), axis=-2), 2 * count

    return halved


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


def _halved(values: Floats, axis: int, size: int | None = None, begin: int = 0) -> Floats:
    """Box filter along one axis: floor(size / 2) means, each over an equal share of the axis.

    `values` may be a part of an axis of `size` elements, from element 2 * `begin` on; `begin` is then the
    number of its first mean.
    """
    along = np.moveaxis(values, axis, -1)
    size = size or along.shape[-1]
    half, count = size // 2, along.shape[-1] // 2
    if half == 0:
        return values
    if size % 2 == 0:
        mean = (along[..., 0::2] + along[..., 1::2]) / 2
    else:  # pixel k covers [k, k + 1] * size / half: parts of pixels 2k and 2k + 2, all of 2k + 1
        k = np.arange(begin, begin + count, dtype=values.dtype)
        mean = ((half - k) * along[..., 0:-1:2] + half * along[..., 1::2] + (k + 1) * along[..., 2::2]) / size
    return np.moveaxis(mean, -1, axis)
