# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of a large atlas: whole texels, within the limit, and back without a loss."""

from __future__ import annotations

import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError, ShapeError
from radtex_addon.core.pages import Pages, fitting_pages
from radtex_addon.formats.containers.texture import Form, PixelFormat
from tests.lookups import LAYOUT, random_atlas
from tests.reference.pages import split_pages

ATLAS = random_atlas()


@pytest.mark.parametrize(
    ("size", "limit", "levels", "pages"),
    [
        ((13, 7), 78, 1, Pages(1, 1, 13, 7)),  # 13 texels of 6 cells are 78 pixels
        ((13, 7), 77, 1, Pages(2, 1, 7, 7)),
        ((13, 7), 30, 1, Pages(3, 2, 5, 4)),
        ((13, 7), 30, 3, Pages(4, 2, 4, 4)),
        ((2048, 2000), 8192, 5, Pages(2, 2, 1024, 1008)),
    ],
)
def test_pages_are_few_and_fit(size: tuple[int, int], limit: int, levels: int, pages: Pages) -> None:
    layout = AtlasLayout(*size, 6)
    assert fitting_pages(layout, limit, levels) == pages
    assert max(pages.width, pages.height) * 6 <= limit
    assert pages.stored(6).width >= size[0]
    assert pages.stored(6).height >= size[1]


@pytest.mark.parametrize(("limit", "levels", "side", "texels"), [(16384, 11, 2, 1024), (8192, 10, 4, 512)])
def test_an_atlas_of_32768_pixels_is_split_to_what_gpus_take(
    limit: int, levels: int, side: int, texels: int
) -> None:
    """2048 texels of 16 cells: 4 GiB as RGB9E5, of which no file's and no header's field is too narrow."""
    pages = fitting_pages(AtlasLayout(2048, 2048, 16), limit, levels)
    assert pages == Pages(side, side, texels, texels)
    form = Form(PixelFormat.RGB9E5, limit, limit, pages.layers, levels, is_array=True)
    assert form.nbytes(0) == 2**32
    assert form.shape(levels - 1) == (side * side, 16, 16, 4)  # one texel a page
    assert pages.at_level(levels - 1) == Pages(side, side, 1, 1)


def test_a_texel_lies_where_the_contract_says() -> None:
    pages = Pages(3, 2, 5, 4)
    stack = split_pages(ATLAS, LAYOUT, pages)
    assert stack.shape == (6, 24, 30, 4)
    i, j = 11, 6
    layer, x, y = (j // 4) * 3 + i // 5, i % 5, j % 4
    bucket = stack[layer, y * 6 : y * 6 + 6, x * 6 : x * 6 + 6]
    assert (bucket == ATLAS[j * 6 : j * 6 + 6, i * 6 : i * 6 + 6]).all()
    assert (stack[layer, :, 18:24] == stack[layer, :, 12:18]).all()  # the 14th texel repeats the 13th


def test_what_cannot_be_is_refused_in_words() -> None:
    with pytest.raises(InputError, match="30 pixels hold no 8 texels of 6 cells"):
        fitting_pages(LAYOUT, 30, levels=4)
    with pytest.raises(InputError, match="4096 pages"):
        fitting_pages(AtlasLayout(64, 64, 6), 6)
    with pytest.raises(ShapeError, match="no level 2"):
        Pages(1, 1, 6, 8).at_level(2)
    with pytest.raises(ShapeError, match="does not fit"):
        split_pages(ATLAS, LAYOUT, Pages(1, 1, 12, 7))
