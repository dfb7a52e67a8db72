# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fit finds again what a known object under its world shows, loses no light, and survives odd samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import pytest

from radtex_addon.bake.fit import NEARNESS_SIZE, Fitted, fit_nearness, fit_shared
from radtex_addon.bake.light_samples import LightSamples, Meetings, cells_of, mirrored, spread_shifts
from radtex_addon.bake.plan import CapturePlan, plan_capture
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.core.shared import SharedAtlas, sample_shared
from radtex_addon.core.texel_map import TexelMap

HEIGHT, WIDTH = 16, 32
CELLS, SIZE = 8, 48
FINE = 4  # pixels of the colour a side and texel

Glossy: TypeAlias = Callable[[Floats, Floats, Floats], Floats]  # of uv, position and R, (..., 2) and (..., 3)


def normals(uv: Floats) -> Floats:
    """Those of the unit sphere, +z at v = 1: (..., 2) -> (..., 3). They are its positions, too."""
    azimuth, polar = 2 * np.pi * uv[..., 0], np.pi * (1 - uv[..., 1])
    across = np.sin(polar)
    normal: Floats = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(polar)], axis=-1)
    return normal


def tangents(uv: Floats) -> Floats:
    azimuth = 2 * np.pi * uv[..., 0]
    return np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth], axis=-1)


def centres() -> Floats:
    i, j = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    return np.stack([(i + 0.5) / WIDTH, (j + 0.5) / HEIGHT], axis=-1)


def sphere() -> CapturePlan:
    """A unit sphere, one column of gutter at either side."""
    normal = normals(centres()).astype(np.float32)
    tangent = tangents(centres()).astype(np.float32)
    triangle = np.zeros((HEIGHT, WIDTH), dtype=np.int32)
    triangle[:, [0, -1]] = -1
    ones = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    return plan_capture(TexelMap(normal, normal, tangent, ones, normal, triangle, triangle >= 0), CELLS)


def floor() -> CapturePlan:
    """The square [-1, 1]^2 at z = 0, whose texels all look up."""
    position = np.concatenate([centres() * 2 - 1, np.zeros((HEIGHT, WIDTH, 1))], axis=-1).astype(np.float32)
    normal, tangent = (np.broadcast_to(np.eye(3, dtype=np.float32)[k], position.shape) for k in (2, 0))
    ones = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    triangle = np.zeros((HEIGHT, WIDTH), dtype=np.int32)
    return plan_capture(TexelMap(position, normal, tangent, ones, normal, triangle, triangle >= 0), CELLS)


def squares(texels: int, directions: int, seed: int = 1) -> Floats:
    """B of evenly spread directions, turned from texel to texel: (texels, directions, 2)."""
    side = round(directions**0.5)
    even = (cell_centres(side).reshape(-1, 2) + 1) / 2
    turned = (even + spread_shifts(texels, seed)[:, None]) % 1.0
    return (2 * turned - 1).astype(np.float32)


def chequers(shape: tuple[int, int]) -> Floats:
    """A colour a texel, two in turn, (H, W, 3)."""
    i, j = np.meshgrid(np.arange(shape[1]), np.arange(shape[0]))
    return np.where(((i + j) % 2)[..., None], [0.8, 0.3, 0.1], [0.2, 0.4, 0.7])


def diffuse_light(normal: Floats) -> Floats:
    """Irradiance over pi, (..., 3) -> (..., 3)."""
    light: Floats = 0.6 + 0.3 * normal[..., 2:] + 0.1 * normal[..., :1] * np.array([1, 0, -1])
    return light


def world(d: Floats) -> Floats:
    """Light from far away, smooth and positive, (..., 3) -> (..., 3)."""
    sun = np.exp(4 * (d @ np.array([0.6, 0, 0.8]) - 1))[..., None] * [2, 1.8, 1.5]
    light: Floats = 0.3 + 0.1 * d[..., 2:] + sun
    return light


def own_glossy(uv: Floats, position: Floats, r: Floats) -> Floats:
    """The world, more or less of it from place to place, and a red glow of the object from one side."""
    gain = 0.6 + 0.2 * np.sin(2 * np.pi * uv[..., :1])
    light: Floats = gain * world(r) + np.maximum(-r[..., :1], 0) * [0.1, 0.05, 0]
    return light


def constant(value: float) -> Glossy:
    def glossy(uv: Floats, position: Floats, r: Floats) -> Floats:
        return np.full(r.shape, value)

    return glossy


