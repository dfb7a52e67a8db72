# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The atlas as slices: one image of all texels per cell, so that a GPU's own filters and mipmaps work.

Layer q*n + p holds the cell (p, q) of every texel: W x H pixels. Images have row 0 at the bottom (v = 0).
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .row_chain import Halving

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


def image_halving(height: int) -> Halving:
    """The step of a `RowChain` from a level of `height` rows to the next level of `mip_chain`."""

    def halved(first: int, rows: Floats) -> tuple[Floats, int]:
        if height == 1:
            return _halved(rows, axis=-2), 1
        count = (rows.shape[-3] - height % 2) // 2
        used = rows[..., : 2 * count + height % 2, :, :]
        return _halved(_halved(used, -3, height, first // 2), axis=-2), 2 * count

    return halved


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
