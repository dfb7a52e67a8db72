# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bucket matrix that is larger than a device's textures, cut into pages: layers of one array texture.

Texel (i, j) lies in the layer floor(j / height) * columns + floor(i / width), at (i mod width, j mod
height). Images have row 0 at the bottom (v = 0), and pages are counted from the bottom left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Floats
from .atlas import AtlasLayout
from .errors import InputError, ShapeError
from .levels import level_chain, pad
from .slices import LAYERS


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


def split_pages(image: Floats, layout: AtlasLayout, pages: Pages) -> Floats:
    """An atlas (H*n, W*n, C) as pages (layers, height*n, width*n, C).

    The last pages are padded as in `levels.pad`. To split a mip level of a padded atlas, give its own layout
    and `pages.at_level`. The dtype stays. Raises ShapeError if the layout does not fit into the pages.
    """
    stored = pages.stored(layout.bucket)
    page_height, page_width = pages.height * layout.bucket, pages.width * layout.bucket
    filled = pad(image, layout, stored)
    cut = filled.reshape(pages.rows, page_height, pages.columns, page_width, image.shape[2])
    return cut.transpose(0, 2, 1, 3, 4).reshape(pages.layers, page_height, page_width, image.shape[2])


def page_chain(image: Floats, layout: AtlasLayout, pages: Pages, levels: int) -> list[Floats]:
    """The pages of an atlas (H*n, W*n, C) and their mip levels, (layers, (height >> L)*n, (width >> L)*n, C).

    The levels and their dtype are those of `levels.level_chain`. Raises ShapeError as `split_pages` does, and
    if the pages' size is not a multiple of 2^(levels - 1) texels.
    """
    pages.at_level(levels - 1)
    page = AtlasLayout(pages.width, pages.height, layout.bucket)
    chains = [level_chain(cut, page, levels) for cut in split_pages(image, layout, pages)]
    return [np.stack(level) for level in zip(*chains, strict=True)]


def join_pages(stack: Floats, layout: AtlasLayout, pages: Pages) -> Floats:
    """Join pages (layers, height*n, width*n, C) into the atlas (H*n, W*n, C), without the padding.

    Raises ShapeError if the pages have another shape or the layout does not fit into them.
    """
    page_height, page_width = pages.height * layout.bucket, pages.width * layout.bucket
    if stack.ndim != 4 or stack.shape[:3] != (pages.layers, page_height, page_width):
        expected = f"({pages.layers}, {page_height}, {page_width}, C)"
        raise ShapeError(f"pages: expected shape {expected}, got {stack.shape}")
    stored = pages.stored(layout.bucket)
    if stored.width < layout.width or stored.height < layout.height:
        raise ShapeError(f"pages: {pages} do not hold {layout.width} x {layout.height} texels")
    cut = stack.reshape(pages.rows, pages.columns, page_height, page_width, stack.shape[3])
    whole = cut.transpose(0, 2, 1, 3, 4).reshape(stored.pixel_height, stored.pixel_width, stack.shape[3])
    return whole[: layout.pixel_height, : layout.pixel_width]
