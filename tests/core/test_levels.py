# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Levels, slices and pages of an atlas: plain means, exact halves, whole texels, nothing shifted or lost."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrangements import (
    Halving,
    Pages,
    RowChain,
    bucket_halving,
    fitting_levels,
    fitting_pages,
    halved,
    image_halving,
    pad,
    padded_layout,
    to_slices,
)
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError, ShapeError
from radtex_addon.formats.containers.texture import PixelFormat, TextureShape
from tests.lookups import LAYOUT, random_atlas
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import split_pages
from tests.reference.slices import from_slices, mip_chain

LEVELS = 4  # 13 x 7 texels are stored as 16 x 8
ATLAS = random_atlas().astype(np.float64)


@pytest.mark.parametrize(
    ("size", "levels", "stored"), [((13, 7), 1, (13, 7)), ((13, 7), 4, (16, 8)), ((128, 126), 5, (128, 128))]
)
def test_stored_sizes_are_halved_without_a_rest(
    size: tuple[int, int], levels: int, stored: tuple[int, int]
) -> None:
    assert padded_layout(AtlasLayout(*size, 6), levels) == AtlasLayout(*stored, 6)


def test_padding_repeats_the_last_texel_and_keeps_the_rest() -> None:
    stored = padded_layout(LAYOUT, LEVELS)
    buckets = stored.to_buckets(pad(ATLAS, LAYOUT, stored))
    assert (buckets[:7, :13] == LAYOUT.to_buckets(ATLAS)).all()
    assert (buckets[:7, 13:] == buckets[:7, 12:13]).all()
    assert (buckets[7] == buckets[6]).all()


def test_a_level_holds_the_mean_of_its_block_cell_by_cell() -> None:
    chain = level_chain(ATLAS, LAYOUT, LEVELS)
    assert [level.shape for level in chain] == [(48, 96, 4), (24, 48, 4), (12, 24, 4), (6, 12, 4)]
    stored = padded_layout(LAYOUT, LEVELS).to_buckets(chain[0])
    second = AtlasLayout(4, 2, 6).to_buckets(chain[2])
    np.testing.assert_allclose(second[1, 2], stored[4:8, 8:12].mean(axis=(0, 1)), rtol=1e-14)


def test_the_mean_of_half_floats_does_not_overflow() -> None:
    bright = np.full((4, 4, 3), 65504, np.float16)
    last = level_chain(bright, AtlasLayout(2, 2, 2), 2)[1]
    assert last.dtype == np.float32
    assert (last == 65504).all()


@pytest.mark.parametrize("level", [0, 1, 1.5, 2])
def test_levels_do_not_shift_what_they_blur(level: float) -> None:
    """A slope over u stays the same slope, away from the edges, though 13 texels have no half."""
    ramp = np.broadcast_to(np.arange(13.0)[None, :, None, None, None] + 0.5, (7, 13, 6, 6, 1))
    chain = level_chain(LAYOUT.from_buckets(ramp), LAYOUT, 3)
    uv = np.stack([np.linspace(0.2, 0.75, 100), np.full(100, 0.4)], axis=-1)
    result = sample_level(chain, LAYOUT, uv, np.tile([0.0, 0.0, 1.0], (100, 1)), np.array(level))
    np.testing.assert_allclose(result[:, 0], uv[:, 0] * 13, rtol=1e-12)


@pytest.mark.parametrize(
    ("size", "levels"), [((128, 126), 7), ((1, 5), 1), ((130, 130), 5), ((64, 64), 7), ((2, 512), 2)]
)
def test_as_many_levels_as_padding_a_quarter_allows(size: tuple[int, int], levels: int) -> None:
    assert fitting_levels(AtlasLayout(*size, 8)) == levels


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(ShapeError, match="levels: expected 1 to 16"):
        padded_layout(LAYOUT, 0)
    with pytest.raises(ShapeError, match="have no half"):
        halved(ATLAS, LAYOUT)
    with pytest.raises(ShapeError, match="does not fit"):
        pad(ATLAS, LAYOUT, AtlasLayout(12, 8, 6))


