# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is fitted of the surface itself: diffuse light by viewer, and maps of materials that meet."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake.light_samples import LightSamples, spread_shifts
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.cycles.portal import Aim
from tests.bench.fidelity.layered.test_layered import CELLS, SIDE, flat_plan
from tests.bench.fidelity.layered.texel_maps import tints
from tests.bench.fidelity.layered.view_dependence import view_dependence

pytestmark = pytest.mark.one_blender


def _dependence(strength: float) -> Floats | None:
    """Of a flat square whose noisy light gets brighter towards viewers in +X."""
    plan, rng = flat_plan(16), np.random.default_rng(6)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    viewer = square_to_direction(square)
    bright = (1 + strength * viewer[..., :1]) * (1 + 0.5 * rng.normal(size=(*square.shape[:2], 3)))
    black = np.zeros(bright.shape, dtype=np.float16)
    colour, seen = np.ones((len(plan.texel), 3), np.float32), np.ones(square.shape[:2], dtype=bool)
    light = LightSamples(
        plan,
        square,
        seen=seen,
        diffuse=bright.astype(np.float16),
        mirrored=black,
        through=black,
        colour=colour,
    )
    facing = viewer[..., 2].astype(np.float32)
    up = np.tile(np.array([0, 0, 1], np.float32), (len(plan.texel), 1))
    neighbours = Neighbours(plan, False)
    return view_dependence(light, facing, colour, np.ones((16, 3), np.float32), up, CELLS, neighbours)


def test_light_that_changes_with_the_viewer_is_told_by_mirror_direction() -> None:
    found = _dependence(0.4)
    assert found is not None
    axis = cell_directions(CELLS)
    above = axis[:, 2] > 0.3
    towards = -0.4 * axis[above, 0]
    told = found[:, :, above].mean(axis=1)
    slope = (told * towards).sum(axis=1) / (towards**2).sum()
    assert ((slope > 0.6) & (slope < 1.05)).all()  # a ridge keeps it below 1
    assert np.abs(told - slope[:, None] * towards).max() < 0.06


def test_noise_alone_is_no_dependence_on_the_viewer() -> None:
    assert _dependence(0.0) is None


def test_a_tint_is_over_the_mean_of_its_own_material_up_to_the_border() -> None:
    plan = flat_plan(1)
    dark, bright = np.array([0.1, 0.1, 0.1]), np.array([0.9, 0.6, 0.3])
    column = np.arange(SIDE * SIDE) % SIDE
    material = (column >= SIDE // 2).astype(np.int32)
    varied = np.where(column % 2, 1.2, 0.8)[:, None]
    coarse = (np.where(material[:, None], bright, dark) * varied).reshape(SIDE, SIDE, 3)
    fine = coarse.repeat(4, axis=0).repeat(4, axis=1)
    owner = material.reshape(SIDE, SIDE, 1).repeat(4, axis=0).repeat(4, axis=1)
    border = 4 * (SIDE // 2)
    fine[:, border - 1], owner[:, border - 1] = bright, 1  # the border is not a coarse texel's
    maps = {"glossy": fine.astype(np.float32), "material": owner.astype(np.float32)}
    _, found = tints(plan, material, maps, {"glossy": coarse.astype(np.float32)}, True)
    assert found is not None
    np.testing.assert_allclose(found[:, border - 1], 1, rtol=1e-3)
    assert found.max() < 1.3
