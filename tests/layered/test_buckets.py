# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of cells follows from the samples: fine ones for the rest only where that pays."""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.light_samples import mirrored, spread_shifts
from radtex_addon.core.arrays import Bools
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.fit.bucket_grid import BucketGrid
from radtex_addon.forms.layered.fit.buckets import Buckets, fit_buckets
from radtex_addon.forms.layered.fit.parts import ALL_PARTS, Parts
from radtex_addon.forms.layered.fit.visibility import free_share
from radtex_addon.forms.layered.lookup.environment import Around, Pictures
from radtex_addon.forms.layered.lookup.lobes import LOBES, STEPS, Material
from radtex_addon.forms.layered.samples import OwnRays
from tests.layered.made_up import flat_plan, light_samples, white_surface
from tests.layered.test_layered import SIDE, flat_samples


def _fitted(waves: float, hit: Bools | None = None, parts: Parts = ALL_PARTS) -> Buckets:
    """Of a flat square that mirrors nothing of what is known, and shows waves over the mirror direction."""
    plan = flat_plan(SIDE, 16)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    axis = mirrored(plan, square)
    light = (1 + 0.6 * np.sin(waves * axis[..., :1]) * np.sin(waves * axis[..., 1:2])).repeat(3, axis=2)
    noise = 1 + 0.2 * np.random.default_rng(7).normal(size=light.shape)
    samples = light_samples(plan, square, mirrored=light * noise)
    rays = flat_samples(16)
    hit = np.zeros(rays.used.shape, dtype=bool) if hit is None else hit
    free = free_share(rays, hit, BucketGrid.of(plan, 1), 14)
    nothing = Material(
        np.zeros((LOBES, STEPS, 3)), np.full((LOBES, STEPS), 0.1), np.zeros(STEPS, dtype=np.float32)
    )
    direction = panorama_directions(32)
    grey = Pictures.of(direction, np.ones((*direction.shape[:2], 3)), 16)
    around = Around(np.zeros(3, np.float32), grey, (), ())
    black = np.zeros((len(plan.texel), 3), np.float32)
    surface = white_surface(plan, around, free, diffuse=black, materials=(nothing,))
    met = np.zeros(np.count_nonzero(hit), np.int32)
    own = OwnRays(rays, hit, met, np.zeros((len(met), 3), np.float32))
    return fit_buckets(surface, own, samples, samples.seen, parts)


def test_what_is_finer_than_few_cells_gets_more_of_them() -> None:
    found = _fitted(waves=9)
    assert found.rest_cells == 14
    assert found.own.shape[2] == found.free.shape[2] == 64


def test_there_is_no_choice_where_the_object_mirrors_itself_or_none_is_wanted() -> None:
    half = np.zeros((SIDE * SIDE, 256), dtype=bool)
    half[:, ::2] = True
    assert _fitted(waves=9, hit=half).rest_cells == 8
    assert _fitted(waves=9, parts=Parts(cells=False)).rest_cells == 8
