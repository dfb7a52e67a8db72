# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The octahedral map: round trips, known places, and no seam where the square's edges meet on the sphere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from radtex_addon.core import octahedron as oc
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError

Real: TypeAlias = type[np.floating[Any]]

TOLERANCE: dict[Real, float] = {np.float64: 1e-12, np.float32: 2e-6}
dtypes = st.sampled_from([np.float64, np.float32])
anywhere = st.one_of(st.floats(0, 1), st.sampled_from([0.0, 0.5, 1.0, 0.5 + 1e-12, 1e-12]))


def places(coordinate: st.SearchStrategy[float]) -> st.SearchStrategy[Floats]:
    return hnp.arrays(np.float64, st.tuples(st.integers(1, 40), st.just(2)), elements=coordinate)


@st.composite
def directions(draw: st.DrawFn) -> Floats:
    """Unit vectors over the whole sphere, the poles, the equator and the planes between octants included."""
    cosine = draw(st.one_of(st.floats(-1, 1), st.sampled_from([-1.0, -1e-12, 0.0, 1e-12, 1.0])))
    azimuth = draw(st.one_of(st.floats(-np.pi, np.pi), st.integers(-4, 4).map(lambda k: k * np.pi / 4)))
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    return np.array([[sine * np.cos(azimuth), sine * np.sin(azimuth), cosine]])


def normalised(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def centres(size: int) -> Floats:
    """Places of the cells' centres, (size, size, 2), indexed [y, x]."""
    middle = (np.arange(size) + 0.5) / size
    return np.stack(np.meshgrid(middle, middle), axis=-1)


@given(directions(), dtypes)
def test_direction_survives_the_square(direction: Floats, dtype: Real) -> None:
    direction = direction.astype(dtype)
    place = oc.direction_to_octahedron(direction)
    assert place.dtype == dtype
    assert 0 <= place.min() <= place.max() <= 1
    back = oc.octahedron_to_direction(place)
    assert back.dtype == dtype
    np.testing.assert_allclose(back, direction, atol=TOLERANCE[dtype], rtol=0)


@given(places(anywhere), dtypes)
def test_every_place_even_on_an_edge_is_a_unit_direction_that_comes_back(place: Floats, dtype: Real) -> None:
    direction = oc.octahedron_to_direction(place.astype(dtype))
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1, atol=TOLERANCE[dtype])
    back = oc.octahedron_to_direction(oc.direction_to_octahedron(direction))
    np.testing.assert_allclose(back, direction, atol=TOLERANCE[dtype], rtol=0)


@given(directions(), st.floats(1e-12, 1e12), dtypes)
def test_length_does_not_matter(direction: Floats, length: float, dtype: Real) -> None:
    place = oc.direction_to_octahedron(direction.astype(dtype))
    stretched = oc.direction_to_octahedron((direction * length).astype(dtype))
    back = oc.octahedron_to_direction(np.stack([place, stretched]))
    np.testing.assert_allclose(back[1], back[0], atol=TOLERANCE[dtype], rtol=0)


def test_up_is_the_middle_the_axes_the_edges_middles_and_down_the_corners() -> None:
    known = [[0, 0, 1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]
    expected = [[0.5, 0.5], [1, 0.5], [0, 0.5], [0.5, 1], [0.5, 0]]
    np.testing.assert_array_equal(oc.direction_to_octahedron(np.array(known, float)), expected)
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1]], float)
    np.testing.assert_allclose(oc.octahedron_to_direction(corners), np.tile([0, 0, -1.0], (4, 1)), atol=1e-15)
    down = oc.direction_to_octahedron(np.array([[0, 0, -1.0]]))
    assert ((down == 0) | (down == 1)).all()


def test_eight_octants_have_a_triangle_each() -> None:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    xy = oc.direction_to_octahedron(signs) * 2 - 1
    np.testing.assert_array_equal(np.sign(xy), signs[:, :2])
    np.testing.assert_allclose(np.abs(xy), np.where(signs[:, 2:] > 0, 1 / 3, 2 / 3) * np.ones(2), atol=1e-15)


