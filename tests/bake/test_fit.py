# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fit finds again what a known object under its world shows, by each lobe, and loses no light."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake import blocks
from radtex_addon.bake.fit import Fitted
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import Progress, Stage
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.octahedron import octahedron_to_direction
from radtex_addon.core.shared import Axis, sample_shared
from tests.bake.known_object import (
    BLACK,
    CELLS,
    CHEQUERS,
    HEIGHT,
    NOTHING,
    PLAIN,
    SIZE,
    WIDTH,
    Known,
    Shine,
    constant,
    diffuse_light,
    floor,
    grey,
    on_a_wall,
    relative_error,
    scattered,
    sphere,
    viewers,
    with_lobe,
)

both_axes = pytest.mark.parametrize("axis", Axis)


def cell_axes() -> Floats:
    """The axes of a bucket's cells, (CELLS², 3)."""
    middle = (np.arange(CELLS) + 0.5) / CELLS
    return octahedron_to_direction(np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2))


def own_cells(plan: CapturePlan, axis: Axis, lowest: float = 0.2) -> Bools:
    """The cells (K, CELLS²) of which a texel's own viewers tell, at cosines above `lowest`."""
    facing = plan.normal.reshape(-1, 3)[: len(plan.texel)] @ cell_axes().T
    own: Bools = (facing if axis is Axis.MIRROR else -facing) > lowest
    return own