def samples_of(plan: CapturePlan, glossy: Glossy, colour: Floats, directions: int = 256) -> LightSamples:
    """Samples of the object with that glossy light and those diffuse colours (H, W, 3), exactly."""
    texels = len(plan.texel)
    square = squares(texels, directions)
    normal, position = (f.reshape(-1, 3)[:texels] for f in (plan.normal, plan.position))
    own = colour.reshape(-1, 3)[plan.texel]
    diffuse = np.broadcast_to((own * diffuse_light(normal))[:, None], (*square.shape[:2], 3))
    uv = centres().reshape(-1, 2)[plan.texel]
    shine = glossy(uv[:, None], position[:, None], mirrored(plan, square))
    return LightSamples(
        plan,
        square,
        (diffuse + shine).astype(np.float32),
        diffuse.astype(np.float32),
        own.astype(np.float32),
        np.ones(square.shape[:2], dtype=bool),
    )


def far_world(plan: CapturePlan) -> Meetings:
    """Rays that meet nothing but the world."""
    square = squares(len(plan.texel), 64, seed=5)
    none = np.zeros(square.shape[:2], dtype=bool)
    return Meetings(square, np.zeros((*none.shape, 3), dtype=np.float32), ~none, none)


def room(plan: CapturePlan, radius: float) -> Meetings:
    """Rays that meet the wall of a round room around the origin."""
    square = squares(len(plan.texel), 64, seed=5)
    position = plan.position.reshape(-1, 1, 3)[: len(plan.texel)]
    none = np.zeros(square.shape[:2], dtype=bool)
    return Meetings(square, wall_of(position, mirrored(plan, square), radius), none, none)


def wall_of(position: Floats, direction: Floats, radius: float) -> Floats:
    along = np.sum(position * direction, axis=-1, keepdims=True)
    inside = np.sum(position**2, axis=-1, keepdims=True) - radius**2
    point: Floats = position + (np.sqrt(along**2 - inside) - along) * direction
    return point


def fit(samples: LightSamples, meetings: Meetings, colour: Floats, size: int = SIZE) -> Fitted:
    fitted = fit_shared(samples, meetings, enlarged(colour), CELLS, size)
    atlas = fitted.atlas
    for part in (atlas.rest, atlas.surroundings, atlas.nearness, atlas.irradiance, atlas.falloff):
        assert np.isfinite(part).all()
        assert part.dtype == np.float32
    return fitted


def enlarged(colour: Floats) -> Floats:
    return np.repeat(np.repeat(colour, FINE, axis=0), FINE, axis=1)


def shown(
    plan: CapturePlan, atlas: SharedAtlas, glossy: Glossy, colour: Floats, lowest: float = 0.15
) -> tuple[Floats, Floats]:
    """What fresh fragments of the sphere show by the atlas, and what they should, (K, 3) both.

    They lie on covered texels, away from the chequers' edges, their viewers above cosines of `lowest`.
    """
    rng = np.random.default_rng(9)
    texel = rng.choice(plan.texel, 4000)
    uv = centres().reshape(-1, 2)[texel] + rng.uniform(-0.35, 0.35, (len(texel), 2)) / [WIDTH, HEIGHT]
    normal, tangent = normals(uv), tangents(uv)
    viewer, r = viewers(rng, normal, tangent, lowest)
    truth = colour.reshape(-1, 3)[texel] * diffuse_light(normal) + glossy(uv, normal, r)
    return sample_shared(atlas, uv, normal, normal, viewer), truth


def viewers(
    rng: np.random.Generator, normal: Floats, tangent: Floats, lowest: float
) -> tuple[Floats, Floats]:
    """Random directions to viewers, evenly over the sphere above cosines of `lowest`, and their mirrors'."""
    cosine, azimuth = rng.uniform(lowest, 1, (len(normal), 1)), rng.uniform(-np.pi, np.pi, (len(normal), 1))
    across = np.cos(azimuth) * tangent + np.sin(azimuth) * np.cross(normal, tangent)
    viewer = np.sqrt(1 - cosine**2) * across + cosine * normal
    return viewer, 2 * cosine * normal - viewer


def relative_error(found: Floats, truth: Floats) -> Floats:
    """The worst channel's error of each fragment, relative to the mean light: (K,)."""
    error: Floats = (np.abs(found - truth) / truth.mean()).max(axis=1)
    return error


BLACK = np.zeros((HEIGHT, WIDTH, 3))
CHEQUERS = chequers((HEIGHT, WIDTH))


def test_fresh_fragments_show_the_object_under_its_world() -> None:
    plan = sphere()
    fitted = fit(samples_of(plan, own_glossy, CHEQUERS), far_world(plan), CHEQUERS)
    error = relative_error(*shown(plan, fitted.atlas, own_glossy, CHEQUERS))
    assert np.median(error) < 0.008
    assert np.percentile(error, 90) < 0.03
    assert np.percentile(error, 99) < 0.09
    assert fitted.fireflies < 1e-6


