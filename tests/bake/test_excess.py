# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that few paths bring is given back; what single ones bring is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake.excess import highest_confirmed
from radtex_addon.bake.light_samples import LightSamples, mirrored, straight_through
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.shared import Axis, SharedAtlas, sample_shared
from tests.bake.known_object import HEIGHT, PLAIN, WIDTH, Shine, grey, with_lobe

both_axes = pytest.mark.parametrize("axis", Axis)
LAMP = np.array([0.6, 0, 0.8])


def hit(light: LightSamples, axis: Axis, chance: float, factor: float, near: float) -> LightSamples:
    """The same light, but for some of the samples that look to a lamp, which are so much brighter.

    Its place is that of the axes within `near`, a cosine.
    """
    towards = mirrored if axis is Axis.MIRROR else straight_through
    some = towards(light.plan, light.square) @ LAMP > near
    some &= np.random.default_rng(7).random(some.shape) < chance
    lit = (light.mirrored if axis is Axis.MIRROR else light.through).copy()
    lit[some] += factor
    return replace(light, mirrored=lit) if axis is Axis.MIRROR else replace(light, through=lit)


def flux(light: LightSamples, axis: Axis) -> tuple[float, float]:
    """Mean radiance times N.I of samples that a fit counts: of all, and of those that look to the lamp."""
    values = (light.mirrored if axis is Axis.MIRROR else light.through).astype(np.float64).mean(axis=2)
    return means(values, light, axis)


def shown_flux(atlas: SharedAtlas, light: LightSamples, axis: Axis) -> tuple[float, float]:
    """The same of what the atlas shows at the samples, at the texels' own middles."""
    plan, shape = light.plan, light.square.shape[:2]
    texel = np.repeat(plan.texel, shape[1])
    uv = np.stack([(texel % WIDTH + 0.5) / WIDTH, (texel // WIDTH + 0.5) / HEIGHT], axis=-1)
    viewer = -straight_through(plan, light.square).reshape(-1, 3)
    normal = np.repeat(plan.normal.reshape(-1, 3)[: shape[0]], shape[1], axis=0)
    shown = sample_shared(atlas, uv, normal, viewer).mean(axis=1).reshape(shape)
    return means(shown, light, axis)


def means(values: Floats, light: LightSamples, axis: Axis) -> tuple[float, float]:
    cosine = square_to_direction(light.square)[..., 2]
    counts = np.where(cosine > 0.1, cosine, 0)
    towards = mirrored if axis is Axis.MIRROR else straight_through
    there = counts * (towards(light.plan, light.square) @ LAMP > 0.8)
    return float((values * counts).sum() / counts.sum()), float((values * there).sum() / there.sum())


@both_axes
@pytest.mark.parametrize(("chance", "factor"), [(0.01, 300.0), (0.05, 50.0)])
def test_what_few_paths_bring_is_given_back(axis: Axis, chance: float, factor: float) -> None:
    known = with_lobe(axis, PLAIN)
    light = hit(known.light(), axis, chance, factor, 0.8)
    fitted = known.fit(light)
    assert fitted.fireflies < 0.001
    (found, found_there), (expected, there) = shown_flux(fitted.atlas, light, axis), flux(light, axis)
    assert found == pytest.approx(expected, rel=0.02)
    assert found_there > 0.7 * there  # it is given to where it came from


@both_axes
def test_it_is_given_back_without_dots(axis: Axis) -> None:
    known = with_lobe(axis, Shine(), world=grey(0.5))
    light = hit(known.light(), axis, 0.001, 300.0, -1)  # one sample of every fourth texel
    found = known.shown(known.fit(light).atlas)[0]
    assert found.mean() == pytest.approx(0.8, rel=0.05)
    assert found.max() < 3


@pytest.mark.parametrize(
    ("bright", "highest"),
    [
        ([], 0),
        ([5.0] * 8, 0),  # fewer than confirm each other
        ([5.0] * 16, 5),
        ([1.0] * 100, 1),
        ([1e4, *[1.0] * 60], 4),  # 4 of 4 + 60
        ([1e4, 1e3, *[1.0] * 70], 5),  # twice 5 of 10 + 70
        ([1e4, 2.0, *[1.0] * 28], 2),  # 2 of 2 + 2 + 28
    ],
)
def test_no_path_brings_more_than_its_share(bright: list[float], highest: float) -> None:
    assert highest_confirmed(np.array(bright)) == pytest.approx(highest)
