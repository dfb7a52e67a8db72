# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The projection and the square map: round trips, known points, rotated frames, edges."""

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


def test_corners_of_the_square_are_the_rim() -> None:
    corners = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]], float)
    np.testing.assert_allclose(np.linalg.norm(hs.square_to_disc(corners), axis=1), 1, atol=1e-15)
    np.testing.assert_allclose(hs.square_to_direction(corners)[:, 2], 0, atol=1e-15)


def test_below_the_horizon_lands_on_the_rim_at_its_azimuth() -> None:
    azimuth = np.linspace(0, 2 * np.pi, 9)
    rim = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    for z in (-0.01, -0.5, -0.999999):
        sunk = np.concatenate([rim * np.sqrt(1 - z * z), np.full((9, 1), z)], axis=1)
        np.testing.assert_allclose(hs.equisolid(sunk), rim, atol=1e-9)
    assert (hs.equisolid(np.array([[0, 0, -1.0]])) == 0).all()


def test_a_nan_stays_where_it_is() -> None:
    direction = np.array([[np.nan, 0, 1], [0, 0, 1]])
    b = hs.direction_to_square(direction)
    assert np.isnan(b[0]).any()
    assert (b[1] == 0).all()


def test_mirror_direction_is_the_papers() -> None:
    a = hs.square_to_disc(np.array([[0.3, -0.7]]))
    q = np.sqrt(2 - (a**2).sum())
    expected = [[-a[0, 0] * q, -a[0, 1] * q, 1 - (a**2).sum()]]
    np.testing.assert_allclose(hs.mirror_direction(hs.equisolid_inverse(a)), expected, atol=1e-15)


def test_bleed_guard_stops_at_the_outer_cells_centres() -> None:
    np.testing.assert_allclose(
        hs.bleed_guard(np.array([[-1.0, 1.0], [0.5, 0.0]]), 4), [[-0.75, 0.75], [0.5, 0]]
    )
    np.testing.assert_allclose(hs.cell_centres(4)[0, 0], [-0.75, -0.75])
    np.testing.assert_allclose(hs.cell_centres(4)[0, 3], [0.75, -0.75])  # columns run along T


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