def degrees_between(a: Floats, b: Floats) -> Floats:
    """Angles between vectors (..., 3) of any length."""
    cosine = np.sum(a * b, axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    angle: Floats = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return angle


def ends_of(plan: CapturePlan, fitted: Fitted) -> Floats:
    """Shift and spread of the only lobe, (K, CELLS², 4)."""
    (lobe,) = fitted.atlas.lobes
    return lobe.ends.reshape(HEIGHT * WIDTH, CELLS**2, 4)[plan.texel]


@pytest.mark.parametrize(("axis", "worse"), [(Axis.MIRROR, 1), (Axis.THROUGH, 2)])
def test_fresh_fragments_show_the_object_under_its_world(axis: Axis, worse: int) -> None:
    known = with_lobe(axis, PLAIN, CHEQUERS)
    fitted = known.fit()
    error = relative_error(*known.shown(fitted.atlas))
    assert [lobe.axis for lobe in fitted.atlas.lobes] == [axis]
    assert np.median(error) < 0.008 * worse
    assert np.percentile(error, 90) < 0.02 * worse
    assert np.percentile(error, 99) < 0.05 * worse
    assert fitted.fireflies == 0


def test_two_lobes_are_told_apart() -> None:
    tinted = Shine(weight=constant(0.1, 0.3, 0.6))
    known = Known(sphere(), mirror=PLAIN, through=tinted, colour=CHEQUERS)
    fitted = known.fit()
    mirror, through = fitted.atlas.lobes
    assert (mirror.axis, through.axis) == (Axis.MIRROR, Axis.THROUGH)
    assert np.median(relative_error(*known.shown(fitted.atlas))) < 0.01
    only_through = replace(fitted.atlas, colour=fitted.atlas.colour * 0, lobes=(through,))
    glass = with_lobe(Axis.THROUGH, tinted)
    assert np.percentile(relative_error(*glass.shown(only_through)), 99) < 0.06


def test_the_world_is_as_sharp_as_its_picture_however_coarse_the_buckets() -> None:
    """Stripes 15 degrees wide, in buckets whose cells are 26 degrees wide."""

    def stripes(d: Floats) -> Floats:
        light: Floats = 1 + 0.8 * np.sin(12 * np.arctan2(d[..., 1:2], d[..., :1])) * np.ones(3)
        return light

    known = Known(sphere(), mirror=Shine(), world=stripes)
    found, truth = known.shown(known.fit(size=192).atlas)
    assert np.median(relative_error(found, truth)) < 0.01
    assert np.corrcoef(found[:, 0], truth[:, 0])[0, 1] > 0.99


def test_the_colour_stays_as_sharp_as_its_picture() -> None:
    """Diffuse light is parted from the colour and put together again: exact, chequers and all."""
    known = Known(sphere(), colour=CHEQUERS)
    atlas = known.fit().atlas
    np.testing.assert_allclose(atlas.falloff, 1, atol=1e-5)
    covered = atlas.irradiance.reshape(-1, 3)[known.plan.texel]
    light = diffuse_light(known.plan.normal.reshape(-1, 3)[: len(known.plan.texel)])
    np.testing.assert_allclose(covered, light, rtol=1e-4)
    assert np.percentile(relative_error(*known.shown(atlas)), 99) < 0.015


def test_falloff_of_the_diffuse_light_is_found() -> None:
    known = Known(sphere(), colour=CHEQUERS)
    light = known.light()
    curve = (0.5 + 0.5 * square_to_direction(light.square)[..., 2:]).astype(np.float32)
    dimmed = replace(light, diffuse=light.diffuse * curve, colour=light.colour * curve.mean(axis=1))
    falloff = known.fit(dimmed).atlas.falloff
    cosine = (np.arange(len(falloff)) + 0.5) / len(falloff)
    expected = (0.5 + 0.5 * cosine) / (0.5 + 0.5 * cosine[-1])
    np.testing.assert_allclose(falloff[2:], np.tile(expected[2:, None], 3), atol=0.01)


@both_axes
def test_under_a_far_world_nothing_is_shifted_nor_blurred(axis: Axis) -> None:
    known = with_lobe(axis, Shine())
    fitted = known.fit()
    ends = ends_of(known.plan, fitted)
    assert np.abs(ends[..., :3]).max() < 0.01  # the far world is at a hundred times the object's size
    assert ends[..., 3].max() < 0.01 * fitted.atlas.sharpest
    assert np.median(relative_error(*known.shown(fitted.atlas))) < 0.002


@both_axes
def test_a_near_wall_is_seen_where_it_stands(axis: Axis) -> None:
    """Its parallax is the shift."""
    known = with_lobe(axis, Shine(weight=constant(0.8), end=on_a_wall(2.5)), nearness=1 / 2.5)
    fitted = known.fit()
    place = known.plan.position.reshape(-1, 1, 3)[: len(known.plan.texel)]
    wall = on_a_wall(2.5)(np.zeros((1, 1, 2)), place, np.broadcast_to(cell_axes(), (len(place), CELLS**2, 3)))
    off = degrees_between(cell_axes() + ends_of(known.plan, fitted)[..., :3], wall)
    own = own_cells(known.plan, axis)
    assert np.median(degrees_between(cell_axes(), wall)[own]) > 14
    assert np.median(off[own]) < 0.8
    assert np.percentile(off[own], 99) < 3
    error = relative_error(*known.shown(fitted.atlas))
    assert np.median(error) < 0.005
    assert np.percentile(error, 90) < 0.05


@both_axes
@pytest.mark.parametrize("variance", [0.01, 0.05])
def test_a_rough_lobe_is_as_blurred_as_its_ends_are_scattered(axis: Axis, variance: float) -> None:
    known = with_lobe(axis, Shine(end=scattered(variance)))
    fitted = known.fit()
    spread = ends_of(known.plan, fitted)[..., 3][own_cells(known.plan, axis)]
    assert np.median(spread) == pytest.approx(variance, rel=0.06)
    assert np.percentile(spread, [2, 98]) == pytest.approx([variance] * 2, rel=0.2)
    found, truth = known.shown(fitted.atlas, paths=200)
    assert np.median(relative_error(found, truth)) < 0.02
    sharp = with_lobe(axis, Shine()).shown(fitted.atlas)[1]
    assert np.mean((found - truth) ** 2) < 0.5 * np.mean((sharp - truth) ** 2)


def test_a_ball_of_glass_shows_the_world_upside_down() -> None:
    def turned(uv: Floats, position: Floats, axis: Floats) -> Floats:
        return -axis

    known = with_lobe(Axis.THROUGH, Shine(end=turned))
    fitted = known.fit()
    end = cell_axes() + ends_of(known.plan, fitted)[..., :3]
    off = degrees_between(end, -cell_axes())[own_cells(known.plan, Axis.THROUGH)]
    assert np.median(off) < 4
    assert off.max() < 15
    found, truth = known.shown(fitted.atlas)
    assert np.median(relative_error(found, truth)) < 0.03
    assert np.corrcoef(found[:, 0], truth[:, 0])[0, 1] > 0.9
    upright = with_lobe(Axis.THROUGH, Shine()).shown(fitted.atlas)[1]
    assert np.corrcoef(found[:, 0], upright[:, 0])[0, 1] < 0


def one_half(uv: Floats, position: Floats, axis: Floats) -> Floats:
    weight: Floats = np.where(uv[..., :1] < 0.5, 0, 1) * np.ones(3) + 0 * axis
    return weight


@both_axes
def test_where_no_path_ends_it_is_black(axis: Axis) -> None:
    known = with_lobe(axis, Shine(weight=one_half))
    found, truth = known.shown(known.fit().atlas)
    column = known.fragments()[0] % WIDTH
    error = relative_error(found, truth)
    dark, border = (
        column < WIDTH // 2,
        np.abs(column + 0.5 - WIDTH / 2) < 3,
    )  # texels that are fitted together
    assert error[dark & ~border].max() < 0.02
    assert np.percentile(error[~dark & ~border], 90) < 0.05
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.015)


