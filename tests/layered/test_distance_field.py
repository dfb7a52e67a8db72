# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through closed glass, beside what optics says of a ball and of a plate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.files.arrangement import field_beside, layers_beside
from radtex_addon.forms.layered.lookup.distance_field import (
    FAINT,
    TAILS,
    DistanceField,
    FieldFacts,
    columns_of,
    follow,
    image_size,
    reflected,
)
from radtex_addon.forms.layered.lookup.environment import Around, Pictures
from radtex_addon.forms.layered.lookup.ways import shown_through
from tests.layered.made_up import BALL, field_of_ball

COUNT = 400
IOR = 1.45


def seen(seed: int, least: float = 0.25) -> tuple[Floats, Floats]:
    """Unit normals and viewers (N, 3), whose cosine is no less: less than half is reflected then."""
    rng = np.random.default_rng(seed)
    normal, viewer = (normalised(rng.normal(size=(4 * COUNT, 3))) for _ in range(2))
    fit = np.flatnonzero((normal * viewer).sum(axis=1) > least)[:COUNT]
    return normal[fit].astype(np.float32), viewer[fit].astype(np.float32)


def fresnel(first: Floats, second: Floats) -> Floats:
    """What is reflected between angles of incidence and of refraction, in radians."""
    across = np.sin(first - second) / np.sin(first + second)
    along = np.tan(first - second) / np.tan(first + second)
    share: Floats = (across**2 + along**2) / 2
    return share


def test_a_ball_bends_rays_twice() -> None:
    """By twice the angle between incidence and refraction, in the plane of both."""
    normal, viewer = seen(1)
    chief, *_ = follow(field_of_ball((48, 48, 48)), BALL * normal, normal, viewer)
    first = np.arccos((normal * viewer).sum(axis=1))
    second = np.arcsin(np.sin(first) / IOR)
    turned = np.arccos(np.clip((-viewer * chief.direction).sum(axis=1), -1, 1))
    assert turned == pytest.approx(2 * (first - second), abs=0.02)
    assert np.abs(turned - 2 * (first - second)).mean() < 8e-3
    across = normalised(np.cross(normal, viewer))
    assert np.abs((across * chief.direction).sum(axis=1)).max() < 0.02
    left = (1 - fresnel(first, second)) ** 2
    assert chief.weight == pytest.approx(left, abs=0.01)


def test_the_second_way_is_reflected_once_within() -> None:
    normal, viewer = seen(2)
    _, second_way, _ = follow(field_of_ball((48, 48, 48)), BALL * normal, normal, viewer)
    first = np.arccos((normal * viewer).sum(axis=1))
    second = np.arcsin(np.sin(first) / IOR)
    reflected = fresnel(first, second)
    wanted = (1 - reflected) ** 2 * reflected
    bright = wanted > 0.03
    assert bright.sum() > COUNT / 4
    assert second_way.weight[bright] == pytest.approx(wanted[bright], abs=0.01)
    deflection = np.cos(np.pi + 2 * first - 4 * second)  # of a rainbow's ray
    found = (-viewer * second_way.direction).sum(axis=1)
    assert found[bright] == pytest.approx(deflection[bright], abs=0.05)


@pytest.mark.parametrize("mirrors", [False, True])
def test_surfaces_beyond_the_first_two_tint_light(mirrors: bool) -> None:
    """A ray that is reflected within a ball meets three surfaces, of which mirrors may be white."""
    normal, viewer = seen(3)
    ball, tint = field_of_ball((48, 48, 48)), np.array([0.5, 0.75, 1.0])
    facts = replace(ball.facts, tint=tuple(tint.tolist()), tints_reflections=mirrors)
    field = replace(ball, facts=facts)
    chief, once, around = follow(field, BALL * normal, normal, viewer)
    assert set(chief.tints) == {0}
    assert set(once.tints[once.weight > 0]) == {int(mirrors)}
    direction = panorama_directions(32)
    white = Pictures.of(direction, np.ones_like(direction), 16)
    sky = Around(np.zeros(3, np.float32), white, (), ())
    shown = shown_through(field, sky, BALL * normal, normal, viewer)
    even = (chief.weight + around.weight) + tint[:, None] ** int(mirrors) * once.weight
    assert shown == pytest.approx(even, abs=1e-3)


