# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the layered layout, each against what is known of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from radtex_addon.bake.light_samples import Axis, LobeSamples, mirrored, spread_shifts
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.octahedron import cell_directions, direction_to_octahedron, octahedron_cell
from radtex_addon.cycles.portal import Aim
from radtex_addon.forms.layered.capture.panoramas import panorama_directions
from radtex_addon.forms.layered.capture.stored_surroundings import around_of, arrays_of
from radtex_addon.forms.layered.capture.world_lights import with_world_lights
from radtex_addon.forms.layered.fit.bucket_grid import BucketGrid
from radtex_addon.forms.layered.fit.buckets import free_share
from radtex_addon.forms.layered.fit.lobes import Paths, fit_materials
from radtex_addon.forms.layered.fit.residual import fit_rest, mean_brightness
from radtex_addon.forms.layered.fit.widths import fit_lobes
from radtex_addon.forms.layered.lookup.environment import (
    Around,
    Impostor,
    Lamp,
    Lit,
    Pictures,
    Plane,
    Shell,
    SurroundingLayer,
    lamps_of,
)
from radtex_addon.forms.layered.lookup.lamp_shapes import LampShape, ShapeKind
from radtex_addon.forms.layered.lookup.lobes import STEPS, Brushed, Material, lobe, seen_free
from tests.layered.made_up import flat_plan, places_of
from tests.layered_lookups import case_of

SIDE = 12  # texels of a flat atlas
CELLS = 8


def random_directions(count: int, seed: int = 1) -> Floats:
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return (found / np.linalg.norm(found, axis=1, keepdims=True)).astype(np.float32)


def flat_samples(cells: int) -> LobeSamples:
    square = Aim(spread_shifts(SIDE * SIDE, 3)).square(cells)
    shape = square.shape[:2]
    values, used = np.zeros((*shape, 3), dtype=np.float32), np.ones(shape, dtype=bool)
    return LobeSamples(flat_plan(SIDE, cells), Axis.MIRROR, square, values, used)


def test_a_picture_of_one_colour_has_it_at_every_blur() -> None:
    direction = panorama_directions(128).reshape(-1, 3)
    picture = Pictures.of(direction, np.full((len(direction), 4), [0.2, 0.4, 0.8, 1.0]), 32)
    seen = picture.look(random_directions(500), np.geomspace(1e-6, 1, 500).astype(np.float32))
    np.testing.assert_allclose(seen, np.array([[0.2, 0.4, 0.8, 1.0]]).T.repeat(500, axis=1), rtol=1e-3)


def test_panoramas_look_along_y_and_have_x_to_the_right() -> None:
    direction = panorama_directions(64)
    assert direction.shape == (32, 64, 3)
    seen = direction[[16, 16, -1], [32, 48, 0]]
    np.testing.assert_allclose(seen, [[0, 1, 0], [1, 0, 0], [0, 0, 1]], atol=0.1)


def test_rays_meet_a_plane_where_it_is() -> None:
    plane = Plane(np.array([0, 0, 1], dtype=np.float32), -1.0)
    offset = np.array([[0.5, 0, 0], [0.5, 0, 0]], dtype=np.float32)
    axis = np.array([[0.6, 0, -0.8], [0, 0, 1]], dtype=np.float32)
    met, wider, cover = plane.meet(offset, axis, np.full(2, 1e-8, np.float32))
    distance = np.hypot(1.25, 1)
    np.testing.assert_allclose(met[0], np.array([1.25, 0, -1]) / distance, rtol=1e-5)
    np.testing.assert_allclose(wider[0], (1.25 / distance) ** 2 / distance / 0.8, rtol=1e-4)
    np.testing.assert_allclose(cover, [1, 0], atol=1e-6)


