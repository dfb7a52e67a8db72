# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches take every triangle once, bring what is around it, and stay small."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.patches import patches


def grid(side: int) -> tuple[Ints, Floats]:
    """A sheet of 2 side² triangles in no order, and their middles."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    corner = (y * (side + 1) + x).ravel()
    lower = np.stack([corner, corner + 1, corner + side + 1], axis=1)
    upper = np.stack([corner + 1, corner + side + 2, corner + side + 1], axis=1)
    triangles = np.random.default_rng(1).permutation(np.concatenate([lower, upper]))
    place = np.stack([triangles % (side + 1), triangles // (side + 1), 0 * triangles], axis=-1).mean(axis=1)
    return triangles, place


@pytest.mark.parametrize("most", [40, 300, 10_000])
def test_each_triangle_is_one_patchs_own_and_has_its_neighbours(most: int) -> None:
    triangles, place = grid(20)
    found = list(patches(triangles, place, most))
    assert sorted(np.concatenate([own for own, _ in found])) == list(range(len(triangles)))
    for own, whole in found:
        around = np.isin(triangles, triangles[own]).any(axis=1)
        assert np.array_equal(whole, np.flatnonzero(around))
        assert len(whole) <= most
    assert (len(found) == 1) == (most >= len(triangles))


def test_a_fan_is_not_cut_to_bits() -> None:
    count = 1000
    rim = np.arange(count)
    fan = np.stack([np.full(count, count), rim, (rim + 1) % count], axis=1)
    angle = 2 * np.pi * rim / count
    place = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    found = list(patches(fan, place, 320))
    assert len(found) <= 2 * count / (320 / 16)
    assert all(len(whole) == count for _, whole in found)
