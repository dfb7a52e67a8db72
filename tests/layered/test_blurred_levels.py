# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The levels of a map of light are as blurred as they say."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.octahedron import direction_to_octahedron, octahedron_to_direction, sample_octahedron
from radtex_addon.forms.layered.lookup.blurred_levels import blurred_levels, level_sizes

COUNT = 4000


def directions(size: int) -> Floats:
    """Directions of an octahedral image's cells, (size², 3)."""
    middle = (np.arange(size) + 0.5) / size
    return octahedron_to_direction(np.stack(np.meshgrid(middle, middle), axis=-1)).reshape(-1, 3)


def unit(rng: np.random.Generator, count: int = COUNT) -> Floats:
    return normalised(rng.normal(size=(count, 3)))


def look(level: Floats, direction: Floats) -> Floats:
    """A level's light in directions (K, 3)."""
    return sample_octahedron(level, direction_to_octahedron(direction.astype(np.float32)))


@pytest.mark.parametrize("size", [8, 48, 100, 256])
def test_there_is_a_level_for_each_halving(size: int) -> None:
    levels, _ = blurred_levels(directions(8), np.ones((64, 3)), size)
    assert [len(level) for level in levels] == level_sizes(size, len(levels))
    assert len(levels[-1]) < 16 or size == 8
    assert all(level.dtype == np.float32 for level in levels)


def test_a_grey_world_is_grey_at_every_level() -> None:
    """Samples in every tenth cell, on average: the cells between are filled."""
    levels, _ = blurred_levels(unit(np.random.default_rng(1)), np.full((COUNT, 3), 0.7), 192)
    for level in levels:
        np.testing.assert_allclose(level, 0.7, rtol=1e-5)
    levels, _ = blurred_levels(np.zeros((0, 3)), np.zeros((0, 3)), 32)  # without samples it is black
    assert not any(level.any() for level in levels)


def test_each_level_is_blurred_by_its_own_variance() -> None:
    """A linear world loses contrast, by the mean cosine of a von Mises-Fisher lobe, and a little by cells."""
    direction = directions(256)
    levels, sharpest = blurred_levels(direction, 1 + direction, 128)
    seen = unit(np.random.default_rng(2))
    for number in range(1, len(levels)):
        variance = sharpest * 4.0**number
        cosine = 1 / np.tanh(1 / variance) - variance
        contrast = np.sum((look(levels[number], seen) - 1) * seen, axis=1).mean()
        side = 2.4 / len(levels[number])  # of a cell, in radians
        assert cosine - side**2 / 2 - 1e-3 < contrast < cosine + 1e-3


def test_the_sharpest_level_shows_what_the_samples_show() -> None:
    def world(d: Floats) -> Floats:
        return 1 + 0.5 * np.sin(6 * d)

    direction = directions(256)
    levels, _ = blurred_levels(direction, world(direction), 128)
    seen = unit(np.random.default_rng(2))
    error = np.abs(look(levels[0], seen) - world(seen))
    assert np.percentile(error, 99) < 0.01
    assert error.max() < 0.04  # half a cell's slope, where the octahedron has its edges