def test_rays_meet_a_room_s_walls_where_they_are_from_inside() -> None:
    rng = np.random.default_rng(4)
    normals = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32)
    eye = np.array([0.5, -0.2, 0.3], dtype=np.float32)
    shell = Shell(normals, np.array([-2, -1, -0.5, -2, -1, -1.5], dtype=np.float32), eye)
    low, high = np.array([-2, -1, -0.5]), np.array([2, 1, 1.5])
    offset = rng.uniform(low, high, (100, 3)).astype(np.float32)
    axis = normalised(rng.normal(size=(100, 3))).astype(np.float32)
    far = np.min(np.maximum((low - offset) / axis, (high - offset) / axis), axis=1, keepdims=True)
    met, _, cover = shell.meet(offset, axis, np.full(100, 1e-4, np.float32))
    place = offset + far * axis
    np.testing.assert_allclose(met, normalised(place - eye), atol=1e-4)
    np.testing.assert_allclose(shell.seen_at(met.astype(np.float32)), place, atol=2e-3)
    assert (cover == 1).all()
    # from the eye all is as wide as it is, from nearby a wall it is narrower there:
    np.testing.assert_allclose(
        shell.meet(np.tile(eye, (100, 1)), axis, np.full(100, 1e-4, np.float32))[1], 1, rtol=1e-3
    )
    near = np.array([[-1.9, 0, 0.3]], dtype=np.float32)
    (narrow,) = shell.meet(near, np.array([[-1, 0, 0]], np.float32), np.full(1, 1e-4, np.float32))[1]
    assert narrow < 0.01


def test_what_leaves_an_open_room_is_seen_far_away() -> None:
    normals = np.array([[0, 0, 1], [1, 0, 0]], dtype=np.float32)
    shell = Shell(normals, np.array([-1, -1], dtype=np.float32), np.zeros(3, dtype=np.float32))
    up = normalised(np.array([[0.1, 0.2, 1]], dtype=np.float32))
    met, wider, _ = shell.meet(np.array([[5, 3, 0]], np.float32), up, np.full(1, 1e-4, np.float32))
    np.testing.assert_allclose(met, up, atol=1e-4)
    assert wider[0] == pytest.approx(1, rel=1e-3)


def test_a_plane_takes_the_share_of_a_lobe_that_is_below_its_horizon() -> None:
    rng, count, width = np.random.default_rng(8), 200_000, 0.03
    plane = Plane(np.array([0, 0, 1], dtype=np.float32), -1.0)
    up = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    for rise in (-0.045, 0.0, 0.03):
        axis = np.array([np.cos(rise), 0, np.sin(rise)], dtype=np.float32)
        rays = spread_by_lobe(rng, np.tile(axis, (count, 1)), up, np.full(count, width**2))
        met, _, cover = plane.meet(np.zeros((1, 3)), axis[None], np.full(1, width**2, np.float32))
        sines = rays[:, 2]
        np.testing.assert_allclose(cover, (sines < 0).mean(), atol=0.01)
        np.testing.assert_allclose(-met[0, 2], -sines[sines < 0].mean(), rtol=0.1)


def test_rays_meet_a_sphere_around_the_middle_exactly() -> None:
    direction = random_directions(200_000)
    impostor = Impostor.of(direction, np.full(len(direction), 2.0))
    offset, axis = random_directions(300, 2) * 0.7, random_directions(300, 3)
    met, wider, cover = impostor.meet(offset, axis, np.full(300, 1e-4, np.float32))
    along = (offset * axis).sum(axis=1)
    far = np.sqrt(along**2 - (offset**2).sum(axis=1) + 4) - along
    np.testing.assert_allclose(met, (offset + far[:, None] * axis) / 2, atol=1e-4)
    np.testing.assert_allclose(wider, (far / 2) ** 2, rtol=2e-3)
    assert (cover == 1).all()


