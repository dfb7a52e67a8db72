# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solid angles of cells, against adaptive quadrature of the Jacobian of the very maps that are used."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import dblquad

from radtex_addon.core import hemisphere as hs
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.solid_angle import cell_solid_angles_sr


def jacobian_sr(y: float, x: float) -> float:
    """d(solid angle)/dB at B = (x, y), the closed form: 2 |dA/dB| by central differences would be inexact."""
    big, small = max(abs(x), abs(y)), min(abs(x), abs(y))
    return 2 * big * big / (big * big + small * small) if big else 2.0


def quadrature_sr(x0: float, x1: float, y0: float, y1: float) -> float:
    """Integrate over a cell, split at the diagonals, where the Jacobian has a kink."""

    def left_diagonal(y: float) -> float:
        return min(max(-abs(y), x0), x1)

    def right_diagonal(y: float) -> float:
        return min(max(abs(y), x0), x1)

    kinks = sorted({y0, y1, *(k for k in (x0, x1) if y0 < k < y1)})
    total = 0.0
    for low, high in pairwise(kinks):
        bounds: tuple[float | Callable[[float], float], ...] = (x0, left_diagonal, right_diagonal, x1)
        for left, right in pairwise(bounds):
            total += dblquad(
                lambda x, y: jacobian_sr(y, x), low, high, left, right, epsabs=1e-12, epsrel=1e-12
            )[0]
    return total


def test_the_jacobian_is_that_of_the_maps() -> None:
    rng = np.random.default_rng(3)
    b = rng.uniform(-0.95, 0.95, (200, 2))
    h = 1e-6
    da = [(hs.square_to_disc(b + e) - hs.square_to_disc(b - e)) / (2 * h) for e in np.eye(2) * h]
    determinant = np.abs(da[0][:, 0] * da[1][:, 1] - da[0][:, 1] * da[1][:, 0])
    smooth = np.abs(np.abs(b[:, 0]) - np.abs(b[:, 1])) > 1e-4
    expected = np.array([jacobian_sr(y, x) for x, y in b])
    np.testing.assert_allclose(2 * determinant[smooth], expected[smooth], rtol=1e-6)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8])
def test_each_cell_agrees_with_adaptive_quadrature(n: int) -> None:
    edges = 2 * np.arange(n + 1) / n - 1
    angles = cell_solid_angles_sr(n)
    for q in range(n):
        for p in range(n):
            expected = quadrature_sr(edges[p], edges[p + 1], edges[q], edges[q + 1])
            assert abs(angles[q, p] - expected) < 1e-9, (p, q)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 8, 16, 33, 128])
def test_they_sum_to_a_hemisphere_and_share_the_squares_symmetry(n: int) -> None:
    angles = cell_solid_angles_sr(n)
    assert abs(angles.sum() - 2 * np.pi) < 1e-10
    for same in (angles.T, angles[::-1], angles[:, ::-1]):
        np.testing.assert_allclose(angles, same, atol=1e-14)
    assert (angles > 0).all()


def test_no_cells_no_angles() -> None:
    with pytest.raises(ShapeError, match="at least 1"):
        cell_solid_angles_sr(0)
