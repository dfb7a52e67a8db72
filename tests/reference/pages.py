# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of an atlas too large for one texture, as a whole."""

from __future__ import annotations

import numpy as np

from radtex_addon.core.arrangements import Pages, pad
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from tests.reference.levels import level_chain


def split_pages(image: Floats, layout: AtlasLayout, pages: Pages) -> Floats:
    """An atlas (H*n, W*n, C) as pages (layers, height*n, width*n, C).

    The last pages are padded as by `pad`. To split a mip level of a padded atlas, give its own layout
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
    """Join pages (layers, height*n, width*n, C) into the atlas (H*n, W*n, C), without the padding."""
    page_height, page_width = pages.height * layout.bucket, pages.width * layout.bucket
    stored = pages.stored(layout.bucket)
    cut = stack.reshape(pages.rows, pages.columns, page_height, page_width, stack.shape[3])
    whole = cut.transpose(0, 2, 1, 3, 4).reshape(stored.pixel_height, stored.pixel_width, stack.shape[3])
    return whole[: layout.pixel_height, : layout.pixel_width]