def test_a_layer_hides_what_is_behind_it_as_far_as_it_covers() -> None:
    direction = panorama_directions(128).reshape(-1, 3)
    cover = np.where(direction[:, 2:] < 0, 1.0, 0.0)
    picture = Pictures.of(direction, np.concatenate([cover * [0.5, 0, 0], cover], axis=1), 64)
    layer = SurroundingLayer(picture, Plane(np.array([0, 0, 1], dtype=np.float32), -1.0))
    world = Pictures.of(direction, np.ones((len(direction), 3)), 64)
    around = Around(np.zeros(3, np.float32), world, (layer,), ())
    axis = np.array([[0, 0, -1], [0, 0, 1]], dtype=np.float32)
    seen = around.look(np.zeros((2, 3)), axis, np.full(2, 1e-6, np.float32))
    np.testing.assert_allclose(seen.T, np.array([[0.5, 0.0, 0.0], [1.0, 1.0, 1.0]]), atol=1e-3)


def test_a_lamp_sends_all_its_light_however_blurred() -> None:
    size = 256
    direction = cell_directions(size).astype(np.float32)
    lit = direction @ np.array([0, 0, 1.0]) > np.cos(0.1)
    radiance = np.where(lit[:, None], 5.0, 0.0) * np.ones(3)
    (lamp,) = lamps_of(direction, radiance, [np.array([0, 0, 2.0])])
    solid = 2 * np.pi * (1 - np.cos(0.1))
    np.testing.assert_allclose(lamp.irradiance, 5 * solid, rtol=0.05)
    np.testing.assert_allclose(lamp.variance, 0.1**2 / 4, rtol=0.1)  # of a disc, along each axis
    for wide in (0.01, 0.1):
        seen = lamp.light(np.zeros_like(direction), direction, np.full(len(direction), wide, np.float32))
        share = 4 * np.abs(direction).sum(axis=1) ** 3 / size**2
        np.testing.assert_allclose((seen * share).sum(axis=1), lamp.irradiance, rtol=0.05)


def test_a_surface_mirrors_a_sun_outdoors_only_where_its_light_falls() -> None:
    """Lit by the sun, half of it, in its shadow, in its shadow beside other light, and of a black metal."""
    dark = Pictures.of(cell_directions(8).astype(np.float32), np.zeros((64, 3)), 8)
    sun = Lamp(np.array([0, 0, 1e4], np.float32), np.array([2, 2, 2], np.float32), 1e-4, behind=True)
    around = Around(np.zeros(3, np.float32), dark, (), (sun,))
    up = np.tile(np.array([0, 0, 1], np.float32), (5, 1))
    irradiance = np.array([2.4, 1.1, 0.0, 0.2, 0.0])[:, None] * np.ones(3) / np.pi
    colour = np.array([0.5, 0.5, 0.5, 0.5, 0.0])[:, None] * np.ones(3)
    here, wide = np.zeros((5, 3)), np.full(5, 1e-3, np.float32)
    whole = around.look(here, up, wide)
    seen = around.look(here, up, wide, Lit.of(up, irradiance, colour))
    assert whole.min() > 100
    np.testing.assert_allclose(seen / whole, np.array([[1, 0.5, 0, 0, 1]] * 3), atol=1e-3)


def test_a_lamp_twice_as_far_is_a_quarter_as_bright() -> None:
    lamp = Lamp(np.array([0, 0, 2.0], np.float32), np.ones(3), 1e-3)
    axis, wide = np.array([[0, 0, 1]], np.float32), np.full(1, 0.1, np.float32)
    here = lamp.light(np.zeros((1, 3), np.float32), axis, wide)
    beyond = lamp.light(np.array([[0, 0, -2.0]], np.float32), axis, wide)
    np.testing.assert_allclose(beyond / here, 0.25, rtol=0.02)


def fitted_to(widths: Sequence[float], shares: Sequence[float]) -> Material:
    """What is fitted to paths near N.V = 0.63 that lobes of these widths spread."""
    rng, count = np.random.default_rng(5), 60_000
    normal = np.broadcast_to(np.array([0, 0, 1.0]), (count, 3))
    cosine = rng.uniform(0.6, 0.66, count)
    axis = np.stack([np.sqrt(1 - cosine**2), np.zeros(count), cosine], axis=1)
    variance: Floats = rng.choice(np.square(widths), count, p=shares)
    end = spread_by_lobe(rng, axis, normal, variance)
    weight = np.tile([0.9, 0.5, 0.1], (count, 1))
    number = np.arange(count)
    paths = Paths(number, weight, end, axis, normal, cosine, np.zeros(count, dtype=np.int32))
    return fit_materials(paths, 1)[0]