def test_a_layer_holds_one_cell_of_all_texels() -> None:
    slices = to_slices(ATLAS, LAYOUT)
    i, j, p, q = 11, 5, 4, 2
    assert slices.shape == (36, 7, 13, 4)
    assert (slices[q * 6 + p, j, i] == ATLAS[j * 6 + q, i * 6 + p]).all()
    assert (from_slices(slices) == ATLAS).all()


def test_levels_have_floored_sizes_and_one_mean() -> None:
    chain = mip_chain(to_slices(ATLAS, LAYOUT))
    assert [level.shape[1:3] for level in chain] == [(7, 13), (3, 6), (1, 3), (1, 1)]
    for level in chain:
        np.testing.assert_allclose(level.mean(axis=(1, 2)), chain[0].mean(axis=(1, 2)), rtol=1e-12)


def test_odd_sizes_weigh_three_pixels_by_their_overlap() -> None:
    """Of five pixels the first of two covers 2.5: two wholly and half the third."""
    line = np.array([1.0, 2, 4, 8, 16]).reshape(1, 1, 5, 1)
    np.testing.assert_allclose(
        mip_chain(line)[1].ravel(), [(1 + 2 + 2) / 2.5, (2 + 8 + 16) / 2.5], rtol=1e-15
    )


def test_levels_are_those_of_the_matrix_where_nothing_is_odd() -> None:
    layout = AtlasLayout(8, 4, 6)
    atlas = ATLAS[: 4 * 6, : 8 * 6]
    chain = mip_chain(to_slices(atlas, layout))
    for level, image in enumerate(level_chain(atlas, layout, 3)):
        half = AtlasLayout(8 >> level, 4 >> level, 6)
        np.testing.assert_allclose(to_slices(image, half), chain[level], rtol=1e-14)


def test_wrong_slices_are_named() -> None:
    with pytest.raises(ShapeError, match="2116 layers"):
        to_slices(np.zeros((46, 46, 1)), AtlasLayout(1, 1, 46))
    with pytest.raises(ShapeError, match=r"\(n\*n, H, W, C\)"):
        from_slices(np.zeros((5, 2, 2, 1)))
    with pytest.raises(ShapeError, match=r"\(n\*n, H, W, C\)"):
        from_slices(np.zeros((4, 2, 2)))


def pushed(image: Floats, halvings: list[Halving], step: int) -> list[Floats]:
    """The levels of an image (..., H, W, C), whose rows come `step` at a time; each row once, in order."""
    levels: list[list[Floats]] = [[] for _ in range(len(halvings) + 1)]

    def take(level: int, first: int, rows: Floats) -> None:
        assert first == sum(some.shape[-3] for some in levels[level])
        levels[level].append(rows)

    chain = RowChain(halvings, take)
    for first in range(0, image.shape[-3], step):
        chain.push(image[..., first : first + step, :, :])
    return [np.concatenate(rows, axis=-3) for rows in levels]


@pytest.mark.parametrize("texels", [1, 3, 100])
@pytest.mark.parametrize(("width", "height", "bucket"), [(16, 8, 3), (32, 64, 2), (13, 7, 4), (1, 5, 2)])
def test_buckets_come_as_of_the_whole(width: int, height: int, bucket: int, texels: int) -> None:
    layout = AtlasLayout(width, height, bucket)
    levels = fitting_levels(layout)
    image = np.random.default_rng(1).random((height * bucket, width * bucket, 4), dtype=np.float32)
    whole = level_chain(image, layout, levels)
    stored = padded_layout(layout, levels)
    halvings = [
        bucket_halving(AtlasLayout(stored.width >> level, stored.height >> level, bucket))
        for level in range(levels - 1)
    ]
    for ours, theirs in zip(pushed(whole[0], halvings, texels * bucket), whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("step", [1, 2, 5, 1000])
@pytest.mark.parametrize(("width", "height"), [(16, 16), (37, 21), (5, 1), (1, 9), (1, 1), (3, 127)])
def test_slices_come_as_of_the_whole(width: int, height: int, step: int) -> None:
    slices = np.random.default_rng(2).random((4, height, width, 3), dtype=np.float32)
    whole = mip_chain(slices)
    halvings = [image_halving(max(1, height >> level)) for level in range(len(whole) - 1)]
    for ours, theirs in zip(pushed(slices, halvings, step), whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)


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
    form = TextureShape(PixelFormat.RGB9E5, limit, limit, pages.layers, levels, is_array=True)
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
