# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways through an object: their buckets, their choice among paths that disagree, and what they show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.bake.light_samples import straight_through
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.pooling import SHARE, Neighbours
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.forms.layered.capture.exits import in_texels_frames
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.fit.bucket_grid import BucketGrid
from radtex_addon.forms.layered.fit.texel_maps import texel_middles
from radtex_addon.forms.layered.fit.through import fit_through_rest, fit_ways
from radtex_addon.forms.layered.lookup.atlas import look_up
from radtex_addon.forms.layered.lookup.environment import Around, Pictures, Plane, SurroundingLayer
from radtex_addon.forms.layered.lookup.ways import (
    CHANNELS,
    Through,
    agreeing,
    look_through,
    shown_of,
    square_taps,
)
from radtex_addon.forms.layered.samples import ExitSamples
from tests.layered.made_up import flat_plan, light_samples

SIDE, CELLS, TIMES = 10, 4, 3
EYE = np.array([0.0, 0.0, 3.0])
HEIGHT = -1.0
AXES = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], dtype=np.float32)  # of the sheet: T, Bt, N


def sheet() -> CapturePlan:
    return flat_plan(SIDE, CELLS, AXES)


def straight_exits(plan: CapturePlan, astray: float) -> ExitSamples:
    """Paths straight through, of which a share goes somewhere else altogether."""
    rng = np.random.default_rng(4)
    count = len(plan.texel)
    local = -square_to_direction(cell_centres(CELLS).reshape(-1, 2)).astype(np.float32)
    direction = np.broadcast_to(local, (TIMES, count, CELLS**2, 3)).copy()
    lost = rng.random(direction.shape[:3]) < astray
    other = rng.normal(size=(int(lost.sum()), 3))
    direction[lost] = other / np.linalg.norm(other, axis=1, keepdims=True)
    weight = np.full(direction.shape[:3], 0.8, dtype=np.float32)
    return ExitSamples(plan, weight, direction, np.zeros_like(direction), np.ones((count, 3), np.float32))


def floor(light: Floats, direction: Floats) -> Around:
    """A floor that is seen from above, in a black world."""
    black = Pictures.of(direction, np.zeros((len(direction), 3)), 64)
    picture = Pictures.of(direction, light, 256)
    plane = Plane(np.array([0, 0, 1], np.float32), HEIGHT, EYE.astype(np.float32))
    return Around(np.zeros(3, np.float32), black, (SurroundingLayer(picture, plane),), ())


def stripes_below() -> Around:
    """A floor that is bright where x > 0.25."""
    direction = panorama_directions(1024).reshape(-1, 3)
    below = direction[:, 2] < -0.02
    met = EYE + direction * ((HEIGHT - EYE[2]) / np.where(below, direction[:, 2], -1))[:, None]
    light = np.where((met[:, 0] > 0.25) & below, 1.0, 0.0)
    return floor(np.stack([light, light, light, below], axis=1), direction)


def test_taps_say_where_a_viewer_stands_between_cells() -> None:
    centres = cell_centres(CELLS).reshape(-1, 2)
    square = np.random.default_rng(1).uniform(-0.7, 0.7, (50, 2))
    cells, weights = square_taps(square, CELLS)
    np.testing.assert_allclose((weights[..., None] * centres[cells]).sum(axis=0), square, atol=1e-6)
    np.testing.assert_allclose(weights.sum(axis=0), 1, rtol=1e-6)


def test_paths_that_go_astray_do_not_lead_the_way() -> None:
    plan = sheet()
    straight, ways = (fit_ways(straight_exits(plan, share), Neighbours(plan)) for share in (0.0, 0.2))
    np.testing.assert_allclose(straight[3], 0.8, rtol=1e-4)
    length = np.linalg.norm(ways[:3], axis=0)
    cosine = (ways[:3] * straight[:3]).sum(axis=0) / (length * 0.8)
    assert (cosine < 0.97).mean() < 0.01
    assert ways[3].mean() == pytest.approx(0.8 * 0.8, rel=0.1)  # what goes astray is no part of the way


def test_a_line_is_told_from_its_texel_in_its_frame() -> None:
    plan = sheet()
    count = len(plan.texel)
    direction = np.tile(np.array([0, 0, -1], np.float32), (1, count, 1, 1))
    point = plan.points[None, :, None] + np.array([0.3, 0.0, -2.0], np.float32)
    local, place = in_texels_frames(plan, direction, point)
    np.testing.assert_allclose(local[0, 0, 0], [0, 0, -1], atol=1e-6)
    np.testing.assert_allclose(place[0, :, 0], np.tile([0, -0.3, 0], (count, 1)), atol=1e-5)  # -X is Bt


def test_a_clear_sheet_shows_the_floor_where_it_is() -> None:
    plan = sheet()
    ways = fit_ways(straight_exits(plan, 0.0), Neighbours(plan))
    through = Through(
        plan.placed(np.moveaxis(ways, 0, -1).reshape(-1, CELLS, CELLS, CHANNELS)),
        np.ones((1, 1, 3), np.float32),
        np.zeros((1, 1, 1, 1, 3), np.float32),
    )
    count = 200
    rng = np.random.default_rng(2)
    uv = rng.uniform(0.1, 0.9, (count, 2)).astype(np.float32)
    offset = np.concatenate([uv, np.zeros((count, 1), np.float32)], axis=1)
    local = square_to_direction(np.array([0.25, -0.25])).astype(np.float32)  # in the middle of a cell
    viewer = np.tile(local @ AXES, (count, 1))
    frame = (np.tile(AXES[0], (count, 1)), np.tile(AXES[1], (count, 1)), np.tile(AXES[2], (count, 1)))
    seen = look_through(through, stripes_below(), uv, offset, frame, viewer)
    met = offset[:, 0] - viewer[:, 0] / viewer[:, 2] * -HEIGHT
    clear = np.abs(met - 0.25) > 0.08
    np.testing.assert_allclose(seen[0][clear], 0.8 * (met[clear] > 0.25), atol=0.1)
    assert 0.2 < (met > 0.25).mean() < 0.8