def test_a_lobe_that_tells_all_is_alone() -> None:
    for width in (0.02, 0.4):
        material = fitted_to([width], [1])
        assert not material.weight[1].any()
        np.testing.assert_allclose(np.sqrt(material.variance), width, rtol=0.05)
        np.testing.assert_allclose(material.weight[0], [[0.9, 0.5, 0.1]] * STEPS, rtol=1e-3)


def test_lobes_are_found_in_paths_that_are_spread_by_them() -> None:
    material = fitted_to([0.02, 0.2], [0.7, 0.3])
    shares, variances, bends = material.at(np.array([0.63]))
    np.testing.assert_allclose(shares[:, :, 0].sum(axis=0), [0.9, 0.5, 0.1], rtol=1e-3)
    np.testing.assert_allclose(shares[0, :, 0] / [0.9, 0.5, 0.1], 0.7, atol=0.05)
    np.testing.assert_allclose(np.sqrt(variances[:, 0]), [0.02, 0.2], rtol=0.1)
    np.testing.assert_allclose(bends, 0, atol=0.01)


def spread_by_lobe(rng: np.random.Generator, axis: Floats, normal: Floats, variance: Floats) -> Floats:
    """Directions (P, 3) about axes (P, 3), by lobes of widths² (P,)."""
    share = rng.random(len(axis)) / (1 + variance / 2)  # of a lobe within a squared chord, at most 4
    chord = np.sqrt(2 * variance * share / (1 - share))
    angle, turn = 2 * np.arcsin(chord / 2), rng.uniform(0, 2 * np.pi, len(axis))
    up = normal - (normal * axis).sum(axis=1, keepdims=True) * axis
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    off = np.cos(turn)[:, None] * up + np.sin(turn)[:, None] * np.cross(axis, up)
    found: Floats = np.cos(angle)[:, None] * axis + np.sin(angle)[:, None] * off
    return found


def mirrored_by_facets(viewer: Floats, rough: tuple[float, float], count: int) -> Floats:
    """Directions (P, 3) in which GGX's facets mirror a viewer (3,), as often as that sees them.

    About the normal (0, 0, 1), with the roughnesses along x and y (Heitz, "Sampling the GGX Distribution of
    Visible Normals", 2018, appendix A).
    """
    rng = np.random.default_rng(4)
    stretched = normalised(viewer * [*rough, 1])
    first = normalised(np.add(np.cross([0, 0, 1.0], stretched), [1e-9, 0, 0]))
    radius, turn = np.sqrt(rng.random(count)), rng.uniform(0, 2 * np.pi, count)
    x, y, lean = radius * np.cos(turn), radius * np.sin(turn), (1 + stretched[2]) / 2
    y = (1 - lean) * np.sqrt(1 - x * x) + lean * y
    up = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    facet = np.stack([x, y, up], axis=1) @ np.stack([first, np.cross(stretched, first), stretched])
    half = normalised(facet * [*rough, 1])
    found: Floats = 2 * (half @ viewer)[:, None] * half - viewer
    return found