def test_the_colour_stays_as_sharp_as_its_picture() -> None:
    """Diffuse light is parted from the colour and put together again: exact, chequers and all."""
    plan = sphere()
    fitted = fit(samples_of(plan, constant(0), CHEQUERS), far_world(plan), CHEQUERS)
    np.testing.assert_allclose(fitted.atlas.falloff, 1, atol=1e-5)
    covered = fitted.atlas.irradiance.reshape(-1, 3)[plan.texel]
    light = diffuse_light(plan.normal.reshape(-1, 3)[: len(plan.texel)])
    np.testing.assert_allclose(covered, light, rtol=1e-4)
    error = relative_error(*shown(plan, fitted.atlas, constant(0), CHEQUERS))
    assert np.percentile(error, 99) < 0.015


def test_falloff_of_the_diffuse_light_is_found() -> None:
    plan = sphere()
    samples = samples_of(plan, constant(0), CHEQUERS)
    curve = (0.5 + 0.5 * square_to_direction(samples.square)[..., 2:]).astype(np.float32)
    dimmed = replace(
        samples,
        radiance=samples.radiance * curve,
        diffuse=samples.diffuse * curve,
        colour=samples.colour * curve.mean(axis=1),
    )
    falloff = fit(dimmed, far_world(plan), CHEQUERS).atlas.falloff
    cosine = (np.arange(len(falloff)) + 0.5) / len(falloff)
    expected = (0.5 + 0.5 * cosine) / (0.5 + 0.5 * cosine[-1])
    np.testing.assert_allclose(falloff[2:], np.tile(expected[2:, None], 3), atol=0.01)


def test_a_near_wall_is_found_and_seen_where_it_stands() -> None:
    def glossy(uv: Floats, position: Floats, r: Floats) -> Floats:
        return 0.8 * world(wall_of(position, r, 2.5) / 2.5)

    plan = sphere()
    atlas = fit(samples_of(plan, glossy, BLACK), room(plan, 2.5), BLACK).atlas
    np.testing.assert_allclose(1 / atlas.nearness, 2.5, rtol=0.01)
    error = relative_error(*shown(plan, atlas, glossy, BLACK))
    assert np.median(error) < 0.003
    assert np.percentile(error, 99) < 0.05


def furnace(plan: CapturePlan, diffuse: float, directions: int = 256) -> LightSamples:
    """Radiance 0.8 everywhere, as much of it diffuse as said."""
    samples = samples_of(plan, constant(0.8), BLACK, directions)
    return replace(
        samples,
        diffuse=np.full_like(samples.diffuse, diffuse),
        colour=np.full_like(samples.colour, diffuse),
    )


@pytest.mark.parametrize("diffuse", [0, 0.5, 0.8])
def test_in_a_furnace_all_is_as_bright_as_the_furnace(diffuse: float) -> None:
    plan = sphere()
    fitted = fit(furnace(plan, diffuse), far_world(plan), BLACK + diffuse)
    found, _ = shown(plan, fitted.atlas, constant(0.8), BLACK, lowest=0)
    assert np.abs(found - 0.8).max() < 1e-3
    assert fitted.fireflies == 0


def test_in_a_furnace_surroundings_finer_than_the_samples_have_no_holes() -> None:
    plan = sphere()
    fitted = fit(furnace(plan, 0), far_world(plan), BLACK, size=192)
    found, _ = shown(plan, fitted.atlas, constant(0.8), BLACK)
    assert np.abs(found - 0.8).max() < 1e-3


def test_in_a_furnace_a_floor_is_as_bright_when_seen_at_a_grazing_angle() -> None:
    plan = floor()
    atlas = fit(furnace(plan, 0), far_world(plan), BLACK).atlas
    rng = np.random.default_rng(9)
    uv = rng.random((4000, 2))
    position = np.concatenate([uv * 2 - 1, np.zeros((4000, 1))], axis=1)
    up, along = np.tile([0, 0, 1.0], (4000, 1)), np.tile([1.0, 0, 0], (4000, 1))
    viewer, _ = viewers(rng, up, along, lowest=0)
    assert np.abs(sample_shared(atlas, uv, position, up, viewer) - 0.8).max() < 1e-3


@pytest.mark.parametrize("colour", [BLACK, CHEQUERS], ids=["glossy", "both"])
def test_light_is_neither_lost_nor_won(colour: Floats) -> None:
    plan = sphere()
    atlas = fit(samples_of(plan, own_glossy, colour), far_world(plan), colour).atlas
    found, truth = shown(plan, atlas, own_glossy, colour)
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.01)


