# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a UV map takes of its atlas and how it is stretched, of squares that are known; and its picture."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.surface import stretches
from radtex_addon.core.uv_map import UvMap, draw_map, island_colours

SQUARE = np.array([[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]], dtype=np.float64)  # two triangles
LUMA = np.array([0.2126, 0.7152, 0.0722])


def square(u: float, v: float, side: float) -> Floats:
    """Two triangles of a square in UV."""
    placed: Floats = np.array([u, v]) + side * SQUARE
    return placed


def flat(side: float, right: float = 0) -> Floats:
    """The square's two triangles in space, `right` along x."""
    placed: Floats = np.pad(side * SQUARE, ((0, 0), (0, 0), (0, 1))) + np.array([right, 0, 0])
    return placed


def test_a_square_covers_what_it_should() -> None:
    found = UvMap(flat(2), square(0.25, 0.5, 0.5), 64, 64)
    assert found.islands == 1
    assert found.area == pytest.approx(32 * 32)
    assert found.coverage == pytest.approx(0.25)
    assert found.density == pytest.approx(16)  # 32 texels along 2 units
    assert found.relative_density == pytest.approx([1, 1])
    assert found.seams == pytest.approx(4 * 32 / 32**2)  # the diagonal is no seam


@pytest.mark.parametrize(("side", "seams"), [(0.5, 0.125), (0.125, 0.5), (0.03, 1.0)])
def test_the_smaller_an_island_the_more_of_it_is_seam(side: float, seams: float) -> None:
    assert UvMap(flat(1), square(0, 0, side), 64, 64).seams == pytest.approx(seams)


def test_islands_are_joined_by_place_and_uv_alone() -> None:
    corners = np.concatenate([flat(1), flat(1, right=1)])
    joined = UvMap(corners, np.concatenate([square(0, 0, 0.25), square(0.25, 0, 0.25)]), 64, 64)
    assert joined.islands == 1
    assert joined.seams == pytest.approx(6 * 16 / (2 * 16**2))
    torn = UvMap(corners, np.concatenate([square(0, 0, 0.25), square(0.5, 0, 0.25)]), 64, 64)
    assert torn.islands == 2
    assert torn.island.tolist() == [0, 0, 1, 1]
    assert torn.seams == pytest.approx(8 * 16 / (2 * 16**2))


def test_density_is_told_against_the_mean_of_the_surface() -> None:
    corners = np.concatenate([flat(1), flat(1, right=5)])
    found = UvMap(corners, np.concatenate([square(0, 0, 0.5), square(0.5, 0, 0.25)]), 64, 64)
    mean = np.sqrt((32**2 + 16**2) / 2)
    assert found.density == pytest.approx(mean)
    assert found.relative_density == pytest.approx(np.array([32, 32, 16, 16]) / mean)


def test_the_picture_shows_islands_where_they_lie_and_dense_ones_darker() -> None:
    corners = np.concatenate([flat(1), flat(1, right=5)])
    uv = np.concatenate([square(0, 0.5, 0.5), square(0.75, 0, 0.125)])  # upper left; lower right
    picture = draw_map(UvMap(corners, uv, 64, 32), 128)
    assert picture.shape == (64, 128, 3)
    dense, sparse, empty = picture[10, 10], picture[60, 100], picture[60, 10]
    assert empty.max() == empty.min() < 0.1
    dense_over_mean = np.sqrt(32 * 16 / ((32 * 16 + 8 * 4) / 2))
    assert dense @ LUMA == pytest.approx(0.75 * 0.75 / dense_over_mean)
    assert sparse @ LUMA == pytest.approx(0.75)
    assert np.abs(dense / dense.max() - sparse / sparse.max()).max() > 0.2  # other hues


def test_colours_of_islands_are_equally_bright_and_differ() -> None:
    colours = island_colours(np.arange(24))
    assert colours.min() >= 0
    assert colours.max() <= 1
    assert colours @ LUMA == pytest.approx(np.full(24, 0.75))
    apart = np.linalg.norm(colours[:, None] - colours[None], axis=2) + np.eye(24)
    assert apart.min() > 0.02
    beside = np.linalg.norm(np.diff(colours, axis=0), axis=1)
    assert beside.min() > 0.25


@pytest.mark.parametrize("most", [1.0, 1.5, 4.0])
@pytest.mark.parametrize("least", [0.25, 1.0])
def test_a_map_of_known_stretch_is_found(most: float, least: float) -> None:
    chance = np.random.default_rng(2)
    corners = chance.normal(size=(40, 3, 3))
    along = corners[:, 1] - corners[:, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normal = np.cross(along, corners[:, 2] - corners[:, 0])
    across = np.cross(normal / np.linalg.norm(normal, axis=1, keepdims=True), along)
    flat = np.einsum("fcx,fax->fca", corners - corners[:, :1], np.stack([along, across], axis=1))
    turn, back = (np.linalg.qr(chance.normal(size=(40, 2, 2)))[0] for _ in range(2))
    mapped = np.einsum("fab,b,fbc,fkc->fka", turn, np.array([most, least]), back, flat)
    found = stretches(corners, mapped + chance.normal(size=(40, 1, 2)))
    np.testing.assert_allclose(found, np.tile([most, least], (40, 1)), rtol=1e-6)


def test_a_triangle_without_area_gives_numbers() -> None:
    assert np.isfinite(stretches(np.zeros((1, 3, 3)), np.zeros((1, 3, 2)))).all()
