# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface emits is told with its diffuse light, as finely as its colour."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from radtex_addon.bake.light_samples import LightSamples, spread_shifts
from radtex_addon.bake.plan import plan_of_picked
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.sampler import bilinear
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.fit.glow import Glow, fit_glow
from radtex_addon.forms.layered.lookup.lobes import falloff_at
from radtex_addon.forms.layered.samples import LayeredSamples
from tests.layered.made_up import flat_plan, light_samples

SIDE, FINER = 12, 4
PLAN = flat_plan(SIDE, 16)
SQUARE = Aim(spread_shifts(SIDE * SIDE, 3)).square(16)
COSINE = square_to_direction(SQUARE)[..., 2].astype(np.float32)
COLOUR = (0.2, 0.6, 0.0)  # of what is emitted


def _fine(values: Floats) -> Floats:
    """A map of texels (K, 3) as fine as the colours: (H', W', 3)."""
    image = values.reshape(SIDE, SIDE, 3)
    return image.repeat(FINER, axis=0).repeat(FINER, axis=1).astype(np.float32)


def _emitting(curve: Floats, pattern: Floats, diffuse: float = 0.0) -> LayeredSamples:
    """A surface that emits a pattern (K,) times a curve of N.V (K, S), on top of its diffuse light."""
    emitted = pattern[:, None, None] * curve[..., None] * np.array(COLOUR)
    light: LightSamples = light_samples(
        PLAN, SQUARE, diffuse=np.full_like(emitted, diffuse), mirrored=emitted + 0.1
    )
    light = replace(light, emitted=emitted.astype(np.float16))
    nearest = COSINE.argmax(axis=1)
    along = emitted[np.arange(len(emitted)), nearest]
    maps = {"emission": _fine(along), "diffuse": _fine(along * 0), "material": _fine(along * 0)[..., :1]}
    coarse = {"emission": along.reshape(SIDE, SIDE, 3).astype(np.float32)}
    material = np.zeros(len(along), np.int32)
    return LayeredSamples(light, None, cast(Any, None), cast(Any, None), maps, coarse, material)


def _fitted(capture: LayeredSamples, diffuse: float = 0.0) -> Glow | None:
    falloff = np.ones((1, 16, 3), np.float32)
    return fit_glow(capture, COSINE, falloff, np.full((SIDE * SIDE, 3), diffuse, np.float32))


@pytest.mark.parametrize("rim", [False, True])
def test_a_pattern_that_glows_is_told_even_at_the_rim_alone(rim: bool) -> None:
    """At the rim nothing is emitted along the normal, so that the map along it tells nothing."""
    pattern = np.random.default_rng(2).uniform(0.5, 2, SIDE * SIDE)
    curve = np.clip(0.8 - COSINE, 0, 1) if rim else np.ones_like(COSINE)
    capture = _emitting(curve, pattern)
    glow = _fitted(capture)
    assert glow is not None
    left = glow.taken_from(capture.light, capture.material)
    told = left.diffuse.astype(np.float32)
    emitted = pattern[:, None, None] * curve[..., None] * np.array(COLOUR)
    assert np.abs(told - emitted).mean() < 0.04 * emitted.mean()
    np.testing.assert_allclose(left.mirrored, 0.1, atol=2e-3)
    assert left.emitted is None
    assert (glow.image[..., 2] == 0).all()
    shown = falloff_at(glow.falloff, np.zeros(1, np.int32), np.array([0.3], np.float32))
    middle = glow.image[FINER // 2 :: FINER, FINER // 2 :: FINER].reshape(-1, 3) * shown
    expected = pattern[:, None] * np.array(COLOUR) * (0.5 if rim else 1.0)
    if rim:  # between texels it is blended
        assert np.abs(middle.mean() / expected.mean() - 1) < 0.1
    else:
        np.testing.assert_allclose(middle, expected, rtol=2e-3)


def test_a_rim_that_glows_over_diffuse_light_is_left_to_the_rest() -> None:
    assert _fitted(_emitting(np.clip(0.8 - COSINE, 0, 1), np.ones(SIDE * SIDE), 0.5), 0.5) is None
    assert _fitted(_emitting(0 * COSINE, np.ones(SIDE * SIDE), 0.5), 0.5) is None


def test_colour_times_irradiance_is_what_it_was_and_the_glow_whatever_is_beside_it() -> None:
    """A lamp forty times as bright as what is around it, of a few fine texels."""
    colour, irradiance = np.full((48, 48, 3), 0.5, np.float32), np.ones((SIDE, SIDE, 3), np.float32)
    irradiance[:, :3] = 0  # in the dark
    image = np.zeros_like(colour)
    image[22:26, 21:24] = 20, 10, 0
    image[40:44, 2:5] = 1, 1, 1
    glow = Glow(np.zeros((SIDE * SIDE, 3), np.float32), np.ones((1, 16, 3), np.float32), image)
    found, raised = glow.folded(PLAN, colour, irradiance)
    assert found.max() <= 1.05
    along = (np.arange(48) + 0.5) / 48
    uv = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2).astype(np.float32)
    expected = colour * bilinear(irradiance, uv).reshape(colour.shape) + image
    shown = found * bilinear(raised, uv).reshape(colour.shape)
    np.testing.assert_allclose(shown, expected, rtol=1e-5, atol=1e-6)
    assert (found[:20, 20:, 2] == 0.5).all()  # nothing blue glows there
    between = np.random.default_rng(1).uniform(0.05, 0.95, (4000, 2)).astype(np.float32)
    lit = bilinear(image, between).max(axis=1) == 0
    beside = bilinear(found, between) * bilinear(raised, between)
    dark = bilinear(expected, between)
    assert (beside[lit] <= 1.1 * dark[lit] + 0.02).all()
    image[30:34, 30:34] = 0.2  # a faint sign, in the light: no more irradiance is needed
    found, raised = Glow(glow.light, glow.falloff, image).folded(PLAN, colour, irradiance)
    np.testing.assert_allclose(
        (found * bilinear(raised, uv).reshape(colour.shape))[30:34, 30:34], 0.7, rtol=1e-5
    )
    column = np.arange(SIDE * SIDE) % SIDE
    picked = plan_of_picked(PLAN, np.flatnonzero(column < 10))  # the last two are gutter
    for tall, lit_as in ((4, 5.5), (48, 5.5 / 3)):  # in one texel of the gutter, or in half of them
        lamps = np.zeros_like(image)
        lamps[:tall, -4:] = 5
        _, kept = Glow(glow.light, glow.falloff, lamps).folded(picked, colour, irradiance)
        assert kept[0, -1, 0] == pytest.approx(lit_as)
        assert (kept[1:, -2:] == kept[1:, 9:10]).all()
    fixed = (np.arange(SIDE * SIDE) % SIDE) > 6
    _, kept = glow.folded(PLAN, colour, irradiance, fixed)
    np.testing.assert_array_equal(kept[:, 6:], irradiance[:, 6:])  # and those that lookups blend with them
    assert kept[5, 5, 0] == 20.5