def test_what_has_no_direction_stays_what_it_is() -> None:
    zeros = np.array([[0, 0, 0], [-0.0, -0.0, -0.0]])
    for none in (zeros, zeros.astype(np.float32)):
        np.testing.assert_array_equal(oc.direction_to_octahedron(none), 0.5)
    place = oc.direction_to_octahedron(np.array([[np.nan, 0, 1], [0, np.nan, -1], [0, 0, np.nan], [0, 0, 1]]))
    assert np.isnan(place[:3]).any(axis=1).all()
    assert (place[3] == 0.5).all()
    direction = oc.octahedron_to_direction(np.array([[np.nan, 0.3], [0.5, 0.5]]))
    assert np.isnan(direction[0]).any()
    np.testing.assert_array_equal(direction[1], [0, 0, 1])
    assert oc.direction_to_octahedron(np.zeros((0, 3))).shape == (0, 2)
    assert oc.octahedron_to_direction(np.zeros((5, 0, 2))).shape == (5, 0, 3)
    assert oc.sample_octahedron(np.zeros((4, 4, 3)), np.zeros((0, 2))).shape == (0, 3)


@pytest.mark.parametrize("size", [1, 2, 5, 8])
def test_a_lookup_at_a_cells_centre_is_the_cell_and_knows_its_direction(size: int) -> None:
    image = np.random.default_rng(1).random((size, size, 3))
    np.testing.assert_allclose(oc.sample_octahedron(image, centres(size)), image, atol=1e-14)
    numbers = np.arange(size * size).reshape(size, size)
    np.testing.assert_array_equal(oc.octahedron_cell(centres(size), size), numbers)
    corners = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], float)
    np.testing.assert_array_equal(oc.octahedron_cell(corners, size), numbers[[0, 0, -1, -1], [0, -1, 0, -1]])
    places, found = oc.cell_places(size), oc.cell_directions(size)
    assert places.dtype == found.dtype == np.float32
    np.testing.assert_allclose(places, centres(size).reshape(-1, 2), atol=1e-7)
    np.testing.assert_allclose(oc.direction_to_octahedron(found), places, atol=1e-6)


def test_a_lookup_of_a_smooth_picture_is_the_picture_in_every_direction() -> None:
    def picture(d: Floats) -> Floats:
        return np.stack([d[..., 0], d[..., 1] * d[..., 2], 1 + d[..., 2]], axis=-1)

    image = picture(oc.octahedron_to_direction(centres(64)))
    d = normalised(np.random.default_rng(2).normal(size=(20_000, 3)))
    found = oc.sample_octahedron(image, oc.direction_to_octahedron(d))
    error = np.abs(found - picture(d)).max(axis=1)
    assert np.median(error) < 1e-3
    assert error.max() < 0.02  # half a cell's slope, where the octahedron has its edges


@pytest.mark.parametrize("size", [1, 2, 7, 16])
def test_no_seam_anywhere_on_the_sphere(size: int) -> None:
    """Directions 1e-6 apart, over edges, corners, the equator and between: lookups as near to each other."""
    rng = np.random.default_rng(3)
    image = rng.random((size, size, 3))
    count = 20_000
    edge = rng.random((count, 2))
    edge[np.arange(count), rng.integers(0, 2, count)] = rng.integers(0, 2, count)  # x or y on 0 or 1
    starts = [
        oc.octahedron_to_direction(edge),
        np.tile([0, 0, -1.0], (count, 1)),
        normalised(rng.normal(size=(count, 3)) * [1, 1, 0]),
        normalised(rng.normal(size=(count, 3))),
    ]
    first = normalised(np.concatenate(starts) + rng.normal(size=(4 * count, 3)) * 3e-7)
    second = normalised(first + normalised(rng.normal(size=first.shape)) * 1e-6)
    ours, theirs = oc.direction_to_octahedron(first), oc.direction_to_octahedron(second)
    over = np.linalg.norm(ours - theirs, axis=1) > 0.01
    assert over[:count].mean() > 0.1, "too few pairs lie over an edge"
    assert over[count : 2 * count].mean() > 0.3, "too few pairs lie over a corner"
    difference = np.abs(oc.sample_octahedron(image, ours) - oc.sample_octahedron(image, theirs))
    assert difference.max() < 1e-5 * size


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (oc.direction_to_octahedron, (np.zeros((4, 2)),)),
        (oc.octahedron_to_direction, (np.zeros(3),)),
        (oc.octahedron_cell, (np.zeros((4, 3)), 8)),
        (oc.sample_octahedron, (np.zeros((4, 4, 3)), np.zeros((5, 3)))),
        (oc.sample_octahedron, (np.zeros((4, 9, 3)), np.zeros((5, 2)))),
        (oc.sample_octahedron, (np.zeros((4, 4)), np.zeros((5, 2)))),
    ],
)
def test_wrong_shapes_are_named(function: Callable[..., object], arguments: tuple[object, ...]) -> None:
    with pytest.raises(ShapeError, match="expected shape"):
        function(*arguments)
