# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Buckets of several texels: summed, pooled and looked up as single ones are; finer cells where that pays."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake import blocks
from radtex_addon.bake.computed_rows import computed
from radtex_addon.bake.light_samples import mirrored, spread_shifts
from radtex_addon.bake.pooling import Taps
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.capture.capturing import without_zeros
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.fit import bucket_grid
from radtex_addon.forms.layered.fit.bucket_grid import Block, BucketGrid
from radtex_addon.forms.layered.fit.buckets import ALL_PARTS, FittedBuckets, Parts, fit_buckets, free_share
from radtex_addon.forms.layered.fit.own_light import OwnLight
from radtex_addon.forms.layered.fit.rows import halved, random_half
from radtex_addon.forms.layered.fit.view_dependence import fit_harmonics
from radtex_addon.forms.layered.lookup.environment import Around, Pictures
from radtex_addon.forms.layered.lookup.lobes import LOBES, STEPS, Material
from radtex_addon.forms.layered.samples import OwnRays
from radtex_addon.settings.rays import OWN_RAYS, OWN_SIDE, own_side
from tests.layered.made_up import flat_plan, light_samples, places_of, white_surface
from tests.layered.test_layered import SIDE, flat_samples


def _fitted(
    waves: float,
    hit: Bools | None = None,
    parts: Parts = ALL_PARTS,
    each: Floats | None = None,
    texels: int = 1,
    sharp: Bools | None = None,
) -> FittedBuckets:
    """Of a flat square that mirrors nothing of what is known, and shows waves over the mirror direction.

    `each` (SIDE²,): what its texels' light is multiplied by. `texels` x `texels` of them share a bucket.
    Those that are `sharp` (SIDE²,) have a material of their own, and finer waves.
    """
    plan = flat_plan(SIDE, 16)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    axis = mirrored(plan, square)
    sharp = np.zeros(SIDE * SIDE, dtype=bool) if sharp is None else sharp
    turn = np.where(sharp, 9, waves)[:, None, None] * axis
    light = (1 + 0.6 * np.sin(turn[..., :1]) * np.sin(turn[..., 1:2])).repeat(3, axis=2)
    noise = 1 + 0.2 * np.random.default_rng(7).normal(size=light.shape)
    by_texel = 1 if each is None else each[:, None, None]
    samples = light_samples(plan, square, mirrored=light * noise * by_texel)
    rays = flat_samples(16)
    hit = np.zeros(rays.used.shape, dtype=bool) if hit is None else hit
    grid = BucketGrid.of(plan, texels)
    free = free_share(rays, hit, grid, 14)
    nothing = Material(
        np.zeros((LOBES, STEPS, 3)), np.full((LOBES, STEPS), 0.1), np.zeros(STEPS, dtype=np.float32)
    )
    direction = panorama_directions(32)
    grey = Pictures.of(direction, np.ones((*direction.shape[:2], 3)), 16)
    around = Around(np.zeros(3, np.float32), grey, (), ())
    black = np.zeros((len(plan.texel), 3), np.float32)
    surface = white_surface(plan, around, free, diffuse=black, materials=(nothing, nothing))
    surface = replace(surface, grid=grid, material=sharp.astype(surface.material.dtype))
    met = np.zeros(np.count_nonzero(hit), np.int32)
    own = OwnRays(rays, hit, met, np.zeros((len(met), 3), np.float32))
    return fit_buckets(surface, own, samples, samples.seen, parts)


def _each(number: int) -> Bools:
    """Hits: one in so many rays."""
    hit: Bools = (np.arange(SIDE * SIDE * 256) % number == 0).reshape(SIDE * SIDE, 256)
    return hit


def test_what_is_finer_than_few_cells_gets_more_of_them() -> None:
    found = _fitted(waves=9, hit=_each(20))
    assert found.rest_cells == 14
    assert found.own.shape[2] == found.free.shape[2] == 64


