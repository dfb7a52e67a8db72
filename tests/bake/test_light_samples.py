# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays go and where their ends lie, against geometry that can be drawn on paper."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from radtex_addon.bake.light_samples import (
    SurroundingsSamples,
    cells_of,
    distance_along,
    joined,
    mirrored,
    panorama_plan,
    spread_shifts,
    straight_through,
)
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.core.octahedron import direction_to_octahedron, octahedron_cell

RADIUS = 2.0


def directions(count: int, seed: int = 1) -> Floats:
    return normalised(np.random.default_rng(seed).normal(size=(count, 3)))


# how far ends are


def test_a_ray_comes_by_where_it_was_sent() -> None:
    """From random points to points at known distances along random directions."""
    rng = np.random.default_rng(2)
    towards, distance = directions(500), rng.uniform(0.5, 20, 500)
    offset = rng.uniform(-0.4, 0.4, (500, 3))
    away = normalised(distance[:, None] * towards - offset)
    np.testing.assert_allclose(distance_along(towards, offset, away), distance, rtol=1e-4)


def test_parallel_rays_meet_nowhere() -> None:
    towards = directions(50)
    assert np.isinf(distance_along(towards, np.full((50, 3), 0.3), towards)).all()


def test_a_ray_that_comes_by_behind_is_infinitely_far() -> None:
    towards = np.array([[1.0, 0, 0]])
    assert np.isinf(distance_along(towards, np.array([[0.0, 0, 1]]), np.array([[-0.6, 0, -0.8]]))).all()


# the panorama


def nearby(direction: Floats, nearness: Floats) -> SurroundingsSamples:
    return SurroundingsSamples(np.zeros(3), direction, np.ones((len(direction), 3)), nearness)


def test_a_panorama_looks_everywhere_once_and_outwards() -> None:
    middle = np.array([1.0, -2, 3])
    plan = panorama_plan(nearby(directions(10), np.zeros(10)), middle, RADIUS, 8, 4)
    assert (plan.layout.width, plan.layout.height, plan.layout.bucket) == (16, 16, 1)
    start, normal = (field.reshape(-1, 3).astype(float) for field in (plan.position, plan.normal))
    assert len(plan.texel) == len(start) == 8 * 8 * 4
    cell = octahedron_cell(direction_to_octahedron(normal.astype(np.float32)), 8)
    assert (np.bincount(cell, minlength=64) == 4).all()
    np.testing.assert_allclose(start - middle, RADIUS * normal, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-5)


def test_a_panorama_starts_before_what_is_near_but_never_farther_out_than_need_be() -> None:
    up = np.array([[0.0, 0, 1], [0, 0, -1]])
    plan = panorama_plan(nearby(up, 1 / np.array([0.5, 50.0])), np.zeros(3), RADIUS, 64, 1)
    start, normal = (field.reshape(-1, 3).astype(float) for field in (plan.position, plan.normal))
    along = np.linalg.norm(start, axis=1)
    at_top = octahedron_cell(direction_to_octahedron(normal), 64) == octahedron_cell(
        direction_to_octahedron(up[:1]), 64
    )
    assert at_top.sum() == 1
    np.testing.assert_allclose(along[at_top], 0.95 * 0.5, rtol=1e-5)
    np.testing.assert_allclose(along[~at_top], RADIUS, rtol=1e-5)


def test_a_panorama_needs_nothing_near() -> None:
    nothing = nearby(np.zeros((0, 3)), np.zeros(0))
    plan = panorama_plan(nothing, np.zeros(3), RADIUS, 4, 1)
    np.testing.assert_allclose(np.linalg.norm(plan.position, axis=-1), RADIUS, rtol=1e-5)


def test_joined_samples_are_both() -> None:
    first, second = nearby(directions(3), np.ones(3)), nearby(directions(4, seed=9), np.zeros(4))
    both = joined(first, second)
    np.testing.assert_array_equal(both.direction, np.concatenate([first.direction, second.direction]))
    np.testing.assert_array_equal(both.nearness, [1, 1, 1, 0, 0, 0, 0])
    assert both.radiance.shape == (7, 3)


# aims


@pytest.fixture
def tilted() -> CapturePlan:
    """One texel, its frame turned anyhow."""
    t, b, n = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    return CapturePlan(
        AtlasLayout(1, 1, 8), np.array([0]), *(axis.reshape(1, 1, 3) for axis in (np.zeros(3), t, b, n, n))
    )


def test_mirror_directions_obey_the_law_of_reflection(tilted: CapturePlan) -> None:
    square = cell_centres(8).reshape(1, -1, 2)
    frame = np.stack([tilted.tangent, tilted.bitangent, tilted.normal]).reshape(3, 3)
    viewer = square_to_direction(square) @ frame
    normal = frame[2]
    expected = 2 * (viewer @ normal)[..., None] * normal - viewer
    np.testing.assert_allclose(mirrored(tilted, square), expected, atol=1e-6)
    np.testing.assert_allclose(straight_through(tilted, square), -viewer, atol=1e-6)


@pytest.mark.parametrize("towards", [mirrored, straight_through])
def test_some_texels_directions_are_those_of_all(towards: Callable[..., Floats]) -> None:
    rng = np.random.default_rng(5)
    frames = np.linalg.qr(rng.normal(size=(6, 3, 3)))[0].reshape(2, 3, 3, 3)
    t, b, n = np.moveaxis(frames, 2, 0)
    plan = CapturePlan(AtlasLayout(5, 1, 8), np.arange(5), np.zeros((2, 3, 3)), t, b, n, n)
    square = rng.uniform(-1, 1, (5, 7, 2))
    some = slice(1, 4)
    np.testing.assert_array_equal(towards(plan, square[some], some), towards(plan, square)[some])


def test_the_cell_of_a_cells_middle_is_its_own() -> None:
    square = cell_centres(6).reshape(1, -1, 2)
    assert cells_of(square, 6).tolist() == [list(range(36))]
    assert cells_of(np.array([[[1.0, 1.0], [-1.0, 1.0]]]), 6).tolist() == [[35, 30]]


def test_shifts_do_not_depend_on_how_many_follow() -> None:
    assert (spread_shifts(10, 4) == spread_shifts(100, 4)[:10]).all()


def test_shifts_fill_the_cell_evenly() -> None:
    shifts = spread_shifts(1000, 7)
    assert ((shifts >= 0) & (shifts < 1)).all()
    quarters = np.floor(shifts * 2) @ [1, 2]
    np.testing.assert_allclose(np.bincount(quarters.astype(int)), 250, atol=10)
