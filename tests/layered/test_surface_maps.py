# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is fitted of the surface itself: diffuse light by viewer, and maps of materials and normals."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake.light_samples import EndSamples, mirrored, spread_shifts
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.fit.buckets import Parts
from radtex_addon.forms.layered.fit.diffuse import estimate_frontal, fit_falloffs
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.fit.light_map import LightMap
from radtex_addon.forms.layered.fit.texel_maps import tints
from radtex_addon.forms.layered.fit.view_dependence import view_dependence
from radtex_addon.forms.layered.lookup.lobes import falloff_at
from radtex_addon.forms.layered.samples import LayeredSamples, OwnRays
from tests.layered.made_up import flat_plan, light_samples, white_surface
from tests.layered.test_layered import CELLS, SIDE, flat_samples
from tests.layered.test_ways import stripes_below


def _dependence(strength: float) -> Floats | None:
    """Of a flat square whose noisy light gets brighter towards viewers in +X."""
    plan, rng = flat_plan(SIDE, 16), np.random.default_rng(6)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    viewer = square_to_direction(square)
    bright = (1 + strength * viewer[..., :1]) * (1 + 0.5 * rng.normal(size=(*square.shape[:2], 3)))
    surface = white_surface(plan, stripes_below(), np.ones((1, len(plan.texel), CELLS**2), np.float32))
    light = light_samples(plan, square, diffuse=bright)
    return view_dependence(light, viewer[..., 2] > 0, surface, surface.grid, CELLS)


def test_light_that_changes_with_the_viewer_is_told_by_mirror_direction_and_noise_is_not() -> None:
    assert _dependence(0.0) is None
    found = _dependence(0.4)
    assert found is not None
    axis = cell_directions(CELLS)
    above = axis[:, 2] > 0.3
    towards = -0.4 * axis[above, 0]
    told = found[:, :, above].mean(axis=1)
    slope = (told * towards).sum(axis=1) / (towards**2).sum()
    assert ((slope > 0.6) & (slope < 1.05)).all()  # a ridge keeps it below 1
    assert np.abs(told - slope[:, None] * towards).max() < 0.06


def test_a_tint_is_over_the_mean_of_its_own_material_up_to_the_border() -> None:
    plan = flat_plan(SIDE, 1)
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


def test_each_material_has_a_falloff_of_its_own() -> None:
    plan = flat_plan(SIDE, 16)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    facing = square_to_direction(square)[..., 2].astype(np.float32)
    material = (np.arange(len(plan.texel)) % 3).astype(np.int32)
    cloth, metal = (material == 1)[:, None], (material == 2)[:, None]
    bright = np.where(cloth, 2 - facing, facing)[..., None].repeat(3, axis=2).astype(np.float16)
    bright[metal[:, 0]] *= np.float16(1e-3)  # as good as none
    light = light_samples(plan, square, diffuse=bright, mirrored=metal[..., None] + 0 * bright)
    falloff, diffuse = fit_falloffs(light, facing, material)
    cosine = np.array([0.3, 0.6], np.float32)
    told = [falloff_at(falloff, np.full(2, number, np.int32), cosine)[:, 0] for number in range(3)]
    np.testing.assert_allclose(told[0], cosine, atol=0.04)
    np.testing.assert_allclose(told[1], 2 - cosine, atol=0.08)
    np.testing.assert_allclose(told[2], 1)
    np.testing.assert_allclose(diffuse[:2], 1, atol=0.08)


def test_a_light_map_goes_with_falloffs_of_more_materials_than_its_texels_have() -> None:
    light = np.array([[2, 2, 2], [np.nan] * 3], np.float32)
    traced = LightMap(light, np.full((2, 16, 3), 0.5, np.float32), np.zeros(2, bool), 1)
    found = traced.onto(np.ones((2, 3), np.float32), np.ones((3, 16, 3), np.float32), np.array([1, 0]))
    np.testing.assert_allclose(found, [[1, 1, 1], [1, 1, 1]])


def test_white_sheen_over_two_colours_leaves_both_nearly_as_bright_facing() -> None:
    """Sheen is more of what is dark: one falloff is too steep for one colour, too flat for the other."""
    plan = flat_plan(SIDE, 16)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    facing = square_to_direction(square)[..., 2].astype(np.float32)
    material = np.zeros(len(plan.texel), np.int32)
    colour = np.where(np.arange(len(plan.texel)) % 2, 0.1, 0.5).astype(np.float32)
    shown = (colour[:, None] + 0.5 * (1 - facing) ** 4)[..., None].repeat(3, axis=2).astype(np.float16)
    light = light_samples(plan, square, diffuse=shown)
    falloff, _ = fit_falloffs(light, facing, material)
    frontal = estimate_frontal(light, facing, falloff, material)[0].T
    off = (frontal / colour[:, None]).reshape(-1, 2, 3).mean(axis=(0, 2)) - 1
    assert np.abs(off).max() < 0.42  # 0.50 by least squares


@pytest.mark.parametrize("tilt", [0, 25])
def test_what_rays_meet_is_told_in_the_directions_that_they_went(tilt: float) -> None:
    """A wall stands on one side, red below and green above, whatever normal map the floor before it has."""
    plan, rays = flat_plan(SIDE, 16), flat_samples(24)
    axis = mirrored(plan, rays.square)
    hit = axis[..., 0] < 0
    met = np.full(np.count_nonzero(hit), -1, np.int32)
    above = axis[hit][:, 2] > 0.6
    light = np.stack([~above, above, 0 * above], axis=1).astype(np.float32)
    own = OwnRays(rays, hit, met, np.zeros((len(met), 3), np.float32), light)
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
    samples, one = light_samples(plan, square), np.ones((SIDE, SIDE, 3), np.float32)
    black = samples.diffuse
    alone = EndSamples(plan, square, 1 + black, mirrored(plan, square), black, black)
    angle = np.radians(tilt)
    normal = one * np.array([np.sin(angle), 0, np.cos(angle)], np.float32)
    maps = {"diffuse": one, "glossy": one, "normal": normal, "material": 0 * one[..., :1]}
    capture = LayeredSamples(
        samples, alone, own, stripes_below(), maps, maps, np.zeros(SIDE * SIDE, np.int32)
    )
    told = finished(fit_layered(capture, Parts(cells=False))).own  # samples, which are black, do not choose
    towards = cell_directions(told.shape[2]).reshape(-1, 3)
    told = told.reshape(-1, len(towards), 4)
    free, wall = towards[:, 0] > 0.2, towards[:, 0] < -0.2
    shown = (towards[:, 2] > 0.25) & (np.abs(towards[:, 2] - 0.6) > 0.15)
    assert told[:, free & shown, 3].min() > 0.97
    assert told[:, wall & shown, 3].max() < 0.03
    red, green = told[:, wall & shown & (towards[:, 2] < 0.6)], told[:, wall & shown & (towards[:, 2] > 0.6)]
    np.testing.assert_allclose(red.mean(axis=(0, 1))[:2], [1, 0], atol=0.05)
    np.testing.assert_allclose(green.mean(axis=(0, 1))[:2], [0, 1], atol=0.05)
