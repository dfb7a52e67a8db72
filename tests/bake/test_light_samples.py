# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays go, against geometry that can be drawn on paper."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from radtex_addon.bake.light_samples import (
    cells_of,
    mirrored,
    spread_shifts,
    straight_through,
)
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.hemisphere import cell_centres, square_to_direction


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


def test_shifts_fill_the_cell_evenly() -> None:
    shifts = spread_shifts(1000, 7)
    assert (spread_shifts(10, 7) == shifts[:10]).all()  # however many follow
    assert ((shifts >= 0) & (shifts < 1)).all()
    quarters = np.floor(shifts * 2) @ [1, 2]
    np.testing.assert_allclose(np.bincount(quarters.astype(int)), 250, atol=10)
