# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The projection and the square map: round trips, known points, edges, and the solid angles of cells."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from radtex_addon.core import hemisphere as hs
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.hemisphere import cell_solid_angles_sr

Real: TypeAlias = type[np.floating[Any]]

TOLERANCE: dict[Real, float] = {np.float64: 1e-12, np.float32: 2e-6}
dtypes = st.sampled_from([np.float64, np.float32])
coordinate = st.floats(-1, 1, allow_nan=False)
squares = hnp.arrays(np.float64, st.tuples(st.integers(1, 40), st.just(2)), elements=coordinate)


@st.composite
def hemisphere_directions(draw: st.DrawFn) -> Floats:
    """Unit vectors over the whole closed hemisphere, the pole and the horizon included."""
    cosine = draw(st.one_of(st.floats(0, 1), st.sampled_from([0.0, 1e-12, 1e-6, 1 - 1e-12, 1.0])))
    azimuth = draw(st.floats(-np.pi, np.pi))
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    return np.array([[sine * np.cos(azimuth), sine * np.sin(azimuth), cosine]])


@given(hemisphere_directions(), dtypes)
def test_direction_survives_the_bucket(direction: Floats, dtype: Real) -> None:
    direction = direction.astype(dtype)
    b = hs.direction_to_square(direction)
    back = hs.square_to_direction(b)
    assert back.dtype == b.dtype == dtype
    assert np.abs(b).max() <= 1
    np.testing.assert_allclose(back, direction, atol=TOLERANCE[dtype], rtol=0)


@given(squares, dtypes)
def test_square_survives_the_hemisphere(b: Floats, dtype: Real) -> None:
    b = b.astype(dtype)
    assert np.linalg.norm(hs.square_to_disc(b), axis=1).max() <= 1 + TOLERANCE[dtype]
    direction = hs.square_to_direction(b)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1, atol=TOLERANCE[dtype])
    np.testing.assert_allclose(hs.direction_to_square(direction), b, atol=TOLERANCE[dtype], rtol=0)


def test_radius_is_sqrt2_sine_of_half_the_angle() -> None:
    theta = np.linspace(0, np.pi / 2, 50)
    direction = np.stack([np.sin(theta), np.zeros(50), np.cos(theta)], axis=-1)
    np.testing.assert_allclose(hs.equisolid(direction)[:, 0], np.sqrt(2) * np.sin(theta / 2), atol=1e-15)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_centre_and_tiny_coordinates_are_numbers(dtype: Real) -> None:
    zero = np.zeros((1, 2), dtype)
    assert (hs.disc_to_square(zero) == 0).all()
    assert (hs.square_to_disc(zero) == 0).all()
    for tiny in (1e-30, -1e-30, np.finfo(dtype).tiny):
        for pair in ([tiny, 0], [0, tiny], [tiny, tiny]):
            b = np.array([pair], dtype)
            assert np.isfinite(hs.square_to_disc(b)).all()
            assert np.isfinite(hs.disc_to_square(b)).all()
            np.testing.assert_allclose(hs.square_to_direction(b), [[0, 0, 1]], atol=1e-29)


def test_below_the_horizon_lands_on_the_rim_at_its_azimuth() -> None:
    azimuth = np.linspace(0, 2 * np.pi, 9)
    rim = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    for z in (-0.01, -0.5, -0.999999):
        sunk = np.concatenate([rim * np.sqrt(1 - z * z), np.full((9, 1), z)], axis=1)
        np.testing.assert_allclose(hs.equisolid(sunk), rim, atol=1e-9)
    assert (hs.equisolid(np.array([[0, 0, -1.0]])) == 0).all()


def test_known_places() -> None:
    corners = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]], float)
    np.testing.assert_allclose(np.linalg.norm(hs.square_to_disc(corners), axis=1), 1, atol=1e-15)
    np.testing.assert_allclose(hs.square_to_direction(corners)[:, 2], 0, atol=1e-15)
    a = hs.square_to_disc(np.array([[0.3, -0.7]]))
    q = np.sqrt(2 - (a**2).sum())
    expected = [[-a[0, 0] * q, -a[0, 1] * q, 1 - (a**2).sum()]]  # the paper's mirror direction
    np.testing.assert_allclose(hs.mirror_direction(hs.equisolid_inverse(a)), expected, atol=1e-15)
    guarded = hs.bleed_guard(np.array([[-1.0, 1.0], [0.5, 0.0]]), 4)  # at the outer cells' centres
    np.testing.assert_allclose(guarded, [[-0.75, 0.75], [0.5, 0]])
    np.testing.assert_allclose(hs.cell_centres(4)[0, 0], [-0.75, -0.75])
    np.testing.assert_allclose(hs.cell_centres(4)[0, 3], [0.75, -0.75])  # columns run along T
    b = hs.direction_to_square(np.array([[np.nan, 0, 1], [0, 0, 1]]))  # a NaN stays where it is
    assert np.isnan(b[0]).any()
    assert (b[1] == 0).all()


@pytest.mark.parametrize(
    ("function", "argument"),
    [
        (hs.equisolid, np.zeros((4, 2))),
        (hs.equisolid_inverse, np.zeros(3)),
        (hs.disc_to_square, np.float64(1)),
        (hs.square_to_disc, np.zeros((2, 2), complex)),
        (hs.direction_to_square, np.zeros((0,))),
        (hs.mirror_direction, np.array(["a", "b", "c"])),
    ],
)
def test_wrong_shapes_are_named(function: Callable[..., object], argument: object) -> None:
    with pytest.raises(ShapeError, match="expected"):
        function(argument)


def test_empty_arrays_pass_through_and_integers_become_float64() -> None:
    assert hs.direction_to_square(np.zeros((0, 3))).shape == (0, 2)
    assert hs.square_to_direction(np.zeros((5, 0, 2))).shape == (5, 0, 3)
    assert hs.equisolid(np.array([[0, 0, 1]])).dtype == np.float64


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
