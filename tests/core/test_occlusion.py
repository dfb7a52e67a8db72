# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion of known skies, and the grid that it is taken on."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.errors import ShapeError
from radtex_addon.core.hemisphere import cell_centres, occlusion, square_to_cosine


def test_the_square_becomes_the_hemisphere_and_area_the_cosine() -> None:
    way = square_to_cosine(cell_centres(256)).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(way, axis=1), 1)
    assert way[:, 2].min() > 0
    radius, turn = np.hypot(way[:, 0], way[:, 1]), np.arctan2(way[:, 1], way[:, 0])
    for ring in (16, 40, 64, 120):  # of 128
        assert np.mean(radius < ring / 128) == pytest.approx((ring / 128) ** 2, abs=1e-12)
    counts, _ = np.histogram(turn, bins=16, range=(-np.pi, np.pi))
    np.testing.assert_allclose(counts / len(turn), 1 / 16, atol=1e-3)


def test_it_keeps_axes_and_diagonals_and_meets_the_horizon_at_the_edge() -> None:
    b = np.array([[0.0, 0], [0.5, 0], [0, -0.5], [1, 1], [-1, 0.0], [-0.5, -0.5]])
    root, half = np.sqrt(0.5), np.sqrt(0.75)
    low = 0.5 * root
    expected = [[0, 0, 1], [0.5, 0, half], [0, -0.5, half], [root, root, 0], [-1, 0, 0], [-low, -low, half]]
    np.testing.assert_allclose(square_to_cosine(b), expected, atol=1e-12)
    assert square_to_cosine(b.astype(np.float32)).dtype == np.float32


@pytest.mark.parametrize("n", [1, 2, 5, 8])
def test_open_and_closed(n: int) -> None:
    bent, ambient = occlusion(np.stack([np.ones((n, n)), np.zeros((n, n))]))
    np.testing.assert_allclose(ambient, [1, 0], atol=1e-12)
    np.testing.assert_allclose(bent, [[0, 0, 1]] * 2, atol=1e-12)
    with pytest.raises(ShapeError, match=r"visibility: .*\(\.\.\., n, n\)"):
        occlusion(np.ones((n, n + 1)))


@pytest.mark.parametrize("degrees", [2, 10, 35, 60, 80])
def test_a_long_wall_takes_its_known_share_and_bends_the_normal_away(degrees: float) -> None:
    """A wall up to the elevation a, on the side of -x, blocks (1 - cos a) / 2 of the cosine's hemisphere."""
    n, fine, elevation = 8, 64, np.radians(degrees)
    way = square_to_cosine(cell_centres(n * fine))
    seen = np.arctan2(way[..., 2], -way[..., 0]) > elevation
    bent, ambient = occlusion(seen.reshape(n, fine, n, fine).mean(axis=(1, 3)))
    assert abs(ambient - (1 + np.cos(elevation)) / 2) < 1e-3
    # Directions (sin b, y, cos b) / |.| at angles b from the zenith towards +x, with the cosine's weight: the
    # means of x and z are as the integrals of sin b cos b and of cos² b over the sky.
    angle = (np.arange(4000) + 0.5) / 4000 * (np.pi - elevation) - (np.pi / 2 - elevation)
    x, z = np.mean(np.sin(angle) * np.cos(angle)), np.mean(np.cos(angle) ** 2)
    np.testing.assert_allclose(bent, [x / np.hypot(x, z), 0, z / np.hypot(x, z)], atol=0.02)