@pytest.mark.parametrize("turn", [0, 40, 90])
@pytest.mark.parametrize("tilt", [0, 50, 75])
def test_brushed_metal_spreads_a_lamp_as_facets_do(tilt: float, turn: float) -> None:
    slant, around = np.radians([tilt, turn])
    viewer = np.array([np.sin(slant) * np.cos(around), np.sin(slant) * np.sin(around), np.cos(slant)])
    rough = (0.25, 0.1)
    ends, cells = mirrored_by_facets(viewer, rough, 400_000), 24
    count = np.bincount(octahedron_cell(direction_to_octahedron(ends), cells), minlength=cells**2)
    fine = cell_directions(8 * cells)
    solid = 4 * np.abs(fine).sum(axis=1) ** 3 / len(fine)

    def columns(x: float, y: float, z: float) -> Floats:
        return np.tile(np.array([[x], [y], [z]], dtype=np.float64), len(fine))

    wide = [np.full(len(fine), 2 * one**2) for one in rough]
    brushed = Brushed(columns(*viewer), columns(0, 0, 1), columns(1, 0, 0), *wide)
    shown = np.bincount(
        octahedron_cell(direction_to_octahedron(fine), cells),
        brushed.towards(fine.T, np.zeros(len(fine))) * solid,
        minlength=cells**2,
    )
    expected = count / len(ends)
    above = cell_directions(cells)[:, 2] > 0.15  # cells that the horizon does not cross
    assert expected[above].sum() > 0.5
    assert np.abs(shown - expected)[above].sum() < 0.03
    np.testing.assert_allclose(shown[above].sum(), expected[above].sum(), atol=0.01)


def test_where_the_tangent_is_not_known_metal_is_as_rough_but_round() -> None:
    fine = cell_directions(192)
    solid = 4 * np.abs(fine).sum(axis=1) ** 3 / len(fine)
    normal = np.tile(np.array([0, 0, 1.0]), (len(fine), 1))
    slant = np.radians(40)
    axis = np.tile([np.sin(slant), 0, np.cos(slant)], (len(fine), 1))
    wide = [np.full(len(fine), one) for one in (0.125, 0.02)]

    def shown(tangent: float, along: Floats, across: Floats) -> Floats:
        way = np.tile([tangent, 0, 0], (len(fine), 1))
        return Brushed.of(axis, normal, way, along, across).towards(fine.T, np.zeros(len(fine)))

    unknown, bare = shown(0.01, *wide), shown(0.0, *wide)
    alike = np.sqrt(wide[0] * wide[1])
    np.testing.assert_allclose(unknown, bare)
    np.testing.assert_allclose(unknown, shown(1.0, alike, alike), rtol=1e-4)
    assert (unknown * solid).sum() == pytest.approx(1, abs=0.03)


def test_a_brush_is_found_in_what_facets_mirror() -> None:
    rng, count = np.random.default_rng(5), 4000
    kinds = []
    for rough in ((0.3, 0.1), (0.08, 0.2), (0.15, 0.15)):
        viewer = np.array([0.3, 0.4, np.sqrt(0.75)])
        ends = mirrored_by_facets(viewer, rough, count)
        turn = rng.uniform(0, 2 * np.pi, count)
        c, s, none, one = np.cos(turn), np.sin(turn), np.zeros(count), np.ones(count)
        spin = np.stack([[c, -s, none], [s, c, none], [none, none, one]]).transpose(2, 0, 1)  # of each texel
        normal = np.tile([0, 0, 1.0], (count, 1))
        axis = spin @ (2 * viewer[2] * normal[0] - viewer)
        paths = Paths(
            np.arange(count), np.ones((count, 3)), np.einsum("pij,pj->pi", spin, ends), axis, normal,
            np.full(count, viewer[2]), np.zeros(count, dtype=np.int32),
        )  # fmt: skip
        kinds.append(fit_materials(paths, 1, spin[:, :, 0].astype(np.float32))[0])
    assert kinds[0].brush == pytest.approx((2 * 0.3**2, 2 * 0.1**2), rel=0.1)
    assert kinds[1].brush == pytest.approx((2 * 0.08**2, 2 * 0.2**2), rel=0.1)
    assert not kinds[0].weight[1].any()
    assert kinds[2].brush is None