@both_axes
def test_the_gain_is_the_share_of_the_paths_that_end(axis: Axis) -> None:
    """One path in ten is let through, whole: the others go another way, and bring nothing back."""
    chance = np.random.default_rng(6)

    def seldom(uv: Floats, position: Floats, d: Floats) -> Floats:
        taken: Floats = (chance.random((*d.shape[:-1], 1)) < 0.1) * np.ones(3)
        return taken

    known = with_lobe(axis, Shine(weight=seldom))
    fitted = known.fit()
    (lobe,) = fitted.atlas.lobes
    own = own_cells(known.plan, axis)
    gain = lobe.gain.reshape(HEIGHT * WIDTH, CELLS**2, 3)[known.plan.texel][own]
    assert np.median(gain) == pytest.approx(0.1, rel=0.15)
    assert fitted.fireflies == 0
    found, truth = known.shown(fitted.atlas, paths=200)
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.04)


def fit_evenly_lit(known: Known) -> Fitted:
    """The fit where diffuse light is the colour everywhere."""
    light = known.light()
    return known.fit(replace(light, diffuse=np.broadcast_to(light.colour[:, None], light.diffuse.shape)))


@both_axes
@pytest.mark.parametrize("diffuse", [0, 0.5, 0.8])
def test_in_a_furnace_all_is_as_bright_as_the_furnace(axis: Axis, diffuse: float) -> None:
    known = with_lobe(axis, Shine(weight=constant(0.8 - diffuse)), BLACK + diffuse, grey(1))
    fitted = fit_evenly_lit(known)
    found, _ = known.shown(fitted.atlas, lowest=0)
    assert np.abs(found - 0.8).max() < 1e-3
    assert fitted.fireflies == 0


def test_in_a_furnace_a_rough_object_is_as_bright_as_the_furnace() -> None:
    rough = Shine(constant(0.4), scattered(0.1))
    known = Known(sphere(), rough, rough, world=grey(1))
    found, _ = known.shown(known.fit().atlas, lowest=0)
    assert np.abs(found - 0.8).max() < 1e-3


def test_in_a_furnace_surroundings_finer_than_the_samples_have_no_holes() -> None:
    known = Known(sphere(), mirror=Shine(weight=constant(0.8)), world=grey(1))
    fitted = known.fit(surroundings=known.surroundings(SIZE), size=4 * SIZE)
    found, _ = known.shown(fitted.atlas)
    assert np.abs(found - 0.8).max() < 1e-3


