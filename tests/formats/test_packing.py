# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packed images are looked up by plain bilinear filtering, and give back what was packed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.core.arrays import Floats
from radtex_addon.core.octahedron import sample_octahedron
from radtex_addon.core.shared import Axis, level_sizes
from radtex_addon.formats.packing import (
    pack,
    pack_buckets,
    pack_surroundings,
    surroundings_size,
    unpack_buckets,
    unpack_lobe,
    unpack_surroundings,
    with_border,
)
from tests.shared_atlases import SHARPEST, random_shared_atlas


def filtered(image: Floats, position: Floats) -> Floats:
    """What a GPU's bilinear filter finds at (K, 2) in pixels, their centres at a half."""
    corner = np.floor(position - 0.5).astype(int)
    (fx, fy), (x, y) = (position - 0.5 - corner).T[..., None], corner.T
    below = image[y, x] * (1 - fx) + image[y, x + 1] * fx
    above = image[y + 1, x] * (1 - fx) + image[y + 1, x + 1] * fx
    found: Floats = below * (1 - fy) + above * fy
    return found


def places(count: int = 4000) -> Floats:
    """On the square (K, 2) inside [0, 1), some of them on its edges and corners."""
    place = np.random.default_rng(2).random((count, 2))
    place[:400, 0], place[300:700, 1] = 0, 0
    place[700:1100, 0], place[1000:1400, 1] = 1 - 1e-9, 1 - 1e-9
    return place


@pytest.mark.parametrize("size", [1, 2, 3, 8, 11])
def test_a_bordered_picture_needs_no_knowledge_of_the_sphere(size: int) -> None:
    image, place = np.random.default_rng(1).random((size, size, 3)), places()
    found = filtered(with_border(image), place * size + 1)
    np.testing.assert_allclose(found, sample_octahedron(image, place), atol=1e-7)


def test_a_border_mirrors_its_edge_at_the_middle_and_corners_are_the_opposite_ones() -> None:
    numbers = np.arange(9.0).reshape(3, 3, 1)
    bordered = with_border(numbers)[..., 0]
    expected = [[8, 2, 1, 0, 6], [6, 0, 1, 2, 8], [3, 3, 4, 5, 5], [0, 6, 7, 8, 2], [2, 8, 7, 6, 0]]
    np.testing.assert_array_equal(bordered, expected)


def test_every_cell_lies_where_the_format_says() -> None:
    buckets = np.random.default_rng(1).random((3, 5, 4, 4, 2))
    image = pack_buckets(buckets)
    assert image.shape == (3 * 6, 5 * 6, 2)
    for j, i, y, x in np.ndindex(3, 5, 4, 4):
        np.testing.assert_array_equal(image[j * 6 + 1 + y, i * 6 + 1 + x], buckets[j, i, y, x])
    np.testing.assert_array_equal(unpack_buckets(image, 4), buckets)


@given(st.integers(8, 70), st.integers(1, 9))
def test_levels_come_back_from_one_image_and_nothing_else_is_in_it(size: int, count: int) -> None:
    levels = tuple(
        np.full((side, side, 3), 1 + k, np.float32) for k, side in enumerate(level_sizes(size, count))
    )
    image = pack_surroundings(levels)
    assert image.shape[:2] == surroundings_size(size, count)[::-1]
    for found, level in zip(unpack_surroundings(image, size, count), levels, strict=True):
        np.testing.assert_array_equal(found, level)
    for number, level in enumerate(levels, 1):
        assert np.count_nonzero(image[..., 0] == number) == (len(level) + 2) ** 2
    assert np.count_nonzero(image[..., 0]) == sum((len(level) + 2) ** 2 for level in levels)


def test_the_surroundings_image_is_the_formats() -> None:
    levels = tuple(np.full((side, side, 3), 1.0 + k) for k, side in enumerate((32, 16, 8, 8)))
    image = pack_surroundings(levels)[..., 0]
    assert image.shape == (38, 34 + 18)
    assert (image[:34, :34] == 1).all()
    assert (image[:18, 34:52] == 2).all()
    assert (image[18:28, 34:44] == 3).all()
    assert (image[28:38, 34:44] == 4).all()
    assert image.sum() == 34**2 + 2 * 18**2 + 7 * 10**2


def test_an_atlas_is_packed_by_layers() -> None:
    atlas = random_shared_atlas(7, 5, 6, 48, 5, [Axis.THROUGH])
    images = pack(atlas)
    assert {name: image.shape for name, image in images.items()} == {
        "colour": (11, 21, 3),
        "irradiance": (5, 7, 3),
        "surroundings": (26 + 14 + 10 + 10, 50 + 26, 3),
        "through_ends": (40, 56, 4),
        "through_gain": (40, 56, 3),
        "through_rest": (40, 56, 3),
    }
    assert {image.dtype for image in images.values()} == {np.dtype(np.float32)}
    spread = unpack_buckets(images["through_ends"], 6)[..., 3]
    np.testing.assert_allclose(spread * SHARPEST, atlas.lobes[0].ends[..., 3], rtol=1e-6)
    lobe = unpack_lobe(images, Axis.THROUGH, 6, SHARPEST)
    np.testing.assert_allclose(lobe.ends, atlas.lobes[0].ends, rtol=1e-6)
    np.testing.assert_array_equal(lobe.gain, atlas.lobes[0].gain)
    np.testing.assert_array_equal(lobe.rest, atlas.lobes[0].rest)