def test_lights_of_the_world_are_lamps_that_layers_hide() -> None:
    direction = cell_directions(128).astype(np.float32)
    solid = 4 * np.abs(direction).sum(axis=1) ** 3 / len(direction)
    places = normalised(np.array([[1, 0, 0.1], [-0.5, 1, 0.6]]))
    radiance = np.full((len(direction), 3), 0.1, dtype=np.float32)
    for place, bright in zip(places, ([90, 60, 30], [20, 20, 40]), strict=True):
        radiance[direction @ place > np.cos(0.1)] += bright
    old = Around(np.zeros(3, np.float32), Pictures.of(direction, radiance, 128), (), ())
    new = with_world_lights(old, 0.02)
    assert with_world_lights(old, 0.001) is old, "sharper lobes see that lamps are round"
    assert [lamp.behind for lamp in new.lamps] == [True, True]
    for lamp, place in zip(new.lamps, places, strict=True):
        assert normalised(lamp.place) @ place > np.cos(0.01)
    left = new.world.levels[0].reshape(-1, 3)
    assert left.max() < 9 * (radiance.max(axis=1) * solid).sum() / (4 * np.pi)
    sent = (left * solid[:, None]).sum(axis=0) + sum(lamp.irradiance for lamp in new.lamps)
    np.testing.assert_allclose(sent, (radiance * solid[:, None]).sum(axis=0), rtol=1e-4)
    axis, far = random_directions(500), np.zeros((500, 3), np.float32)
    wide = np.full(500, 0.05, np.float32)
    close = np.abs(new.look(far, axis, wide) - old.look(far, axis, wide)).mean()
    assert close < 0.1 * old.look(far, axis, wide).mean(), "where nothing hides them"
    even = Around(old.middle, Pictures.of(direction, np.ones_like(radiance), 64), (), ())
    assert with_world_lights(even, 0.02) is even


@pytest.mark.parametrize("kind", ShapeKind)
@pytest.mark.parametrize("tilt", [0, 60, 75])
@pytest.mark.parametrize("width", [0.02, 0.07, 0.15])
def test_how_much_of_a_lobe_lies_on_a_lamp_is_what_its_rays_say(
    kind: ShapeKind, tilt: float, width: float
) -> None:
    """Of a tilted lamp, turned about its own axis, by lobes towards its middle, an edge, and beside it."""
    rng, count = np.random.default_rng(3), 200_000
    place, turn, lean = np.array([0, 0, 2.0]), np.radians(45), np.radians(tilt)
    leans = np.array([[np.cos(lean), 0, np.sin(lean)], [0, 1, 0], [-np.sin(lean), 0, np.cos(lean)]])
    across = 0.35 * leans @ [np.cos(turn), np.sin(turn), 0]
    up = 0.25 * leans @ [-np.sin(turn), np.cos(turn), 0]
    shape = LampShape(kind, across, np.zeros(3) if kind == ShapeKind.BALL else up, 1.0)
    for aside in (0.0, 6.0, -6.0, 15.0):
        aim = np.array([np.sin(np.radians(aside)), 0, np.cos(np.radians(aside))])
        axis = np.tile(aim, (count, 1))
        normal = np.broadcast_to(np.array([0, 1.0, 0]), axis.shape)
        ray = spread_by_lobe(rng, axis, normal, np.full(count, width**2))
        if kind == ShapeKind.BALL:
            along = ray @ place
            met = (along > 0) & (place @ place - along**2 < across @ across)
        else:
            back = np.cross(across, up)
            facing = ray @ back
            hit = ray * (back @ place / facing)[:, None] - place
            x, y = hit @ across / (across @ across), hit @ up / (up @ up)
            inside = x * x + y * y < 1 if kind == ShapeKind.DISC else np.maximum(np.abs(x), np.abs(y)) < 1
            met = (facing > 0) & inside
        towards, one = place[:, None].astype(np.float32), axis[:1].T.astype(np.float32)
        (found,) = shape.covered(towards, one, np.full(1, width**2, np.float32))
        print(f"{kind}, {tilt}, {width}, {aside}: {found:.4f}, {met.mean():.4f} by {count} rays")
        np.testing.assert_allclose(found, met.mean(), rtol=0.06, atol=0.003)
    middle = place[:, None]
    assert shape.facing(middle, place) == 1
    assert shape.facing(-middle, place) == (kind == ShapeKind.BALL)