def test_light_is_not_lost_either_where_texels_see_nothing_in_common() -> None:
    plan = sphere()
    atlas = fit(samples_of(plan, facets, BLACK), far_world(plan), BLACK).atlas
    found, truth = shown(plan, atlas, facets, BLACK)
    np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.01)


def facets(uv: Floats, position: Floats, r: Floats) -> Floats:
    """A world for each of eight slices of the sphere, each another way up."""
    slices = np.array(
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [0.6, 0.8, 0], [-0.6, 0, 0.8]]
    )
    up = slices[np.floor(uv[..., 0] * 8).astype(int)]
    light: Floats = (0.5 + 0.45 * np.sum(up * r, axis=-1, keepdims=True)) * np.ones(3)
    return light


def test_where_texels_see_nothing_in_common_each_keeps_its_own() -> None:
    plan = sphere()
    atlas = fit(samples_of(plan, facets, BLACK), far_world(plan), BLACK).atlas
    assert not atlas.surroundings.any()
    error = relative_error(*shown(plan, atlas, facets, BLACK))
    assert np.median(error) < 0.15


def test_fireflies_are_cut_off_and_their_share_is_told() -> None:
    plan = sphere()
    clean = samples_of(plan, own_glossy, CHEQUERS)
    radiance = clean.radiance.copy()
    hits = np.random.default_rng(3).choice(radiance.shape[0] * radiance.shape[1], 8, replace=False)
    radiance.reshape(-1, 3)[hits] += 1e4
    struck = fit(replace(clean, radiance=radiance), far_world(plan), CHEQUERS)
    spared = fit(clean, far_world(plan), CHEQUERS)
    share = (radiance - clean.radiance).sum(dtype=float) / (radiance - clean.diffuse).sum(dtype=float)
    assert struck.fireflies == pytest.approx(share, rel=0.03)
    found, _ = shown(plan, struck.atlas, own_glossy, CHEQUERS)
    expected, _ = shown(plan, spared.atlas, own_glossy, CHEQUERS)
    assert found.mean() == pytest.approx(expected.mean(), rel=0.005)
    difference = relative_error(found, expected)
    assert np.percentile(difference, 98) < 0.035
    assert difference.max() < 1  # eight in 120,000, ten thousand times too bright: a glow, if one looks there


def test_a_lamp_that_all_texels_see_is_no_firefly() -> None:
    aim = np.array([0.6, 0, 0.8])

    def glossy(uv: Floats, position: Floats, r: Floats) -> Floats:
        return np.where((r @ aim > 0.9)[..., None], 100.0, 0.3) * np.ones(3)

    plan = sphere()
    fitted = fit(samples_of(plan, glossy, BLACK), far_world(plan), BLACK)
    assert fitted.fireflies < 0.05
    found, truth = shown(plan, fitted.atlas, glossy, BLACK)
    lit = truth[:, 0] > 50
    assert np.median(found[lit]) == pytest.approx(100, rel=0.1)
    assert np.median(found[~lit]) == pytest.approx(0.3, rel=0.05)
    assert found.mean() == pytest.approx(truth.mean(), rel=0.1)


def test_fireflies_are_no_highlights_where_samples_are_few() -> None:
    plan = sphere()
    clean = samples_of(plan, own_glossy, BLACK)
    radiance = clean.radiance.copy()
    hits = np.random.default_rng(3).choice(radiance.shape[0] * radiance.shape[1], 40, replace=False)
    radiance.reshape(-1, 3)[hits] += 1e4
    atlas = fit(replace(clean, radiance=radiance), far_world(plan), BLACK, size=128).atlas
    found, _ = shown(plan, atlas, own_glossy, BLACK)
    assert found.max() < 100


def test_an_object_that_sees_nothing_but_itself() -> None:
    plan = sphere()
    world_only = far_world(plan)
    itself = replace(world_only, nothing=world_only.itself, itself=world_only.nothing)
    fitted = fit(samples_of(plan, own_glossy, CHEQUERS), itself, CHEQUERS)
    assert np.ptp(fitted.atlas.nearness) == 0
    error = relative_error(*shown(plan, fitted.atlas, own_glossy, CHEQUERS))
    assert np.percentile(error, 99) < 0.09


def test_a_black_object_is_black() -> None:
    plan = sphere()
    samples = samples_of(plan, constant(0), BLACK, 64)
    found, _ = shown(plan, fit(samples, far_world(plan), BLACK).atlas, constant(0), BLACK, lowest=0)
    assert np.abs(found).max() < 1e-6