@pytest.mark.parametrize("hit", [None, 100])
def test_what_is_shown_as_well_without_its_own_light_has_none(hit: int | None) -> None:
    found = _fitted(waves=9, hit=None if hit is None else _each(hit))
    assert found.rest_cells == 14
    assert found.own.shape[2] == found.free.shape[2] == 4
    assert not found.own.any()
    assert (found.free == 1).all()


def test_an_object_that_mirrors_much_of_itself_has_a_choice_too_unless_none_is_wanted() -> None:
    half = np.zeros((SIDE * SIDE, 256), dtype=bool)
    half[:, ::2] = True
    assert _fitted(waves=9, hit=half).rest_cells == 14
    assert _fitted(waves=9, hit=half, parts=Parts(cells=False)).rest_cells == 8


def test_what_changes_within_few_texels_has_a_rest_at_each() -> None:
    waves = 1 + 0.8 * np.sin(2 * np.pi * (np.arange(SIDE * SIDE) % SIDE) / 5)
    found = _fitted(waves=1, hit=_each(20), each=waves, texels=2)
    assert found.rest.shape == (3, SIDE * SIDE, 64)
    assert not found.own.any(), "what it shows of itself is in the rest, too"
    assert np.corrcoef(found.rest.mean(axis=(0, 2)), waves)[0, 1] > 0.9
    assert _fitted(waves=9, hit=_each(20), texels=2).rest.shape == (3, (SIDE // 2) ** 2, 14**2)


def test_a_mirror_among_what_changes_within_few_texels_keeps_its_cells() -> None:
    place = np.arange(SIDE * SIDE)
    waves = 1 + 0.8 * np.sin(2 * np.pi * (place % SIDE) / 5)
    sharp = place >= SIDE * (SIDE - 2)
    waves[sharp] = 1
    by_four, every = (SIDE // 2) ** 2, SIDE**2
    assert _fitted(waves=1, hit=_each(20), each=waves, texels=2).rest.shape[1] == every
    assert _fitted(waves=1, hit=_each(20), each=waves, texels=2, sharp=sharp).rest.shape[1] == by_four


CELLS, SAMPLES = 6, 32


def _sums(grid: BucketGrid, place: Floats, column: Floats) -> Floats:
    def sum_up(block: Block) -> Floats:
        return block.scatter(place[:, block.texels], CELLS, [column[block.texels]])

    return np.concatenate(grid.in_blocks(sum_up, SAMPLES, at_once=300), axis=1)


def test_a_bucket_sums_the_samples_of_its_texels() -> None:
    plan, rng = flat_plan(SIDE, 16), np.random.default_rng(1)
    place = rng.random((2, SIDE * SIDE, SAMPLES)).astype(np.float32)
    column = rng.random(place.shape[1:]).astype(np.float32)
    single = Taps.of(place, CELLS).scatter([column]).reshape(SIDE, SIDE, -1)
    expected = single.reshape(SIDE // 2, 2, SIDE // 2, 2, -1).sum(axis=(1, 3)).reshape(-1, CELLS**2)
    grid = BucketGrid.of(plan, 2)
    np.testing.assert_allclose(_sums(grid, place, column)[0], expected, rtol=1e-4, atol=1e-5)
    image = grid.placed(expected[None].astype(np.float32), 2 * expected[None].astype(np.float32))
    assert image.shape == (SIDE // 2, SIDE // 2, CELLS, CELLS, 2)
    np.testing.assert_allclose(image[3, 5].reshape(-1, 2)[:, 1], 2 * expected[3 * SIDE // 2 + 5], rtol=1e-6)


def test_samples_look_up_the_bucket_of_their_texel() -> None:
    plan, rng = flat_plan(SIDE, 16), np.random.default_rng(2)
    place = rng.random((2, SIDE * SIDE, SAMPLES)).astype(np.float32)
    grid = BucketGrid.of(plan, 2)
    table = rng.random((2, len(grid), CELLS**2)).astype(np.float32)
    expected = Taps.of(place, CELLS).gather(table[:, grid.bucket])
    np.testing.assert_allclose(grid.gather(table, place, slice(None)), expected, rtol=1e-6)
    some = np.array([7, 3, 100])
    np.testing.assert_allclose(grid.gather(table, place[:, some], some), expected[:, some], rtol=1e-6)


def test_what_pooling_leaves_of_noise_is_known() -> None:
    grid = BucketGrid.of(flat_plan(SIDE, 16), 2)
    each = np.eye(len(grid), dtype=np.float32)[:, :, None]
    side = SIDE // 2
    middle = side // 2 * side + side // 2
    weights = grid.neighbours.pool(each)[:, middle, 0]
    np.testing.assert_allclose(weights.sum(), 1, atol=1e-4)
    np.testing.assert_allclose((weights**2).sum(), grid.share(wide=False), rtol=1e-3)
    assert grid.share(wide=True) < grid.share(wide=False) / 10


def test_cells_are_pooled_a_few_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = BucketGrid.of(flat_plan(SIDE, 16), 2)
    table = np.random.default_rng(3).random((2, len(grid), CELLS**2)).astype(np.float32)

    def mean(own: Floats, pooled: Floats) -> Floats:
        found: Floats = own[:1] + pooled[1:]
        return found

    expected = mean(table, grid.neighbours.pool(table))
    monkeypatch.setattr(bucket_grid, "_POOLED_AT_ONCE", table.nbytes // 5)
    np.testing.assert_allclose(grid.pool(table.copy(), grid.neighbours.pool, mean), expected, rtol=1e-6)


def test_rays_to_the_object_itself_are_bounded() -> None:
    assert own_side(1) == own_side(OWN_RAYS // OWN_SIDE**2) == OWN_SIDE
    for texels in (75_000, 150_000, 400_000):
        assert 0.8 * OWN_RAYS < texels * own_side(texels) ** 2 <= OWN_RAYS
    assert own_side(10**9) ** 2 >= 25


def test_small_arrays_hold_what_is_read_from_them() -> None:
    values = np.random.default_rng(4).random((2, 5, SAMPLES)).astype(np.float32)
    np.testing.assert_allclose(places_of(values)[1:3], values[:, 1:3], atol=1e-5)
    assert np.isfinite(halved(np.array([1e9, -1e9]))).all()
    rows = computed((5, 2), lambda some: np.arange(10).reshape(5, 2)[some] * 1.0)
    assert rows.shape == (5, 2)
    assert len(rows) == 5
    np.testing.assert_array_equal(rows[2:4], [[4, 5], [6, 7]])
    half = random_half((1000, SAMPLES), 1)
    assert 0.45 < half.mean() < 0.55
    np.testing.assert_array_equal(half, np.random.default_rng(1).random((1000, SAMPLES)) < 0.5)
    nothing, something = np.zeros((4, 3), np.float16), np.ones((4, 3), np.float16)
    assert without_zeros(nothing).strides == (0, 0)
    assert without_zeros(something) is something


def test_buckets_without_samples_have_no_harmonics() -> None:
    grid = BucketGrid.of(flat_plan(SIDE, 16), 2)
    shape = (SIDE * SIDE, SAMPLES)
    direction = np.broadcast_to(np.array([0, 0, 1], np.float32), (*shape, 3))
    found = fit_harmonics(direction, np.ones((*shape, 3)), np.zeros(shape, np.float32), grid, 0.03)
    np.testing.assert_array_equal(found, np.zeros((len(grid), 9, 3)))


def test_few_rays_of_many_texels_are_summed_in_little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blocks, "THREADS", 2)
    plan = flat_plan(128, 16)
    grid = BucketGrid.of(plan, 2)
    count = np.zeros(len(plan.texel), dtype=np.int64)
    count[::100] = 1
    rays = int(count.sum())
    place = places_of(np.full((2, rays), 0.3, np.float32))
    own = OwnLight(
        np.cumsum(count) - count, count, place, np.ones(rays, np.float32), np.ones((3, rays), np.float32)
    )
    tracemalloc.start()
    try:
        shown = own.buckets(grid, 14)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    print(f"\n{peak >> 20} MiB")
    assert shown.shape == (3, len(grid), 14 * 14)
    assert peak < 12 * shown.nbytes
