# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fit survives odd samples: fireflies and lamps, empty and black objects, texels that nobody sees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake.light_samples import EndSamples, LightSamples, SurroundingsSamples
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.shared import Axis
from tests.bake.known_object import (
    BLACK,
    CHEQUERS,
    NONE,
    NOTHING,
    PLAIN,
    Known,
    Shine,
    constant,
    grey,
    relative_error,
    sphere,
    with_lobe,
)

both_axes = pytest.mark.parametrize("axis", Axis)


def struck(light: LightSamples, axis: Axis, count: int) -> LightSamples:
    """The same light, but for so many samples of a lobe that are ten thousand times too bright."""
    hit = (light.mirrored if axis is Axis.MIRROR else light.through).copy()
    seen_well = np.flatnonzero(square_to_direction(light.square)[..., 2] > 0.15)
    hit.reshape(-1, 3)[np.random.default_rng(3).choice(seen_well, count, replace=False)] += 1e4
    return replace(light, mirrored=hit) if axis is Axis.MIRROR else replace(light, through=hit)


@both_axes
def test_fireflies_are_cut_off_and_their_share_is_told(axis: Axis) -> None:
    known = with_lobe(axis, PLAIN, CHEQUERS)
    clean = known.light()
    hit = struck(clean, axis, 8)
    fitted, spared = known.fit(hit), known.fit(clean)
    all_light = sum(light.sum(dtype=float) for light in (hit.diffuse, hit.mirrored, hit.through))
    assert fitted.fireflies == pytest.approx(8 * 3e4 / all_light, rel=0.05)  # without the grazing samples
    found, expected = known.shown(fitted.atlas)[0], known.shown(spared.atlas)[0]
    assert found.mean() == pytest.approx(expected.mean(), rel=0.005)
    difference = relative_error(found, expected)
    assert np.percentile(difference, 98) < 0.035
    assert difference.max() < 1  # eight in 120,000, ten thousand times too bright: a glow, if one looks there


def test_fireflies_are_no_highlights_where_samples_are_few() -> None:
    known = with_lobe(Axis.MIRROR, PLAIN)
    fitted = known.fit(struck(known.light(64), Axis.MIRROR, 40), size=128)
    assert known.shown(fitted.atlas)[0].max() < 10


@both_axes
def test_a_lamp_that_all_texels_see_is_no_firefly(axis: Axis) -> None:
    def lamp(d: Floats) -> Floats:
        return np.where((d @ np.array([0.6, 0, 0.8]) > 0.9)[..., None], 100.0, 0.3) * np.ones(3)

    known = with_lobe(axis, Shine(), world=lamp)
    fitted = known.fit()
    assert fitted.fireflies < 0.001
    found, truth = known.shown(fitted.atlas)
    lit = truth[:, 0] > 50
    assert np.median(found[lit]) == pytest.approx(100, rel=0.02)
    assert np.median(found[~lit]) == pytest.approx(0.3, rel=0.02)
    assert found.mean() == pytest.approx(truth.mean(), rel=0.03)


@both_axes
def test_a_lobe_without_light_is_left_out(axis: Axis) -> None:
    bright, faint = Shine(), Shine(weight=constant(1e-4))
    mirror, through = (bright, faint) if axis is Axis.MIRROR else (faint, bright)
    known = Known(sphere(), mirror, through)
    assert [lobe.axis for lobe in known.fit().atlas.lobes] == [axis]


def test_an_object_that_only_scatters_has_no_lobes() -> None:
    assert Known(sphere(), colour=CHEQUERS).fit().atlas.lobes == ()


@pytest.mark.parametrize("shine", [NONE, Shine()], ids=["ends nowhere", "mirrors the dark"])
def test_a_black_object_is_black(shine: Shine) -> None:
    known = Known(sphere(), mirror=shine, through=shine, world=grey(0))
    fitted = known.fit()
    found, _ = known.shown(fitted.atlas, lowest=0)
    assert not found.any()
    assert fitted.fireflies == 0


@both_axes
def test_an_object_that_glows_and_sees_nothing(axis: Axis) -> None:
    """Its paths end nowhere, and nothing is around it."""
    none = np.zeros((0, 3), dtype=np.float32)
    nothing = SurroundingsSamples(np.zeros(3, dtype=np.float32), none, none, none[:, 0])
    known = with_lobe(axis, Shine(weight=NOTHING, glow=constant(0.7, 0.5, 0.1)), colour=CHEQUERS)
    error = relative_error(*known.shown(known.fit(surroundings=nothing).atlas))
    assert np.percentile(error, 99) < 0.05


@both_axes
def test_a_glow_is_not_taken_for_a_reflection(axis: Axis) -> None:
    """It stays as bright where the world is dark, and no prior takes any of it."""
    known = with_lobe(axis, Shine(weight=NOTHING, glow=constant(0.7, 0.5, 0.1)))
    fitted = known.fit()
    found, truth = known.shown(fitted.atlas)
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=1e-3)
    assert np.percentile(relative_error(found, truth), 99) < 0.06


