# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Levels of a bake for objects far away, as a whole: the exports make them a band of rows at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from radtex_addon.core.arrangements import halved, pad, padded_layout
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.core.sampler import Filter, blend_buckets, checked_lookups


def level_chain(image: Floats, layout: AtlasLayout, levels: int) -> list[Floats]:
    """The stored mip chain of an atlas (H*n, W*n, C): the padded image, then each level half the one before.

    Level L has (W_stored >> L) * n x (H_stored >> L) * n pixels; its texel is the plain mean of 2^L x 2^L
    stored texels, cell by cell (premultiplied colours; padding counts like any texel). float64 stays, all
    other types become float32. Raises ShapeError for an image or a number of levels that does not fit.
    """
    stored = padded_layout(layout, levels)
    exact = image if image.dtype == np.float64 else image.astype(np.float32)
    chain = [pad(exact, layout, stored)]
    for level in range(1, levels):
        above = AtlasLayout(stored.width >> (level - 1), stored.height >> (level - 1), layout.bucket)
        chain.append(halved(chain[-1], above))
    return chain


def sample_level(
    chain: Sequence[Floats], layout: AtlasLayout, uv: Floats, incidence: Floats, level: Floats
) -> Floats:
    """Quadrilinear lookups at a fractional level: linear between the levels below and above.

    `chain` is from `level_chain`, `layout` is the atlas's before padding, `uv` and `incidence` are as in
    `sampler.sample`, `level` is (K,), clamped to [0, levels - 1]. At level L the position in texels is
    uv (W, H) / 2^L, clamped to the first ceil((W, H) / 2^L) texels; W and H are the layout's. Returns (K, C),
    float32 or float64 as `uv` is; NaN where `uv`, `incidence` or `level` is NaN. Raises ShapeError for shapes
    that do not fit.
    """
    uv, incidence = checked_lookups(uv, incidence)
    level = np.broadcast_to(np.asarray(level, dtype=uv.dtype), len(uv))
    stored = padded_layout(layout, len(chain))
    result = np.full((len(uv), chain[0].shape[2]), np.nan, dtype=uv.dtype)
    known = np.isfinite(uv).all(axis=1) & np.isfinite(incidence).all(axis=1) & ~np.isnan(level)
    result[known] = 0
    level = np.clip(level, 0, len(chain) - 1)
    texels = np.array([layout.width, layout.height], dtype=uv.dtype)
    for number, image in enumerate(chain):
        weight = np.maximum(1 - np.abs(level - number), 0)
        here = known & (weight > 0)
        half = AtlasLayout(stored.width >> number, stored.height >> number, layout.bucket)
        place, b = uv[here] * texels / (1 << number), direction_to_square(incidence[here])
        last = np.ceil(texels / (1 << number))
        value = blend_buckets(half.to_buckets(image), place, b, last, Filter.QUADRILINEAR)
        result[here] += weight[here, None] * value
    return result