def plate(facts: FieldFacts) -> DistanceField:
    """The field of a plate across z, from -0.5 to 0.5."""
    height = facts.low[2] + facts.step * np.arange(facts.size[2])
    values = np.zeros((*facts.size[::-1], 4), dtype=np.float32)
    values[..., 2] = np.sign(height)[:, None, None]
    values[..., 3] = ((np.abs(height) - 0.5) / facts.step)[:, None, None]
    return DistanceField(values, facts)


FACTS = FieldFacts((40, 40, 40), np.array([-1.95, -1.95, -1.95], np.float32), 0.1, 1.5, 1e-3, 4)


def test_a_plate_moves_rays_aside_and_widens_them() -> None:
    viewer = normalised(np.array([[0.3, 0.2, 1.0], [0, 0, 1.0]])).astype(np.float32)
    offset = np.array([[0, 0, 0.5]] * 2, dtype=np.float32)
    chief, once, _ = follow(plate(FACTS), offset, np.array([[0, 0, 1.0]] * 2, np.float32), viewer)
    assert chief.direction == pytest.approx(-viewer, abs=1e-5)
    before = viewer[:, 2]
    within = np.sqrt(1 - (1 - before**2) / 2.25)
    steeper, turn = 1.5 * within / before, before - 1.5 * within  # in the plane of incidence, and across it
    entered = ((1 - 1 / steeper) ** 2 + (turn / 1.5) ** 2) / 2
    left = ((steeper**2 + 2.25) * entered + (1 - steeper) ** 2 + turn**2) / 2
    assert left[1] == pytest.approx(0.5)
    assert chief.variance == pytest.approx(TAILS * 1e-3 * left, rel=1e-3)
    inner = normalised(np.append(-viewer[0, :2] / 1.5, -np.sqrt(1 - (viewer[0, :2] ** 2).sum() / 2.25)))
    below = offset[0] + inner / -inner[2]
    back = chief.place[0] - chief.direction[0] * ((chief.place[0, 2] + 0.5) / chief.direction[0, 2])
    assert back == pytest.approx(below, abs=0.02)
    assert once.variance[1] == pytest.approx(TAILS * 9.5e-3)  # reflected within, and refracted


def test_edges_bend_no_light_where_no_face_does() -> None:
    """Through a cube, beside its edges: out at the bottom as light came in, or mirrored by a side before."""
    axis = FACTS.low[0] + FACTS.step * np.arange(40)
    place = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).transpose(2, 1, 0, 3)
    side = np.abs(place).argmax(axis=-1)[..., None]
    values = np.zeros((40, 40, 40, 4), dtype=np.float32)
    np.put_along_axis(values, side, np.sign(np.take_along_axis(place, side, -1)), -1)
    beyond = np.abs(place) - 1
    values[..., 3] = (
        np.linalg.norm(np.maximum(beyond, 0), axis=-1) + np.minimum(beyond.max(axis=-1), 0)
    ) / 0.1
    cube = DistanceField(values, replace(FACTS, slopes=0.0))
    rng = np.random.default_rng(8)
    count = 2000
    start = np.column_stack([rng.uniform(-1, 1, (count, 2)), np.ones(count)]).astype(np.float32)
    viewer = normalised(np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), np.ones(count)])).astype(
        np.float32
    )
    chief, *_ = follow(cube, start, np.tile(np.array([0, 0, 1], np.float32), (count, 1)), viewer)
    bent = np.abs(np.abs(chief.direction) - np.abs(viewer)).max(axis=1)
    assert (bent[chief.weight > 0] > 0.01).mean() < 0.05  # 0.18 with normals that are mixed
    assert (chief.weight > 0).all()


def refracted(ray: Floats, ahead: Floats, ratio: float) -> Floats:
    """Unit directions of rays beyond a surface, of the index of refraction before over that behind it."""
    cosine = (ray * ahead).sum(axis=-1, keepdims=True)
    beyond = np.sqrt(1 - ratio**2 * (1 - cosine**2))
    turned: Floats = ratio * ray + (beyond - ratio * cosine) * ahead
    return turned


