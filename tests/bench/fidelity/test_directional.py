# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits of functions of direction, against light that is known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.octahedron import cell_directions
from tests.bench.fidelity.directional import (
    fitted_equations,
    gaussians,
    harmonics,
    lobe_axes,
    solve_with_ridge,
)
from tests.bench.fidelity.methods.sg import LOBES, fit_gaussians

_SIDE = 3  # texels along a side of a flat square
_AXES = lobe_axes(LOBES)


@pytest.fixture(scope="module")
def plan() -> CapturePlan:
    x, y = np.meshgrid(np.arange(_SIDE), np.arange(_SIDE))
    place = np.stack([x, y, np.zeros_like(x)], axis=-1).astype(np.float32)
    axes = [np.broadcast_to(np.eye(3, dtype=np.float32)[k], place.shape) for k in (0, 1, 2, 2)]
    return CapturePlan(AtlasLayout(_SIDE, _SIDE, 1), np.arange(_SIDE**2), place, *axes)


def _directions() -> Floats:
    """Evenly spread directions of the hemisphere, the same for each texel, (K, S, 3)."""
    count = 800
    z = (np.arange(count) + 0.5) / count
    turn = np.arange(count) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z * z)
    one = np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1).astype(np.float32)
    # neighbours in the list must not be neighbours on the sphere, as halves are every second one
    mixed = np.random.default_rng(1).permutation(one)
    return np.broadcast_to(mixed, (_SIDE**2, count, 3))


def _even(direction: Floats) -> Floats:
    return np.full(direction.shape[:2], 1 / direction.shape[1], dtype=np.float32)


def test_a_sum_of_gaussians_comes_back_with_its_sharpness(plan: CapturePlan) -> None:
    direction = _directions()
    amplitude = np.random.default_rng(2).uniform(0, 1, (LOBES, 3))
    amplitude[::3] = 0  # lobes without light stay without
    values = (gaussians(direction, _AXES, 8.0) @ amplitude).astype(np.float32)
    sharpness, fitted = fit_gaussians(plan, direction, values, _even(direction))
    assert sharpness == 8.0
    assert fitted.min() >= 0
    assert fitted == pytest.approx(np.broadcast_to(amplitude, fitted.shape), abs=0.06)  # the ridge's pull
    shown = gaussians(direction, _AXES, sharpness) @ fitted
    assert shown == pytest.approx(values, abs=0.03)


def test_gaussians_keep_the_energy_of_even_light(plan: CapturePlan) -> None:
    direction = _directions()
    values = np.ones_like(direction) * np.array([1.0, 0.5, 0.0], dtype=np.float32)
    sharpness, fitted = fit_gaussians(plan, direction, values, _even(direction))
    shown = gaussians(direction, _AXES, sharpness) @ fitted
    assert shown.mean(axis=(0, 1)) == pytest.approx([1.0, 0.5, 0.0], rel=0.02, abs=1e-6)
    assert shown[..., 0].min() > 0.7  # lobes leave no holes between them; at the rim they end


@pytest.mark.parametrize("bands", [2, 3])
def test_harmonics_are_orthonormal_on_the_sphere(bands: int) -> None:
    rng = np.random.default_rng(3)
    direction = rng.normal(size=(400_000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    columns = harmonics(direction, bands)
    products = 4 * np.pi * columns.T @ columns / len(columns)
    assert products == pytest.approx(np.eye((bands + 1) ** 2), abs=0.02)


def test_what_harmonics_can_tell_comes_back(plan: CapturePlan) -> None:
    direction = _directions()
    coefficients = np.random.default_rng(4).normal(size=(16, 3))
    values = harmonics(direction, 3) @ coefficients
    equations = fitted_equations(plan, direction, values, _even(direction), lambda d: harmonics(d, 3))
    shown = harmonics(direction, 3) @ solve_with_ridge(equations, [0.0] * 16)
    assert shown == pytest.approx(values, abs=0.01 * np.abs(values).max())


def test_lobes_are_spread_over_the_hemisphere() -> None:
    axes = lobe_axes(LOBES)
    assert np.linalg.norm(axes, axis=1) == pytest.approx(np.ones(LOBES))
    assert axes[:, 2].min() > 0
    upper = cell_directions(32)
    upper = upper[upper[:, 2] > 0]
    assert (upper @ axes.T).max(axis=1).min() > np.cos(np.radians(50))  # none is far from every lobe
