# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A condensed lobe's textures, pixel by pixel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.core.errors import ShapeError
from radtex_addon.formats.condensed_packing import (
    layer_values,
    pack_tiles,
    pack_weights,
    unpack_tiles,
    unpack_weights,
    value_range,
)
from radtex_addon.formats.packing import pack, pack_buckets, with_border
from tests.shared_atlases import SHARPEST, random_condensed_atlas


def test_a_texels_bytes_are_the_formats() -> None:
    cluster = np.array([[0, 255], [256, 65535]], dtype=np.int32)
    weights = np.array([[[0, 1], [-1, 0.5]], [[1 / 127, -1 / 127], [0.5 / 127, 1.5 / 127]]], dtype=np.float32)
    assert pack_weights(cluster, weights).tolist() == [
        [[128, 255, 0, 0], [1, 192, 255, 0]],
        [[129, 127, 0, 1], [128, 130, 255, 255]],
    ]
    six = np.array([[[0, 1, -1, 0, 1, -1]]], dtype=np.float32)
    assert pack_weights(np.array([[0x1234]]), six).tolist() == [[[128, 255, 1, 128], [255, 1, 0x34, 0x12]]]


@pytest.mark.parametrize("rank", [2, 6, 10])
def test_clusters_and_weights_come_back(rank: int) -> None:
    rng = np.random.default_rng(1)
    cluster = rng.integers(0, 65536, (40, 30), dtype=np.int32)
    weights = rng.uniform(-1, 1, (40, 30, rank)).astype(np.float32)
    pixels = pack_weights(cluster, weights)
    assert pixels.shape == (40, 30 * (rank + 2) // 4, 4)
    found, near = unpack_weights(pixels, rank)
    np.testing.assert_array_equal(found, cluster)
    np.testing.assert_allclose(near, weights, atol=0.5 / 127 + 1e-6)
    assert (found.dtype.name, near.dtype.name) == ("int32", "float32")
    np.testing.assert_array_equal(pack_weights(found, near), pixels)


@pytest.mark.parametrize("channels", [2, 3])
def test_every_tile_lies_where_the_format_says(channels: int) -> None:
    """Seven clusters of three tiles in five columns: the last row has one, and four places are empty."""
    tiles = np.random.default_rng(1).uniform(-3, 5, (7, 3, 6, 6, channels)).astype(np.float32)
    limits = value_range(tiles)
    image = pack_tiles(tiles, limits, columns=5)
    assert image.shape == (5 * 8, 5 * 8, channels)
    for cluster, k in np.ndindex(7, 3):
        column, row = (cluster * 3 + k) % 5, (cluster * 3 + k) // 5
        low, high = limits[:2] if k == 0 else limits[2:]
        tile = image[row * 8 : row * 8 + 8, column * 8 : column * 8 + 8]
        bucket = tiles[cluster, k][None, None]
        np.testing.assert_allclose(low + tile * (high - low), pack_buckets(bucket), atol=2e-6)
    assert (image[32:, 8:] == 0).all()
    assert 0 <= image.min() < image.max() <= 1
    np.testing.assert_allclose(unpack_tiles(image, limits, 7, 2, 5), tiles, atol=2e-6)
    with_alpha = np.pad(image, ((0, 0), (0, 0), (0, 1)), constant_values=1)
    np.testing.assert_allclose(unpack_tiles(with_alpha, limits, 7, 2, 5), tiles, atol=2e-6)


def test_ranges_are_those_of_the_first_tiles_and_of_all_others() -> None:
    tiles = np.zeros((2, 3, 2, 2, 3), dtype=np.float32)
    tiles[0, 0] = [1, 2, 3]
    tiles[1, 0] = [5, 1, 3]
    tiles[0, 2, 1, 1] = [-1, 0, 7]
    tiles[1, 1, 0, 0] = [9, 0, -2]
    assert value_range(tiles).tolist() == [[1, 1, 3], [5, 2, 3], [-1, 0, -2], [9, 0, 7]]


def test_what_is_constant_comes_back_exactly() -> None:
    tiles = np.full((2, 3, 2, 2, 3), 0.1, dtype=np.float32)
    image = pack_tiles(tiles, value_range(tiles), columns=3)
    assert (image == 0).all()
    np.testing.assert_array_equal(unpack_tiles(image, value_range(tiles), 2, 2, 3), tiles)


def test_layers_hold_the_dense_forms_values() -> None:
    atlas = random_condensed_atlas(bucket=6)
    values, dense = layer_values(atlas), pack(atlas.expanded())
    for layer in ("colour", "irradiance", "surroundings"):
        np.testing.assert_array_equal(values[layer], dense[layer])
    assert list(values)[3:] == [
        f"{axis}_{part}" for axis in ("mirror", "through") for part in ("weights", "ends", "gain", "rest")
    ]
    mirror = atlas.lobes[0]
    np.testing.assert_array_equal(values["mirror_weights"], mirror.weights)
    np.testing.assert_allclose(values["mirror_ends"][..., 3] * SHARPEST, mirror.ends[..., 3], rtol=1e-6)
    tile = replace(mirror, weights=np.zeros_like(mirror.weights)).expanded().ends[2, 3, :, :, :3]
    own = values["mirror_ends"][mirror.cluster[2, 3], 0, :, :, :3]
    np.testing.assert_array_equal(with_border(own), with_border(tile))


def test_maps_that_do_not_fit_each_other_are_refused() -> None:
    atlas = random_condensed_atlas()
    mirror, through = atlas.lobes
    deeper = random_condensed_atlas(rank=6).lobes[1]
    smaller = random_condensed_atlas(bucket=6).lobes[1]
    for wrong in (
        replace(atlas, lobes=(mirror, deeper)),
        replace(atlas, lobes=(mirror, smaller)),
        replace(atlas, irradiance=atlas.irradiance[:4]),
    ):
        with pytest.raises(ShapeError, match="do not fit the other maps"):
            layer_values(wrong)
    parts = {part: getattr(through, part)[:, :1] for part in ("ends", "gain", "rest")}
    flat = replace(through, weights=through.weights[..., :0], **parts)
    with pytest.raises(ShapeError, match=r"through: tiles of shape \(4, 1, 14, 14, 4\) mix nothing"):
        layer_values(replace(atlas, lobes=(flat,)))
    with pytest.raises(ShapeError, match=r"falloff: expected 2 axes"):
        layer_values(replace(atlas, falloff=np.zeros(3, np.float32)))
