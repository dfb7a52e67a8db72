# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A condensed lobe as textures: a grid of its clusters' tiles, and each texel's cluster and weights.

A tile is a bucket with a border, as in the dense form. Row 0 is at the bottom.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..core.arrays import Floats, Ints
from ..core.atlas import AtlasLayout
from ..core.condensed import CondensedAtlas
from ..core.errors import ShapeError
from ..core.shared import SharedAtlas
from .condensed_sizes import texel_pixels
from .packing import WEIGHTS, lobe_layer, pack, stored_parts, with_border

Bytes = npt.NDArray[np.uint8]

_ZERO, _ONE = 128, 127  # the byte of a weight of 0, and the number of steps from there to a weight of 1


def layer_values(atlas: CondensedAtlas) -> dict[str, Floats]:
    """The values of an atlas's textures before encoding: by layer, in the files' order, float32.

    The images (rows, columns, 3), each lobe's weights (H, W, r), and the stored values of its tiles,
    (C, 1 + r, n, n, channels), without borders. Raises ShapeError if the atlas's maps do not fit each other.
    """
    texels, first = atlas.irradiance.shape[:2], atlas.lobes[0] if atlas.lobes else None
    for lobe in atlas.lobes:
        if first is None or lobe.cluster.shape != texels or lobe.ends.shape[1:] != first.ends.shape[1:]:
            found = f"{lobe.axis}: {lobe.cluster.shape} texels and tiles of shape {lobe.ends.shape}"
            raise ShapeError(f"{found} do not fit the other maps")
        if 0 in lobe.ends.shape or not lobe.rank:
            raise ShapeError(f"{lobe.axis}: tiles of shape {lobe.ends.shape} mix nothing")
    values = pack(
        SharedAtlas(
            atlas.colour, atlas.irradiance, atlas.falloff, atlas.surroundings, atlas.sharpest, lobes=()
        )
    )
    for lobe in atlas.lobes:
        parts = {WEIGHTS: lobe.weights} | stored_parts(lobe, atlas.sharpest)
        values |= {lobe_layer(lobe.axis, part): some for part, some in parts.items()}
    return {layer: some.astype(np.float32, copy=False) for layer, some in values.items()}


def pack_weights(cluster: Ints, weights: Floats) -> Bytes:
    """Pack clusters (H, W) below 65536 and weights (H, W, r) within [-1, 1] into pixels (H, W*q, 4)."""
    height, width, rank = weights.shape
    texels = np.zeros((height, width, texel_pixels(rank) * 4), dtype=np.uint8)
    texels[..., :rank] = np.rint(weights * _ONE) + _ZERO
    texels[..., -2] = cluster & 0xFF
    texels[..., -1] = cluster >> 8
    return texels.reshape(height, -1, 4)


def unpack_weights(pixels: Bytes, rank: int) -> tuple[Ints, Floats]:
    """Inverse of `pack_weights`: clusters (H, W) int32 and weights (H, W, r) float32."""
    texels = pixels.reshape(len(pixels), -1, texel_pixels(rank) * 4)
    cluster = texels[..., -2].astype(np.int32) | texels[..., -1].astype(np.int32) << 8
    weights: Floats = (texels[..., :rank].astype(np.float32) - _ZERO) / np.float32(_ONE)
    return cluster, weights


def value_range(tiles: Floats) -> Floats:
    """The least and greatest values of tiles (C, 1 + r, n, n, channels): (4, channels).

    Low and high of the first tiles, whose weight is always 1, then of the weighted ones, over all clusters.
    """
    over = (0, 1, 2, 3)
    base, others = tiles[:, :1], tiles[:, 1:]
    return np.stack([base.min(over), base.max(over), others.min(over), others.max(over)])


def pack_tiles(tiles: Floats, limits: Floats, columns: int) -> Floats:
    """Join tiles (C, 1 + r, n, n, channels) with borders to a grid (rows*(n+2), columns*(n+2), channels).

    The grid is in [0, 1], scaled by `limits` (4, channels) from `value_range`. Places without a tile are 0.
    """
    low, span = _low_and_span(limits, tiles.shape[1])
    bordered = with_border((tiles - low) / np.where(span > 0, span, 1))
    count, side, channels = tiles.shape[0] * tiles.shape[1], bordered.shape[2], tiles.shape[4]
    rows = -(-count // columns)
    grid = np.zeros((rows * columns, side, side, channels), dtype=np.float32)
    grid[:count] = np.clip(bordered, 0, 1).reshape(count, side, side, channels)
    return AtlasLayout(columns, rows, side).from_buckets(grid.reshape(rows, columns, side, side, channels))


def unpack_tiles(image: Floats, limits: Floats, clusters: int, rank: int, columns: int) -> Floats:
    """Inverse of `pack_tiles`: tiles (C, 1 + r, n, n, channels), float32, without borders.

    The grid may have more channels than `limits`: an alpha, which is ignored.
    """
    side, channels = image.shape[1] // columns, limits.shape[1]
    grid = AtlasLayout(columns, image.shape[0] // side, side).to_buckets(image)
    inner = grid[:, :, 1:-1, 1:-1, :channels].reshape(-1, side - 2, side - 2, channels)
    tiles = inner[: clusters * (1 + rank)].reshape(clusters, 1 + rank, side - 2, side - 2, channels)
    low, span = _low_and_span(limits, 1 + rank)
    values: Floats = (tiles * span + low).astype(np.float32)
    return values


def _low_and_span(limits: Floats, tiles: int) -> tuple[Floats, Floats]:
    """Offset and scale of a cluster's tiles, (1 + r, 1, 1, channels) both: values are low + span * stored."""
    kind = np.minimum(np.arange(tiles), 1)[:, None, None]
    low, high = limits[0::2][kind], limits[1::2][kind]
    return low, high - low
