# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solid angles of cells, against sums over the Jacobian of the very maps that are used."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core import hemisphere as hs
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.solid_angle import cell_solid_angles_sr


def jacobian_sr(b: Floats) -> Floats:
    """d(solid angle)/dB at B (..., 2), the closed form."""
    small, big = np.moveaxis(np.sort(np.abs(b), axis=-1), -1, 0)
    return np.asarray(2 * big * big / (big * big + small * small))


def test_the_jacobian_is_that_of_the_maps() -> None:
    rng = np.random.default_rng(3)
    b = rng.uniform(-0.95, 0.95, (200, 2))
    h = 1e-6
    da = [(hs.square_to_disc(b + e) - hs.square_to_disc(b - e)) / (2 * h) for e in np.eye(2) * h]
    determinant = np.abs(da[0][:, 0] * da[1][:, 1] - da[0][:, 1] * da[1][:, 0])
    smooth = np.abs(np.abs(b[:, 0]) - np.abs(b[:, 1])) > 1e-4
    np.testing.assert_allclose(2 * determinant[smooth], jacobian_sr(b)[smooth], rtol=1e-6)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8])
def test_each_cell_is_the_jacobians_integral(n: int) -> None:
    fine = 400
    density = jacobian_sr(hs.cell_centres(n * fine)).reshape(n, fine, n, fine)
    np.testing.assert_allclose(cell_solid_angles_sr(n), density.mean(axis=(1, 3)) * (2 / n) ** 2, rtol=1e-4)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 8, 16, 33, 128])
def test_they_sum_to_a_hemisphere_and_share_the_squares_symmetry(n: int) -> None:
    angles = cell_solid_angles_sr(n)
    assert abs(angles.sum() - 2 * np.pi) < 1e-10
    for same in (angles.T, angles[::-1], angles[:, ::-1]):
        np.testing.assert_allclose(angles, same, atol=1e-14)
    assert (angles > 0).all()
    with pytest.raises(ShapeError, match="at least 1"):
        cell_solid_angles_sr(0)
