# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write an atlas, which may be larger than memory, to a texture, a band of rows at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..core.arrangements import Pages, RowChain, bucket_halving, image_halving, pad, padded_layout, to_slices
from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..formats.containers.exr_rows import ImageRows
from ..formats.containers.texture_file import TextureFile


@dataclass(frozen=True)
class LightRange:
    """What limits how an image can be stored: whether alpha is 1 everywhere, and the least value of light."""

    opaque: bool
    least: float


def light_of(image: ImageRows) -> LightRange:
    """Read all of an image to find its `LightRange`. Raises FormatError for a damaged file."""
    opaque, least = True, np.float64(np.inf)
    for _, rows in image.bands():
        opaque = opaque and (image.channels < 4 or bool((rows[..., 3].astype(np.float16) == 1).all()))
        least = np.minimum(least, rows[..., :3].min())
    return LightRange(opaque, float(least))


def pour_matrix(
    image: ImageRows, layout: AtlasLayout, levels: int, pages: Pages, texture: TextureFile
) -> None:
    """Write a bucket matrix to a texture: `levels` mip levels, with their `pages` as layers.

    If the texture has more levels, these are plain means of the last one's pixels. Raises FormatError for a
    damaged file, InputError for values that are not numbers, OSError if the system refuses.
    """
    stored = padded_layout(layout, levels)
    paging = _Paging(stored, pages, levels, texture)
    layouts = [_at_level(stored, level) for level in range(levels)]
    chain = RowChain([bucket_halving(here) for here in layouts[:-1]], paging.take)
    rows: Floats = np.empty(0)
    for _, band in image.bands(layout.bucket):
        rows = _widened(_coloured(band), layout, stored.width)
        chain.push(rows)
    for _ in range(stored.height - layout.height):
        chain.push(rows[-layout.bucket :])


def pour_slices(image: ImageRows, layout: AtlasLayout, texture: TextureFile) -> None:
    """Write an atlas's slices, a layer each, and their mip levels to a texture. Raises as `pour_matrix`."""

    def take(level: int, first: int, slices: Floats) -> None:
        for layer, rows in enumerate(slices):
            texture.put(level, layer, first, rows)

    heights = [max(1, layout.height >> level) for level in range(texture.form.levels)]
    chain = RowChain([image_halving(height) for height in heights[:-1]], take)
    for _, band in image.bands(layout.bucket):
        some = AtlasLayout(layout.width, len(band) // layout.bucket, layout.bucket)
        chain.push(to_slices(_coloured(band), some))


class _Paging:
    """Cuts the levels' rows into pages; the last texels' buckets are repeated to fill the last pages."""

    def __init__(self, stored: AtlasLayout, pages: Pages, levels: int, texture: TextureFile) -> None:
        self._stored, self._pages, self._levels, self._texture = stored, pages, levels, texture
        self._further: dict[int, RowChain] = {}  # by layer: makes the levels after the last

    def take(self, level: int, first: int, rows: Floats) -> None:
        """Write rows of a level of the stored atlas."""
        here, pages = _at_level(self._stored, level), self._pages.at_level(level)
        wide = _widened(rows, here, pages.columns * pages.width)
        self._cut(level, first, wide)
        end = first + len(rows)
        if end == here.pixel_height:
            last = wide[-here.bucket :]
            for place in range(end, pages.rows * pages.height * here.bucket, here.bucket):
                self._cut(level, place, last)

    def _cut(self, level: int, first: int, rows: Floats) -> None:
        pages, n = self._pages.at_level(level), self._stored.bucket
        height, width = pages.height * n, pages.width * n
        for begin, some in _split(first, rows, height):
            row, place = divmod(begin, height)
            for column in range(pages.columns):
                part = some[:, column * width : (column + 1) * width]
                self._put(level, row * pages.columns + column, place, part)

    def _put(self, level: int, layer: int, first: int, rows: Floats) -> None:
        form, last = self._texture.form, self._levels - 1
        if level < last or form.levels == self._levels:
            self._texture.put(level, layer, first, rows)
            return
        if layer not in self._further:
            heights = [max(1, form.height >> further) for further in range(last, form.levels - 1)]

            def put(further: int, begin: int, some: Floats) -> None:
                self._texture.put(last + further, layer, begin, some)

            self._further[layer] = RowChain([image_halving(height) for height in heights], put)
        self._further[layer].push(rows)


def _at_level(stored: AtlasLayout, level: int) -> AtlasLayout:
    return AtlasLayout(stored.width >> level, stored.height >> level, stored.bucket)


def _widened(rows: Floats, layout: AtlasLayout, width: int) -> Floats:
    """Widen rows of whole texels to `width` texels by repeating the last ones."""
    height = len(rows) // layout.bucket
    own = AtlasLayout(layout.width, height, layout.bucket)
    return rows if width == layout.width else pad(rows, own, AtlasLayout(width, height, layout.bucket))


def _split(first: int, rows: Floats, height: int) -> Iterator[tuple[int, Floats]]:
    """Cut rows, the first of which has the number `first`, at multiples of `height`."""
    begin, end = first, first + len(rows)
    while begin < end:
        after = min(end, (begin // height + 1) * height)
        yield begin, rows[begin - first : after - first]
        begin = after


def _coloured(rows: Floats) -> Floats:
    """Rows as float32 with three or four channels; a single channel is repeated to grey."""
    light = rows.astype(np.float32)
    return light if light.shape[2] > 1 else np.repeat(light, 3, axis=2)
