# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mip levels of the bucket matrix, for distant objects: level L averages blocks of texels, cell by cell.

Every level is again a matrix of n x n cells per texel. The stored atlas is padded so that each level is
exactly half as large as the one before: a valid mip chain. Images have row 0 at the bottom (v = 0).
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .row_chain import Halving

PADDING = 0.25  # share of the pixels that the padding for another level may add


def padded_layout(layout: AtlasLayout, levels: int) -> AtlasLayout:
    """The stored layout: width and height rounded up to multiples of 2^(levels - 1) texels.

    Raises ShapeError for fewer than 1 or more than 16 levels.
    """
    if not 1 <= levels <= 16:
        raise ShapeError(f"levels: expected 1 to 16, got {levels}")
    unit = 1 << (levels - 1)
    return AtlasLayout(-(-layout.width // unit) * unit, -(-layout.height // unit) * unit, layout.bucket)


def fitting_levels(layout: AtlasLayout) -> int:
    """The most levels, down to one texel on the shorter side, whose padding adds at most a quarter."""
    affordable = layout.width * layout.height * (1 + PADDING)
    count = 1
    while (1 << count) <= min(layout.width, layout.height):
        stored = padded_layout(layout, count + 1)
        if stored.width * stored.height > affordable:
            break
        count += 1
    return count


def pad(image: Floats, layout: AtlasLayout, stored: AtlasLayout) -> Floats:
    """Pad an atlas (H*n, W*n, C) from `layout` to the larger `stored` by repeating the last texels' buckets.

    Texels are added at the right (high u) and at the top (high v), each a copy of the nearest texel of the
    atlas. The dtype stays. Raises ShapeError if `stored` is smaller or has buckets of another size.
    """
    if stored.bucket != layout.bucket or stored.width < layout.width or stored.height < layout.height:
        raise ShapeError(f"pad: {layout} does not fit into {stored}")
    more = ((0, stored.height - layout.height), (0, stored.width - layout.width), (0, 0), (0, 0), (0, 0))
    return stored.from_buckets(np.pad(layout.to_buckets(image), more, mode="edge"))


def halved(image: Floats, layout: AtlasLayout) -> Floats:
    """Halve an atlas's texels along both axes: the mean of every 2 x 2 texels, cell by cell.

    Raises ShapeError if the layout's width or height is odd.
    """
    if layout.width % 2 or layout.height % 2:
        raise ShapeError(f"halved: {layout.width} x {layout.height} texels have no half; pad them")
    half = AtlasLayout(layout.width // 2, layout.height // 2, layout.bucket)
    buckets = layout.to_buckets(image)
    mean = (buckets[0::2, 0::2] + buckets[0::2, 1::2] + buckets[1::2, 0::2] + buckets[1::2, 1::2]) / 4
    return half.from_buckets(mean)


def bucket_halving(layout: AtlasLayout) -> Halving:
    """The step of a `RowChain` from a level of `layout` to the next level of `level_chain`."""

    def some(_first: int, rows: Floats) -> tuple[Floats, int]:
        texels = len(rows) // layout.bucket // 2 * 2
        used = texels * layout.bucket
        if not texels:
            return rows[:0], 0
        return halved(rows[:used], AtlasLayout(layout.width, texels, layout.bucket)), used

    return some