def test_rays_far_aside_of_a_lamp_and_behind_it_see_nothing_of_it() -> None:
    """Also along its plane, and of a strip a thousand times as long as wide."""
    width = np.full(1, 1e-3, np.float32)
    for high in (1.0, 5e-4):
        shape = LampShape(ShapeKind.RECTANGLE, np.array([1.0, 0, 0]), np.array([0, high, 0]), 1.0)
        for degrees in (75, 85, 90, 95, 120, 180):
            angle = np.radians(degrees)
            axis = np.array([[0], [np.sin(angle)], [np.cos(angle)]], np.float32)
            (found,) = shape.covered(np.array([[0], [0], [2.0]], np.float32), axis, width)
            assert 0 <= found < 5e-4 * high, degrees


@pytest.mark.parametrize("kind", ShapeKind)
def test_a_lobe_without_width_sees_a_lamp_wholly_or_not_at_all(kind: ShapeKind) -> None:
    """As where clear things turn no ray."""
    up = np.zeros(3) if kind == ShapeKind.BALL else np.array([0, 0.2, 0])
    shape = LampShape(kind, np.array([0.2, 0, 0]), up, 1.0)
    turned = np.radians([0, 3, 8, 60])
    axis = np.stack([np.sin(turned), np.zeros(4), np.cos(turned)]).astype(np.float32)
    towards = np.tile(np.array([[0], [0], [2]], np.float32), (1, 4))
    found = shape.covered(towards, axis, np.zeros(4, np.float32))
    np.testing.assert_allclose(found, [1, 1, 0, 0], atol=1e-3)


def test_a_small_lamp_beside_a_large_one_keeps_its_light() -> None:
    size, large, small = 512, 0.6, 0.04
    direction = cell_directions(size).astype(np.float32)
    places = [np.array([0, 0, 2.0]), 2 * np.array([np.sin(0.7), 0, np.cos(0.7)])]
    angles = [np.arccos(np.clip(direction @ (place / 2), -1, 1)) for place in places]
    radiance = np.zeros((len(direction), 3), np.float32)
    radiance[angles[0] < large] = 1
    radiance[angles[1] < small] = 1000
    balls = [LampShape(ShapeKind.BALL, np.array([2 * r, 0, 0]), np.zeros(3), 1.0) for r in (large, small)]
    found = lamps_of(direction, radiance, places, None, None, balls, (large, small))
    for lamp, bright in zip(found, (1, 1000), strict=True):
        assert lamp.shape is not None
        np.testing.assert_allclose(lamp.irradiance / lamp.shape.solid, bright, rtol=0.01)


def test_lamps_keep_their_shapes_in_a_bakes_store() -> None:
    around = case_of("everything").atlas.around
    arrays = arrays_of(around)
    for one, other in zip(around_of(arrays).lamps, around.lamps, strict=True):
        assert (one.shape is None) == (other.shape is None)
        if one.shape is not None and other.shape is not None:
            assert (one.shape.kind, one.shape.solid) == (other.shape.kind, other.shape.solid)
            np.testing.assert_allclose(one.shape.corners(), other.shape.corners(), rtol=1e-6)
    del arrays["lamp_shapes"]  # as earlier versions wrote it
    assert all(lamp.shape is None for lamp in around_of(arrays).lamps)