def test_where_ways_part_the_strongest_is_followed() -> None:
    down, aside = np.array([0, 0, -1.0]), np.array([1.0, 0, 0])
    way = [np.concatenate([share * to, [share, 0, 0, 0, 0]]) for share, to in ((0.5, down), (0.3, aside))]
    near = 0.1 * (down + 0.1 * aside) / np.linalg.norm(down + 0.1 * aside)
    way.append(np.concatenate([near, [0.1, 0, 0, 0, 0]]))
    found = agreeing(np.stack(way)[:, None].astype(np.float32))[0]
    assert found[3] == pytest.approx(0.9)  # as bright as all of them
    direction = found[:3] / np.linalg.norm(found[:3])
    expected = 0.5 * down + near
    np.testing.assert_allclose(direction, expected / np.linalg.norm(expected), atol=1e-5)


def test_ways_that_disagree_are_blurred() -> None:
    around = stripes_below()
    x, y, z = (axis[None].astype(np.float32) for axis in np.eye(3))
    sides = np.array([[0.6, 0, -0.8], [-0.6, 0, -0.8]], np.float32)
    mixed = np.concatenate([sides.mean(axis=0), [1, 0, 0, 0, 0]]).astype(np.float32)[None]
    sharp = np.array([[0, 0, -1, 1, 0, 0, 0, 0]], np.float32)
    offset = np.array([[0.35, 0, 0]], np.float32)
    at_edge, blurred = (shown_of(around, way, offset, (x, y, z))[0, 0] for way in (sharp, mixed))
    assert at_edge > 0.9
    assert 0.3 < blurred < 0.85


def test_how_much_gets_through_is_even_where_ways_go_alike_and_their_own_where_they_part() -> None:
    plan = sheet()
    exits = straight_exits(plan, 0.0)
    down = np.broadcast_to(np.array([0, 0, -1], np.float32), exits.direction.shape)
    weight = exits.weight * np.random.default_rng(3).uniform(0.5, 1.5, exits.weight.shape)
    noisy = replace(exits, weight=weight.astype(np.float32), direction=down)
    ways = fit_ways(noisy, Neighbours(plan))
    assert ways[3].mean() == pytest.approx(0.8, rel=0.02)
    alone = noisy.weight.mean(axis=0).std()
    texels_left, cells_left = SHARE, (0.25**2 + 0.5**2 + 0.25**2) ** 2  # of the variance; at borders more
    assert ways[3].std() < 1.5 * alone * (texels_left * cells_left) ** 0.5
    left = cell_centres(CELLS).reshape(-1, 2)[:, 0] < 0
    direction = np.where(left[:, None], np.array([0, 0, 1], np.float32), exits.direction)
    apart = replace(exits, direction=direction, weight=np.where(left, np.float32(0.2), exits.weight))
    ways = fit_ways(apart, Neighbours(plan))
    np.testing.assert_allclose(ways[3], np.broadcast_to(np.where(left, 0.2, 0.8), ways[3].shape), rtol=1e-3)


@pytest.mark.parametrize("right", [1.0, 0.4])
def test_ways_that_are_seldom_right_are_dimmed_and_the_rest_makes_up_for_it(right: float) -> None:
    """Samples show what the ways do, or something else by chance."""
    plan, around, rng = sheet(), stripes_below(), np.random.default_rng(6)
    ways = fit_ways(straight_exits(plan, 0.0), Neighbours(plan))
    buckets = plan.placed(np.moveaxis(ways, 0, -1).reshape(-1, CELLS, CELLS, CHANNELS))
    white, none = np.ones((SIDE, SIDE, 3), np.float32), np.zeros((1, 1, 1, 1, 3), np.float32)
    through = Through(buckets, white, none)
    square = rng.uniform(-1, 1, (len(plan.texel), 64, 2)).astype(np.float16)
    viewer = -straight_through(plan, square.astype(np.float32)).reshape(-1, 3)
    texel = np.arange(len(plan.texel)).repeat(64)
    frame = (plan.frames[texel, 0], plan.frames[texel, 1], plan.frames[texel, 2])
    shown = look_through(through, around, texel_middles(plan)[texel], plan.points[texel], frame, viewer).T
    by_chance = rng.random(len(texel)) > right
    shown[by_chance] = rng.permutation(shown)[by_chance]
    light = light_samples(plan, square, through=shown.reshape(len(plan.texel), 64, 3))
    fitted = fit_through_rest(through, light, around, light.seen, BucketGrid.of(plan, 1))
    assert fitted.colour == pytest.approx(np.full_like(white, right), abs=0.08)
    seen = look_through(fitted, around, texel_middles(plan)[texel], plan.points[texel], frame, viewer)
    rest = look_up(fitted.rest, texel_middles(plan)[texel], -viewer)
    assert (seen + rest).mean() == pytest.approx(shown.mean(), rel=0.1)