def test_rough_glass_spreads_rays_as_much_as_its_slopes_and_its_shape_do() -> None:
    """Beside many rays through a ball whose normals are turned by chance."""
    slopes, rng = 1e-4, np.random.default_rng(5)
    normal, viewer = seen(6, 0.4)
    chief, *_ = follow(field_of_ball((48, 48, 48), slopes), BALL * normal, normal, viewer)
    shape = (500, len(normal), 3)

    def rough(normals: Floats) -> Floats:
        return normalised(normals + np.sqrt(slopes) * rng.normal(size=shape))

    inner = refracted(-np.broadcast_to(viewer, shape), -rough(normal), 1 / IOR)
    left = normalised(normal - 2 * (inner * normal).sum(axis=-1, keepdims=True) * inner)
    ray = refracted(inner, rough(left), IOR)
    apart = ray - ray.mean(axis=0)
    spread = (apart**2).sum(axis=-1).mean(axis=0) / 2
    assert np.median(chief.variance / TAILS / spread) == pytest.approx(1, abs=0.1)
    assert chief.variance / TAILS == pytest.approx(spread, rel=0.3)
    across = left - left.mean(axis=0)
    back = BALL * (across * apart).sum(axis=-1).mean(axis=0) / (2 * spread)  # to where they are narrowest
    from_there = ((left.mean(axis=0) * BALL - chief.place) * chief.direction).sum(axis=1)
    assert from_there == pytest.approx(np.maximum(back, 0), abs=0.2 * BALL)


def test_no_light_of_clear_glass_is_lost() -> None:
    normal, viewer = seen(7, 0.0)
    ball = field_of_ball((48, 48, 48))
    whole = replace(ball, facts=replace(ball.facts, all_around=1.0))
    ways = follow(whole, BALL * normal, normal, viewer)
    entered = 1 - reflected((normal * viewer).sum(axis=1), IOR)
    assert sum(way.weight for way in ways) == pytest.approx(entered, abs=FAINT + 1e-6)


def test_rays_are_lost_after_too_many_reflections() -> None:
    """Across a plate, whose rim lies outside of the field, at an angle at which nothing gets out."""
    field = plate(replace(FACTS, reflections=0))
    normal, viewer = seen(3)
    ball = field_of_ball((32, 32, 32))
    kept = follow(ball, BALL * normal, normal, viewer)
    lost = follow(replace(ball, facts=replace(ball.facts, reflections=0)), BALL * normal, normal, viewer)
    assert (lost[0].weight == kept[0].weight).all()
    assert kept[1].weight.any()
    assert not lost[1].weight.any()
    up = np.array([[0, 0, 1.0]], np.float32)
    chief, once, _ = follow(field, 0.5 * up, up, up)
    assert chief.weight == pytest.approx(0.96**2, abs=1e-3)
    assert not once.weight.any()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e30])
@pytest.mark.parametrize("slopes", [0.0, 1e-3])
@pytest.mark.parametrize("damaged", [slice(None), slice(3), slice(3, None)])
def test_what_is_no_number_lets_nothing_through(value: float, slopes: float, damaged: slice) -> None:
    """As in a damaged file, in all of it, in its normals or its distances."""
    ball, (normal, viewer) = field_of_ball((16, 16, 16), slopes), seen(4)
    values = ball.values.copy()
    values[6:10, 6:10, 6:10, damaged] = value
    for way in follow(replace(ball, values=values), BALL * normal, normal, viewer):
        some = way.weight > 0
        assert np.isfinite(way.place[some]).all()
        assert np.isfinite(way.direction[some]).all()
        assert np.isfinite(way.variance[some]).all()


def test_a_field_comes_back_from_its_image() -> None:
    field = field_of_ball((9, 11, 14))
    image = layers_beside(field)
    assert image.shape[1::-1] == image_size(field.facts.size)
    assert columns_of(field.facts.size) == 4
    assert (image[:11, :9] == field.values[0]).all()
    assert (image[11:22, 9:18] == field.values[5]).all()
    assert (field_beside(image, field.facts).values == field.values).all()