def test_texels_that_nobody_sees_spoil_nothing() -> None:
    plan = sphere()
    samples = samples_of(plan, own_glossy, CHEQUERS)
    seen = samples.seen.copy()
    hidden = np.arange(len(seen)) % 97 == 0
    seen[hidden] = False
    radiance = np.where(seen[..., None], samples.radiance, 1e3).astype(np.float32)
    atlas = fit(replace(samples, seen=seen, radiance=radiance), far_world(plan), CHEQUERS).atlas
    error = relative_error(*shown(plan, atlas, own_glossy, CHEQUERS))
    assert np.isfinite(error).all()
    assert np.percentile(error, 90) < 0.06  # texels beside them are blended with them


def test_an_object_that_nobody_sees() -> None:
    plan = sphere()
    samples = samples_of(plan, own_glossy, CHEQUERS, 64)
    fit(replace(samples, seen=np.zeros_like(samples.seen)), far_world(plan), CHEQUERS)


def test_a_purely_red_object() -> None:
    plan, red = sphere(), BLACK + np.array([0.5, 0, 0])
    atlas = fit(samples_of(plan, constant(0), red, 64), far_world(plan), red).atlas
    error = relative_error(*shown(plan, atlas, constant(0), red))
    assert error.max() < 0.1


def test_half_precision_will_do() -> None:
    plan = sphere()
    samples = samples_of(plan, own_glossy, CHEQUERS)
    half = replace(
        samples,
        square=samples.square.astype(np.float16),
        radiance=samples.radiance.astype(np.float16),
        diffuse=samples.diffuse.astype(np.float16),
    )
    error = relative_error(*shown(plan, fit(half, far_world(plan), CHEQUERS).atlas, own_glossy, CHEQUERS))
    assert np.median(error) < 0.01


def test_nearness_is_the_median_of_what_was_met() -> None:
    plan = sphere()
    rays = room(plan, 2.5)
    astray = np.random.default_rng(4).random(rays.nothing.shape) < 0.1
    point = np.where(astray[..., None], rays.point * 0.5, rays.point)
    nearness = fit_nearness(replace(rays, point=point), plan, np.zeros(3, dtype=np.float32), 100)
    assert nearness.shape == (NEARNESS_SIZE, NEARNESS_SIZE)
    assert np.mean(np.abs(1 / nearness - 2.5) < 0.01) > 0.97
    nothing = fit_nearness(far_world(plan), plan, np.zeros(3, dtype=np.float32), 100)
    np.testing.assert_allclose(nothing, 0.01, rtol=1e-5)


def test_mirrored_rays_leave_on_the_normals_other_side() -> None:
    plan = sphere()
    square = squares(len(plan.texel), 16)
    local = square_to_direction(square)
    t, b, n = (f.reshape(-1, 1, 3)[: len(plan.texel)] for f in (plan.tangent, plan.bitangent, plan.normal))
    viewer = local[..., :1] * t + local[..., 1:2] * b + local[..., 2:] * n
    r = mirrored(plan, square)
    np.testing.assert_allclose(viewer + r, 2 * local[..., 2:] * n, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(r, axis=-1), 1, atol=1e-6)


def test_cells_are_numbered_along_rows_and_the_rim_is_theirs() -> None:
    np.testing.assert_array_equal(cells_of(cell_centres(5), 5), np.arange(25).reshape(5, 5))
    rim = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]], float)
    np.testing.assert_array_equal(cells_of(rim, 5), [0, 4, 20, 24])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("count", [100, 1000, 10_000])
def test_shifts_cover_the_square_evenly(count: int, seed: int) -> None:
    """Star discrepancy, tried at a grid of corners: random places would have about 1 / sqrt(count)."""
    shifts = spread_shifts(count, seed)
    assert shifts.shape == (count, 2)
    assert 0 <= shifts.min() <= shifts.max() < 1
    corners = np.arange(1, 33) / 32
    inside = shifts[:, None] < corners[:, None]  # (count, 32, 2)
    share = inside[..., 0].T.astype(float) @ inside[..., 1].astype(float) / count
    assert np.abs(share - corners[:, None] * corners).max() < 4 / count**0.9


def test_neighbouring_texels_are_shifted_far_from_each_other() -> None:
    shifts = spread_shifts(200, 0)
    apart = np.abs(shifts[:, None] - shifts)
    distance = np.linalg.norm(np.minimum(apart, 1 - apart), axis=-1)
    np.fill_diagonal(distance, 1)
    assert distance.min() > 0.5 / np.sqrt(200)
    assert not np.allclose(shifts, spread_shifts(200, 1))