@both_axes
def test_texels_that_nobody_sees_spoil_nothing(axis: Axis) -> None:
    known = with_lobe(axis, PLAIN, colour=CHEQUERS)
    light = known.light()
    seen = light.seen.copy()
    seen[np.arange(len(seen)) % 97 == 0] = False
    diffuse, mirrored, through = (
        np.where(seen[..., None], part, np.float32(1e3))
        for part in (light.diffuse, light.mirrored, light.through)
    )
    wrong = replace(light, seen=seen, diffuse=diffuse, mirrored=mirrored, through=through)
    fitted = known.fit(wrong)
    assert [lobe.axis for lobe in fitted.atlas.lobes] == [axis]
    error = relative_error(*known.shown(fitted.atlas))
    assert np.percentile(error, 90) < 0.06  # texels beside them are blended with them


def test_an_object_that_nobody_sees() -> None:
    known = Known(sphere(), mirror=PLAIN, through=PLAIN, colour=CHEQUERS)
    light = known.light(64)
    fitted = known.fit(replace(light, seen=np.zeros_like(light.seen)))
    assert fitted.fireflies == 0


@both_axes
def test_light_of_which_no_path_was_traced(axis: Axis) -> None:
    """Every path to the ends was lost; the light is there all the same."""
    known = with_lobe(axis, PLAIN)
    ends = known.ends()
    lost = {
        name: np.zeros_like(value) for name, value in vars(ends).items() if name not in ("plan", "square")
    }
    found, truth = known.shown(known.fit(ends=replace(ends, **lost)).atlas)
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.03)


@both_axes
def test_a_purely_red_lobe(axis: Axis) -> None:
    known = with_lobe(axis, Shine(weight=constant(0.5, 0, 0)))
    found, truth = known.shown(known.fit().atlas)
    assert np.abs(found[:, 1:]).max() < 1e-3
    assert np.median(relative_error(found, truth)) < 0.01


def test_a_purely_red_object() -> None:
    known = Known(sphere(), colour=BLACK + np.array([0.5, 0, 0]))
    found, truth = known.shown(known.fit(known.light(64)).atlas)
    assert not found[:, 1:].any()
    assert relative_error(found, truth).max() < 0.1


def test_ends_that_noise_has_thrown_far_away_are_no_ends() -> None:
    """Directions are quotients of two renders: where their paths differed, they can have any length."""
    known = with_lobe(Axis.MIRROR, Shine())
    ends = known.ends()
    end = ends.mirrored_end.copy()
    astray = np.random.default_rng(4).random(end.shape[:2]) < 0.1
    end[astray] *= np.array([30, -20, 5], dtype=np.float32)
    error = relative_error(*known.shown(known.fit(ends=replace(ends, mirrored_end=end)).atlas))
    assert np.percentile(error, 99) < 0.05


def test_half_precision_will_do() -> None:
    known = Known(sphere(), mirror=PLAIN, through=Shine(weight=constant(0.3)), colour=CHEQUERS)
    light, ends = known.light(), known.ends()
    square, diffuse, mirrored, through = (
        part.astype(np.float16) for part in (light.square, light.diffuse, light.mirrored, light.through)
    )
    light = replace(light, square=square, diffuse=diffuse, mirrored=mirrored, through=through)
    parts = (ends.square, ends.mirrored_weight, ends.mirrored_end, ends.through_weight, ends.through_end)
    ends = EndSamples(ends.plan, *(part.astype(np.float16) for part in parts))
    assert np.median(relative_error(*known.shown(known.fit(light, ends).atlas))) < 0.01


def test_few_samples_tell_little_but_no_nonsense() -> None:
    """The fewest that a capture makes: 16 paths of light a texel, four ends."""
    known = with_lobe(Axis.MIRROR, PLAIN, colour=CHEQUERS)
    fitted = known.fit(known.light(16), known.ends(4), known.surroundings(16))
    found, truth = known.shown(fitted.atlas)
    assert np.percentile(relative_error(found, truth), 90) < 0.15


@pytest.mark.parametrize("colour_falls_off", [False, True])
def test_irradiance_times_colour_is_the_light_whether_or_not_the_colour_falls_off(
    colour_falls_off: bool,
) -> None:
    known = Known(sphere(), colour=CHEQUERS)
    light = known.light()
    curve = (0.5 + 0.5 * square_to_direction(light.square)[..., 2:]).astype(np.float32)
    own = light.colour * (curve.mean(axis=1) if colour_falls_off else 1)  # below the surface it does not
    atlas = known.fit(replace(light, diffuse=light.diffuse * curve, colour=own)).atlas
    straight = light.diffuse.mean(axis=1) * (0.5 + 0.5 * (len(atlas.falloff) - 0.5) / len(atlas.falloff))
    shown = (known.colour * atlas.irradiance).reshape(-1, 3)[known.plan.texel]
    np.testing.assert_allclose(shown.sum(axis=0), straight.sum(axis=0), rtol=0.01)
