# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising of cells, with denoisers that are a formula."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake import denoising
from radtex_addon.bake.cells import Cells
from radtex_addon.bake.denoising import DenoisedCells, Denoiser, denoise_cells, squares
from radtex_addon.bake.hidden_cells import HiddenCells
from radtex_addon.bake.layers import Layer
from radtex_addon.bake.piece_store import MemoryStore, PieceStore
from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from tests.bake.test_session import card


def identity(light: Floats, albedo: Floats, normal: Floats) -> Floats:
    assert light.shape == albedo.shape == normal.shape
    assert light.min() >= 0
    assert 0 <= albedo.min() <= albedo.max() <= 1
    return light


def darker(light: Floats, _albedo: Floats, _normal: Floats) -> Floats:
    """Loses a tenth of the light, as a denoiser does that takes fireflies away."""
    return light * np.float32(0.9)


def smoothing(light: Floats, _albedo: Floats, _normal: Floats) -> Floats:
    """Means over 5 x 5 pixels."""
    padded = np.pad(light, ((2, 2), (2, 2), (0, 0)), mode="edge")
    height, width = light.shape[:2]
    shifted = [padded[y : y + height, x : x + width] for y in range(5) for x in range(5)]
    mean: Floats = np.mean(shifted, axis=0, dtype=np.float32)
    return mean


def captured(plan: CapturePlan, values: Floats, store: PieceStore) -> Cells:
    """Values (K, n, n, C), stored as tiles of two rows."""
    cells = Cells(plan, store, values.shape[-1])
    for row in range(0, plan.rows, 2):
        tile = Tile(row, min(2, plan.rows - row))
        cells.put(tile, values[plan.columns * row : plan.columns * tile.end])
    return cells


def random_light(plan: CapturePlan, channels: int = 4) -> Floats:
    n = plan.layout.bucket
    values = np.random.default_rng(4).gamma(2, 0.5, (len(plan.texel), n, n, channels)).astype(np.float32)
    values[..., 3] = 1
    return values


def denoised(
    plan: CapturePlan,
    values: Floats,
    denoiser: Denoiser,
    hidden: HiddenCells | None = None,
    layers: tuple[Layer, ...] = (),
) -> Floats:
    store = MemoryStore()
    steps = denoise_cells(plan, captured(plan, values, store), store, hidden, denoiser, layers)
    return finished(steps).take(np.arange(len(plan.texel)))


@pytest.fixture
def small_squares(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(denoising, "_CORE", (8, 8))
    monkeypatch.setattr(denoising, "_MARGIN", 3)
    monkeypatch.setattr(denoising, "_MOST_PIXELS", 600)


@pytest.mark.usefixtures("small_squares")
@pytest.mark.parametrize("bucket", [4, 40])
def test_what_a_denoiser_leaves_alone_stays(bucket: int) -> None:
    """Also where buckets have more cells than there are texels, and are pictures themselves."""
    plan = plan_capture(card(width=30, height=20, part=0.8), bucket)
    found = np.concatenate([square.texels[square.own] for square in squares(plan, 16)])
    assert len(list(squares(plan, 16))) > 4
    np.testing.assert_array_equal(np.sort(found), np.arange(len(plan.texel)))
    values = random_light(plan)
    values[5, 1, 2, 0] = -0.25  # a colour beyond Rec.709
    np.testing.assert_allclose(denoised(plan, values, identity), values, rtol=1e-3, atol=2e-4)


@pytest.mark.usefixtures("small_squares")
def test_lost_energy_is_given_back() -> None:
    plan = plan_capture(card(width=30, height=20, part=0.8), 4)
    values = random_light(plan)
    found = denoised(plan, values, darker)
    np.testing.assert_allclose(found[..., :3].mean(), values[..., :3].mean(), rtol=1e-4)
    np.testing.assert_array_equal(found[..., 3], 1)


def test_noise_goes_and_the_mean_of_a_bucket_stays() -> None:
    """Of layers of light and alpha too, and not of normals; hidden cells have no part in it."""
    plan = plan_capture(card(width=24, height=24), 4)
    values = random_light(plan, 13)
    found = denoised(plan, values, smoothing, layers=(Layer.DIFFUSE, Layer.GLOSSY, Layer.NORMAL))
    for light in (slice(3), slice(4, 7), slice(7, 10)):
        assert found[..., light].var() < values[..., light].var() / 8
    mean, before = found[..., :3].mean(axis=(0, 1, 2)), values[..., :3].mean(axis=(0, 1, 2))
    np.testing.assert_allclose(mean, before, rtol=0.01)
    np.testing.assert_array_equal(found[..., 10:], values[..., 10:])
    values[..., 3] = values[..., 4] < 1  # an alpha that varies is denoised as well
    alpha = denoised(plan, values, smoothing, layers=(Layer.DIFFUSE, Layer.GLOSSY, Layer.NORMAL))[..., 3]
    assert alpha.var() < values[..., 3].var() / 8
    np.testing.assert_allclose(alpha.mean(), values[..., 3].mean(), rtol=0.01)
    marks = np.zeros(values.shape[:3], dtype=bool)
    marks[::3, 1, :] = True
    hidden, values = HiddenCells.of(marks), values[..., :4]
    other = values.copy()
    other[marks] = 1e4
    seen = [denoised(plan, each, smoothing, hidden)[~marks] for each in (values, other)]
    np.testing.assert_array_equal(seen[0], seen[1])


@pytest.mark.usefixtures("small_squares")
def test_squares_that_are_stored_are_not_denoised_again() -> None:
    plan = plan_capture(card(width=30, height=20), 4)
    store = MemoryStore()
    cells = captured(plan, random_light(plan), store)
    first = finished(denoise_cells(plan, cells, store, None, smoothing))

    def never(_light: Floats, _albedo: Floats, _normal: Floats) -> Floats:
        raise AssertionError

    second: DenoisedCells = finished(denoise_cells(plan, cells, store, None, never))
    some = np.array([0, 3, 77, 78, 400])
    np.testing.assert_array_equal(first.take(some), second.take(some))
    np.testing.assert_array_equal(first.take(some), first.take(np.arange(600))[some])


def test_a_network_that_overshoots_makes_no_light_that_is_not_near() -> None:
    plan = plan_capture(card(width=24, height=24), 4)
    values = np.ones((len(plan.texel), 4, 4, 4), dtype=np.float32)
    values[plan.texel % 24 >= 12, ..., :3] = 3
    rng = np.random.default_rng(2)

    def ringing(light: Floats, _albedo: Floats, _normal: Floats) -> Floats:
        off: Floats = light * rng.uniform(0.5, 1.5, light.shape).astype(np.float32)
        return off

    found = denoised(plan, values, ringing)[..., :3]
    far = plan.texel % 24 < 11
    np.testing.assert_array_equal(found[far], 1)
    assert (float(found.min()), float(found.max())) == (1.0, 3.0)
