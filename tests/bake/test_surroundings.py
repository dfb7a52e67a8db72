# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surroundings' levels are as blurred as they say, and rays find what stands around the object."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.bake.light_samples import SurroundingsSamples
from radtex_addon.bake.surroundings import NEARNESS_SIZE, Surroundings, meet_surroundings, nearness_map
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.octahedron import octahedron_to_direction
from radtex_addon.core.shared import level_sizes, sample_surroundings

COUNT = 4000
FAR = 100.0


def directions(size: int) -> Floats:
    """Directions of an octahedral image's cells, (size², 3)."""
    middle = (np.arange(size) + 0.5) / size
    return octahedron_to_direction(np.stack(np.meshgrid(middle, middle), axis=-1)).reshape(-1, 3)


def samples(direction: Floats, radiance: Floats, nearness: float | Floats = 0.0) -> SurroundingsSamples:
    near = np.broadcast_to(nearness, len(direction))
    parts = (np.zeros(3), direction, radiance, near)
    return SurroundingsSamples(*(part.astype(np.float32) for part in parts))


def unit(rng: np.random.Generator, count: int = COUNT) -> Floats:
    return normalised(rng.normal(size=(count, 3)))


def on_the_sphere(position: Floats, direction: Floats, radius: float) -> Floats:
    """Unit vectors to where rays from positions inside cut a sphere around the origin."""
    along = np.sum(position * direction, axis=1)
    length = np.sqrt(along**2 - np.sum(position**2, axis=1) + radius**2) - along
    cut: Floats = (position + length[:, None] * direction) / radius
    return cut


@pytest.mark.parametrize("size", [8, 48, 100, 256])
def test_there_is_a_level_for_each_halving(size: int) -> None:
    around = Surroundings.of(samples(directions(8), np.ones((64, 3))), size)
    count = len(around.levels)
    assert [len(level) for level in around.levels] == level_sizes(size, count)
    assert len(around.levels[-1]) < 16 or size == 8
    assert all(level.dtype == np.float32 for level in around.levels)


def test_a_grey_world_is_grey_at_every_level() -> None:
    """Samples in every tenth cell, on average: the cells between are filled."""
    light = np.full((COUNT, 3), 0.7)
    around = Surroundings.of(samples(unit(np.random.default_rng(1)), light), 192)
    for level in around.levels:
        np.testing.assert_allclose(level, 0.7, rtol=1e-5)


def test_no_samples_are_a_black_world() -> None:
    none = np.zeros((0, 3))
    around = Surroundings.of(samples(none, none), 32)
    assert not any(level.any() for level in around.levels)


def test_each_level_is_blurred_by_its_own_variance() -> None:
    """A linear world loses contrast, by the mean cosine of a von Mises-Fisher lobe, and a little by cells."""
    direction = directions(256)
    around = Surroundings.of(samples(direction, 1 + direction), 128)
    seen = unit(np.random.default_rng(2))
    for number in range(1, len(around.levels)):
        variance = around.sharpest * 4.0**number
        cosine = 1 / np.tanh(1 / variance) - variance
        found = around.look(seen, np.full(COUNT, variance))
        contrast = np.sum((found - 1) * seen, axis=1).mean()
        side = 2.4 / len(around.levels[number])  # of a cell, in radians
        assert cosine - side**2 / 2 - 1e-3 < contrast < cosine + 1e-3


def test_the_sharpest_level_shows_what_the_samples_show() -> None:
    def world(d: Floats) -> Floats:
        return 1 + 0.5 * np.sin(6 * d)

    direction = directions(256)
    around = Surroundings.of(samples(direction, world(direction)), 128)
    seen = unit(np.random.default_rng(2))
    error = np.abs(around.look(seen, np.zeros(COUNT)) - world(seen))
    assert np.percentile(error, 99) < 0.01
    assert error.max() < 0.04  # half a cell's slope, where the octahedron has its edges


def test_a_look_is_as_the_shared_layout_has_it() -> None:
    rng = np.random.default_rng(8)
    for size in (8, 100):
        around = Surroundings.of(samples(unit(rng), rng.random((COUNT, 3))), size)
        seen, spread = unit(rng) * rng.uniform(0.1, 3, (COUNT, 1)), 10 ** rng.uniform(-9, 3, COUNT)
        spread[:10] = 0
        expected = sample_surroundings(around.levels, around.sharpest, seen, spread)
        np.testing.assert_allclose(around.look(seen, spread), expected, rtol=1e-4, atol=1e-6)


@given(st.floats(1.05, 100), st.floats(-4, 4), st.integers(0, 2**32 - 1))
def test_a_sphere_is_met_exactly_at_any_scale(radius: float, magnitude: float, seed: int) -> None:
    rng, unit_of_length = np.random.default_rng(seed), 10**magnitude
    middle = unit(rng, 1)[0] * unit_of_length
    position, direction = unit(rng, 200) * rng.random((200, 1)), unit(rng, 200)
    nearness = np.full((16, 16), 1 / (radius * unit_of_length), dtype=np.float32)
    found = meet_surroundings(nearness, middle, middle + position * unit_of_length, direction)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(found, on_the_sphere(position, direction, radius), atol=1e-4)


def test_a_floor_is_met_within_a_degree() -> None:
    rng = np.random.default_rng(5)
    depth, middle = 1.5, np.array([4, 5, 6.0])
    nearness = np.maximum(-directions(64)[:, 2] / depth, 1e-3).astype(np.float32).reshape(64, 64)
    position, direction = unit(rng), unit(rng)
    direction[:, 2] = -np.abs(direction[:, 2])
    seen = (np.sum(position * direction, axis=1) > 0) & (direction[:, 2] < -0.2)
    position, direction = position[seen], direction[seen]
    meeting = normalised(position + (-depth - position[:, 2:]) / direction[:, 2:] * direction)
    found = meet_surroundings(nearness, middle, middle + position, direction)
    error = np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(found - meeting, axis=1) / 2, 0, 1)))
    assert np.median(error) < 0.1
    assert np.percentile(error, 99) < 1


def test_rays_that_pass_what_is_there_still_point_somewhere() -> None:
    """Outside the sphere there may be no cut at all: the ray's nearest place to the middle is taken."""
    rng = np.random.default_rng(6)
    position, direction = unit(rng) * 3, unit(rng)
    found = meet_surroundings(np.ones((8, 8), dtype=np.float32), np.zeros(3), position, direction)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-6)
    passing = np.sum(position**2, axis=1) - np.sum(position * direction, axis=1) ** 2 > 1.01
    across = np.abs(np.sum(found * direction, axis=1))[passing]
    assert across.max() < 1e-4


def test_nearness_is_the_median_of_what_was_met() -> None:
    """A tenth of the rays has met something else, nearer."""
    direction = np.repeat(directions(NEARNESS_SIZE), 32, axis=0)
    astray = np.random.default_rng(4).random(len(direction)) < 0.1
    nearness = nearness_map(samples(direction, direction, np.where(astray, 2, 1) / 2.5), FAR)
    assert nearness.shape == (NEARNESS_SIZE, NEARNESS_SIZE)
    np.testing.assert_allclose(1 / nearness, 2.5, rtol=1e-5)


def test_where_nothing_is_near_the_world_is_far() -> None:
    none = np.zeros((0, 3))
    for seen in (samples(none, none), samples(directions(8), directions(8))):
        np.testing.assert_allclose(nearness_map(seen, FAR), 1 / FAR, rtol=1e-6)
