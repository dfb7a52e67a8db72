# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lookups by the direction to the light: cells, folds, several lights, and light from everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake.transfer_buckets import lookup_solid_angles_sr, mean_over_lights
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.formats.transfer_files import with_views
from tests.reference.relighting import sample_transfer

LAYOUT = AtlasLayout(3, 2, 6)


def random_atlas(seed: int = 1) -> Floats:
    return np.random.default_rng(seed).random((LAYOUT.pixel_height, LAYOUT.pixel_width, 4))


def directions(count: int, seed: int = 2) -> Floats:
    return np.random.default_rng(seed).normal(size=(count, 3))


def test_a_cells_direction_in_a_texels_middle_gives_the_cell() -> None:
    atlas = random_atlas()
    uv = np.tile([(2 + 0.5) / 3, (1 + 0.5) / 2], (36, 1))
    found = sample_transfer(atlas, LAYOUT, uv, cell_directions(6).astype(float))
    expected = LAYOUT.to_buckets(atlas)[1, 2].reshape(36, 4)
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_views_lie_as_the_cells_of_a_bucket_do() -> None:
    """Towards a view's own direction a lookup is that view's alone, and between two it is their mean."""
    random, views = np.random.default_rng(1), 3
    stored = with_views(LAYOUT, views)
    atlas = random.random((stored.pixel_height, stored.pixel_width, 4))
    uv, light = np.tile([(1 + 0.5) / 3, (0 + 0.5) / 2], (9, 1)), np.tile(directions(1), (9, 1))
    middles = square_to_direction(cell_centres(views).reshape(-1, 2)).astype(float)
    found = sample_transfer(atlas, LAYOUT, uv, light, middles, views)
    buckets = stored.to_buckets(atlas)
    for view, answer in enumerate(found):
        bucket = buckets[view // 3, 3 + view % 3]
        alone = sample_transfer(bucket, AtlasLayout(1, 1, 6), uv[:1] * 0 + 0.5, light[:1])
        np.testing.assert_allclose(answer, alone[0], atol=1e-6)
    between = square_to_direction(np.array([[1 / 3, 0.0]]))
    mean = sample_transfer(atlas, LAYOUT, uv[:1], light[:1], between, views)
    np.testing.assert_allclose(mean[0], (found[4] + found[5]) / 2, atol=1e-6)
    with pytest.raises(ShapeError, match="the viewer's directions are missing"):
        sample_transfer(atlas, LAYOUT, uv, light, views=3)
    np.testing.assert_allclose(
        mean_over_lights(atlas, LAYOUT, views)[0, 1],
        np.mean(
            [mean_over_lights(buckets[q, 3 + p], AtlasLayout(1, 1, 6)) for q in range(3) for p in range(3)],
            axis=(0, 1, 2),
        ),
        rtol=1e-5,
    )


def test_cells_share_the_sphere_by_what_lookups_take_of_them() -> None:
    """Against the mean of lookups all over the sphere."""
    share = lookup_solid_angles_sr(6)
    assert share.sum() == pytest.approx(4 * np.pi)
    one = AtlasLayout(1, 1, 6)
    atlas, light = random_atlas()[:6, :6], directions(400_000)
    mean = sample_transfer(atlas, one, np.full((len(light), 2), 0.5), light).mean(axis=0)
    np.testing.assert_allclose(
        mean * 4 * np.pi, np.einsum("qpc,qp->c", atlas, share.reshape(6, 6)), rtol=3e-3
    )


def test_white_surroundings_light_a_diffuse_surface_as_a_furnace_does() -> None:
    """A diffuse surface of albedo 0.8 shows cos / pi of it under unit light, and 0.8 in a white furnace."""
    size = 64
    cosine = np.maximum(cell_directions(size)[:, 2], 0).reshape(size, size, 1)
    found = mean_over_lights(0.8 / np.pi * np.tile(cosine, (1, 1, 3)), AtlasLayout(1, 1, size))
    np.testing.assert_allclose(found, 0.8, rtol=2e-3)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ShapeError, match="transfer atlas: expected 12 x 18 pixels"):
        mean_over_lights(random_atlas()[1:], LAYOUT)
