# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of cells follows from the samples: fine ones for the rest only where that pays."""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.light_samples import LightSamples, mirrored, spread_shifts
from radtex_addon.core.arrays import Bools
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.fit.bucket_grid import BucketGrid
from radtex_addon.forms.layered.fit.buckets import Buckets, fit_buckets
from radtex_addon.forms.layered.fit.own_light import Surface
from radtex_addon.forms.layered.fit.parts import ALL_PARTS, Parts
from radtex_addon.forms.layered.fit.visibility import free_share
from radtex_addon.forms.layered.lookup.environment import Around, Pictures
from radtex_addon.forms.layered.lookup.lobes import LOBES, STEPS, Material
from radtex_addon.forms.layered.samples import OwnRays
from tests.layered.test_layered import SIDE, flat_plan, flat_samples


def _fitted(waves: float, hit: Bools | None = None, parts: Parts = ALL_PARTS) -> Buckets:
    """Of a flat square that mirrors nothing of what is known, and shows waves over the mirror direction."""
    plan = flat_plan(16)
    square, count = Aim(spread_shifts(SIDE * SIDE, 3)).square(16), len(plan.texel)
    axis = mirrored(plan, square)
    light = (1 + 0.6 * np.sin(waves * axis[..., :1]) * np.sin(waves * axis[..., 1:2])).repeat(3, axis=2)
    noise = 1 + 0.2 * np.random.default_rng(7).normal(size=light.shape)
    black, one = np.zeros(light.shape, np.float16), np.ones((count, 3), np.float32)
    seen = np.ones(square.shape[:2], dtype=bool)
    samples = LightSamples(
        plan,
        square,
        seen=seen,
        diffuse=black,
        mirrored=(light * noise).astype(np.float16),
        through=black,
        colour=one,
    )
    rays = flat_samples(16)
    hit = np.zeros(rays.used.shape, dtype=bool) if hit is None else hit
    grid = BucketGrid.of(plan, 1)
    free = free_share(rays, hit, grid, 14)
    nothing = Material(
        np.zeros((LOBES, STEPS, 3)), np.full((LOBES, STEPS), 0.1), np.zeros(STEPS, dtype=np.float32)
    )
    direction = panorama_directions(32)
    around = Around(
        np.zeros(3, np.float32), Pictures.of(direction, np.ones((*direction.shape[:2], 3)), 16), (), ()
    )
    up = np.tile(np.array([0, 0, 1], np.float32), (count, 1))
    surface = Surface(
        grid,
        up,
        0 * one,
        np.ones((1, 16, 3), np.float32),
        one,
        one[:, 0],
        np.zeros(count, int),
        (nothing,),
        around,
        free,
    )
    met = np.zeros(np.count_nonzero(hit), np.int32)
    own = OwnRays(rays, hit, met, np.zeros((len(met), 3), np.float32))
    return fit_buckets(surface, own, samples, seen, parts)


def test_what_is_finer_than_few_cells_gets_more_of_them() -> None:
    found = _fitted(waves=9)
    assert found.rest_cells == 14
    assert found.own.shape[2] == found.free.shape[2] == 64


def test_there_is_no_choice_where_the_object_mirrors_itself_or_none_is_wanted() -> None:
    half = np.zeros((SIDE * SIDE, 256), dtype=bool)
    half[:, ::2] = True
    assert _fitted(waves=9, hit=half).rest_cells == 8
    assert _fitted(waves=9, parts=Parts(cells=False)).rest_cells == 8