def test_a_picture_of_a_point_is_blurred_to_the_lobe() -> None:
    size = 256
    direction = cell_directions(size).astype(np.float32)
    towards = direction[len(direction) // 2 + size // 3]
    solid = 4 * np.abs(direction).sum(axis=1) ** 3 / len(direction)
    lit = (direction @ towards > 0.9995).astype(np.float32)
    picture = Pictures.of(direction, np.repeat(lit[:, None], 3, axis=1), size)
    for width in (0.08, 0.13, 0.3):
        off = np.array([0.2, 0.5, 1.0, 2.0]) * width + 0.05
        side = np.cross(towards, [0.3, 1, 0.2])
        at = np.cos(off)[:, None] * towards + np.sin(off)[:, None] * side / np.linalg.norm(side)
        seen = picture.look(at.astype(np.float32), np.full(len(at), width**2, np.float32))[0]
        exact = [(lit * solid * lobe(2 * (1 - direction @ one), np.full(1, width**2))).sum() for one in at]
        np.testing.assert_allclose(seen, exact, rtol=0.2)


def test_widths_that_vary_are_found_texel_by_texel() -> None:
    rays, rng = flat_samples(16), np.random.default_rng(4)
    texels, each = rays.used.shape
    normal = np.broadcast_to(np.array([0, 0, 1.0]), (texels * each, 3))
    axis = mirrored(rays.plan, rays.square).reshape(-1, 3)
    texel = np.arange(texels).repeat(each)
    wide = np.where(np.arange(texels) % SIDE < SIDE // 2, 0.05, 0.2)  # a material's left half and its right
    end = spread_by_lobe(rng, axis, normal, wide[texel] ** 2)
    cosine, one = axis[:, 2], np.ones((len(axis), 3))
    paths = Paths(texel, one, end, axis, normal, cosine, np.zeros(len(axis), dtype=np.int32))
    neighbours, number = Neighbours(rays.plan), np.zeros(texels, dtype=np.int32)
    lobes = fit_lobes(paths, number, neighbours)
    (material,), found = lobes.materials, lobes.width
    weight, variance, _ = material.at(np.array([0.8]))
    middle = np.exp((weight[:, 0] * np.log(variance)).sum())
    inner = np.abs(np.arange(texels) % SIDE - SIDE / 2 + 0.5) > 3
    np.testing.assert_allclose(np.sqrt(middle * found[inner]), wide[inner], rtol=0.2)
    assert (fit_lobes(paths, number, neighbours, vary=False).width == 1).all()


def test_the_mask_of_a_wall_has_its_edge_and_keeps_its_ends() -> None:
    rays = flat_samples(24)
    axis = mirrored(rays.plan, rays.square)
    missed = axis[..., 0] > 0  # a wall stands on one side
    kept = free_share(rays, ~missed, BucketGrid.of(rays.plan, 1), 16)[0]
    towards = cell_directions(16)
    up = towards[:, 2] > 0.3
    assert kept[:, up & (towards[:, 0] > 0.3)].min() > 0.97
    assert kept[:, up & (towards[:, 0] < -0.3)].max() < 0.03
    ends = seen_free(np.array([0.0, 0.5, 1.0]), np.full(3, 1e-4, np.float32), 16)
    np.testing.assert_allclose(ends, [0, 0.5, 1], atol=1e-3)
    soft, sharp = (seen_free(np.array([0.7]), np.array([v], np.float32), 16) for v in (0.1, 1e-4))
    assert sharp > soft >= 0.7 - 1e-6


@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_the_rest_takes_what_a_model_lacks_and_leaves_noise(noise: float) -> None:
    """Whether that is the same in all directions or changes."""
    rays = flat_samples(16)
    axis, place = rays.along(slice(None))
    random = noise * np.random.default_rng(2).normal(size=(*rays.used.shape, 3)).astype(np.float32)
    shown = np.ones((3, *rays.used.shape), dtype=np.float32)
    towards = cell_directions(CELLS)

    def rest_of(light: Floats) -> Floats:
        light = light.astype(np.float32)
        grid, level = BucketGrid.of(rays.plan, 1), mean_brightness(light, rays.used)
        return fit_rest(places_of(place), light, rays.used, shown, grid, CELLS, level)

    rest = rest_of(1.3 + random)[:, :, towards[:, 2] > 0.3]
    np.testing.assert_allclose(rest.mean(), 0.3, atol=0.02)
    assert rest.std() < 0.002 + 0.025 * noise
    if not noise:
        above = towards[:, 2] > 0.4
        rest = rest_of(np.moveaxis(1 + 0.5 * axis[:1].repeat(3, axis=0), 0, -1))[:, :, above]
        np.testing.assert_allclose(rest, np.broadcast_to(0.5 * towards[above, 0], rest.shape), atol=0.12)
