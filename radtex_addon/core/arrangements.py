# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bucket matrix arranged for GPUs: mip levels, slices, and pages.

Images have row 0 at the bottom (v = 0).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from .arrays import Floats
from .atlas import AtlasLayout
from .errors import InputError, ShapeError

LAYERS = 2048  # the limit of an array texture on desktop GPUs; WebGL 2 and WebGPU guarantee 256
Halving: TypeAlias = Callable[[int, Floats], tuple[Floats, int]]
"""Halves rows of a level: (first row's number, rows) -> (rows of the next level, number of rows used up)."""

Take: TypeAlias = Callable[[int, int, Floats], None]
"""Receives rows: (level, number of the first row, rows (..., k, W, C))."""
PADDING = 0.25  # share of the pixels that the padding for another level may add


class RowChain:
    """Compute mip levels from bands of rows; `take` receives each level's rows in order, as soon as possible.

    There is one of the `halvings` for each level but the last. A level buffers only the rows that its halving
    has not used up.
    """

    def __init__(self, halvings: Sequence[Halving], take: Take) -> None:
        self._halvings, self._take = halvings, take
        self._first = [0] * (len(halvings) + 1)  # the next row of each level
        self._held: list[Floats | None] = [None] * len(halvings)

    def push(self, rows: Floats, level: int = 0) -> None:
        """Append rows (..., k, W, C), float32, to the level, by default the largest one."""
        if not rows.shape[-3]:
            return
        self._take(level, self._first[level], rows)
        self._first[level] += rows.shape[-3]
        if level == len(self._halvings):
            return
        held = self._held[level]
        waiting = rows if held is None else np.concatenate([held, rows], axis=-3)
        halved, used = self._halvings[level](self._first[level] - waiting.shape[-3], waiting)
        self._held[level] = waiting[..., used:, :, :].copy()
        self.push(halved, level + 1)


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


@dataclass(frozen=True)
class Pages:
    """columns x rows pages of width x height texels each; the shader gets them as an ivec4 in this order."""

    columns: int
    rows: int
    width: int
    height: int

    @property
    def layers(self) -> int:
        return self.columns * self.rows

    def stored(self, bucket: int) -> AtlasLayout:
        """The layout of all pages together, including the padding of the last ones."""
        return AtlasLayout(self.columns * self.width, self.rows * self.height, bucket)

    def at_level(self, level: int) -> Pages:
        """The pages of a mip level: the same number, of (width >> level) x (height >> level) texels.

        Raises ShapeError if the pages' size is not a multiple of 2^level.
        """
        if self.width % (1 << level) or self.height % (1 << level):
            raise ShapeError(f"pages: {self.width} x {self.height} texels have no level {level}")
        return Pages(self.columns, self.rows, self.width >> level, self.height >> level)


def fitting_pages(layout: AtlasLayout, limit: int, levels: int = 1) -> Pages:
    """The fewest pages that each fit into a texture of limit x limit pixels; all have the same size.

    A page's width and height are multiples of 2^(levels - 1) texels. Raises InputError if not even the
    smallest such page fits, or if more layers are needed than textures have.
    """
    unit = 1 << (levels - 1)
    most = limit // layout.bucket // unit * unit
    if most < 1:
        raise InputError(
            f"limit: {limit} pixels hold no {unit} texels of {layout.bucket} cells;"
            " allow larger textures or take fewer levels"
        )
    columns, rows = -(-layout.width // most), -(-layout.height // most)
    width, height = (
        -(-texels // (count * unit)) * unit
        for texels, count in ((layout.width, columns), (layout.height, rows))
    )
    pages = Pages(columns, rows, width, height)
    if pages.layers > LAYERS:
        raise InputError(
            f"limit: {limit} pixels make {pages.layers} pages, textures have {LAYERS} layers;"
            " allow larger textures"
        )
    return pages
