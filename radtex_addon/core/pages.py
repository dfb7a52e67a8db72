# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bucket matrix that is larger than a device's textures, cut into pages: layers of one array texture.

Texel (i, j) lies in the layer floor(j / height) * columns + floor(i / width), at (i mod width, j mod
height). Images have row 0 at the bottom (v = 0), and pages are counted from the bottom left.
"""

from __future__ import annotations

from dataclasses import dataclass

from .atlas import AtlasLayout
from .errors import InputError, ShapeError
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