def test_in_a_furnace_a_floor_is_as_bright_when_seen_at_a_grazing_angle() -> None:
    fitted = Known(floor(), mirror=Shine(weight=constant(0.8)), world=grey(1)).fit()
    rng = np.random.default_rng(9)
    up, along = np.tile([0, 0, 1.0], (4000, 1)), np.tile([1.0, 0, 0], (4000, 1))
    viewer = viewers(rng, up, along, lowest=0)
    found = sample_shared(fitted.atlas, rng.random((4000, 2)), up, viewer)
    assert np.abs(found - 0.8).max() < 1e-3


@both_axes
@pytest.mark.parametrize("colour", [BLACK, CHEQUERS], ids=["glossy", "both"])
def test_light_is_neither_lost_nor_won(axis: Axis, colour: Floats) -> None:
    known = with_lobe(axis, PLAIN, colour)
    found, truth = known.shown(known.fit().atlas)
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.01)


def facets(uv: Floats) -> Floats:
    """For each of eight slices of the sphere another direction, (..., 3)."""
    slices = np.array(
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [0.6, 0.8, 0], [-0.6, 0, 0.8]]
    )
    up: Floats = slices[np.floor(uv[..., 0] * 8).astype(int)]
    return up


def glow_of_facets(uv: Floats, position: Floats, axis: Floats) -> Floats:
    """A world for each slice, each another way up."""
    light: Floats = (0.5 + 0.45 * np.sum(facets(uv) * axis, axis=-1, keepdims=True)) * np.ones(3)
    return light


def bent_by_facets(uv: Floats, position: Floats, axis: Floats) -> Floats:
    """Ends half-way between the axis and another direction in each slice."""
    return normalised(axis + 0.9 * facets(uv))


@pytest.mark.parametrize(
    "shine", [Shine(weight=NOTHING, glow=glow_of_facets), Shine(end=bent_by_facets)], ids=["glow", "end"]
)
def test_light_is_not_lost_where_texels_see_nothing_in_common(shine: Shine) -> None:
    known = with_lobe(Axis.THROUGH, shine)
    found, truth = known.shown(known.fit().atlas)
    # towards the horizon cells have few samples, and show what the texel's others do
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.02)
    assert np.median(relative_error(found, truth)) < 0.2  # their edges are blurred over two texels


# how it runs


def same(one: Fitted, other: Fitted) -> bool:
    """Whether two fits are the same, to the last bit."""
    parts = [
        [fit.atlas.irradiance, fit.atlas.falloff, *fit.atlas.surroundings]
        + [part for lobe in fit.atlas.lobes for part in (lobe.ends, lobe.gain, lobe.rest)]
        for fit in (one, other)
    ]
    return one.fireflies == other.fireflies and all(map(np.array_equal, *parts))


def test_the_fit_is_the_same_on_any_number_of_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    known = Known(sphere(), mirror=PLAIN, through=PLAIN, colour=CHEQUERS)
    fits = []
    for threads in (1, 3):
        monkeypatch.setattr(blocks, "THREADS", threads)
        fits.append(known.fit())
    assert same(*fits)


def test_progress_is_told_stage_by_stage() -> None:
    steps = list(Known(sphere(), mirror=PLAIN, through=PLAIN).fitting())
    assert steps[0] == Progress(Stage.FIT, 0, 1)
    done = [step.done for step in steps[1:]]
    total = steps[-1].total
    assert done == sorted(done)
    assert set(done) == set(range(total + 1))
    assert {step.total for step in steps[1:]} == {total}
    assert done[-1] == total


def test_a_fit_can_be_dropped_at_any_step() -> None:
    known = with_lobe(Axis.MIRROR, PLAIN)
    light, ends, around = known.light(64), known.ends(16), known.surroundings(16)
    number = len(list(known.fitting(light, ends, around, 16)))
    running = threading.active_count()
    for dropped in range(number):
        steps = known.fitting(light, ends, around, 16)
        for _ in range(dropped + 1):
            next(steps)
        steps.close()
        assert threading.active_count() == running
