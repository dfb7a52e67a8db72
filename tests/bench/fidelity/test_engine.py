# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine's reflections, lightmaps and pictures are made of, against cases that are known."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.core.sampler import bilinear
from radtex_addon.forms.layered.fit.view_dependence import basis
from radtex_addon.report.gbuffer import BakedSurface, CameraRays
from radtex_addon.scene.mesh.copy import NORMAL, SIGN, TANGENT
from tests.bench.fidelity.lightmaps import texture_bytes, up_to_white
from tests.bench.fidelity.orbit import Frame, measure
from tests.bench.fidelity.reflection_probe import Box, prefiltered
from tests.bench.fidelity.seen_from import camera_of
from tests.bench.fidelity.split_sum import reflectance
from tests.bench.fidelity.thin_film import filmed

_SIDES = np.array([[2.0, 3.0, 1.0], [4.0, 2.5, 5.0]])  # of a room, as seen from its middle
_RNG = np.random.default_rng(7)


def _unit(count: int) -> Floats:
    vectors = _RNG.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _distance_in_room(direction: Floats) -> Floats:
    distance: Floats = (
        np.where(direction > 0, _SIDES[1], _SIDES[0]) / np.maximum(np.abs(direction), 1e-9)
    ).min(axis=1)
    return distance


def test_box_of_a_room_is_found_from_its_distances() -> None:
    nearness = (1 / _distance_in_room(cell_directions(64))).reshape(64, 64)
    box = Box.around(np.zeros(3), nearness, _RNG.uniform(-0.5, 0.5, (50, 3)))
    assert 1 / box.nearness == pytest.approx(_SIDES, rel=0.03)


def test_box_holds_the_object_though_the_samples_lie_nearer() -> None:
    points = np.array([[-1.0, -1, -1], [1, 1, 1]])
    box = Box.around(np.zeros(3), np.full((64, 64), 10.0), points)
    assert (1 / box.nearness > 1).all()


def test_rays_leave_a_box_at_its_sides_and_keep_their_direction_where_all_is_far() -> None:
    position, direction = _RNG.uniform(-0.9, 0.9, (100, 3)), _unit(100)
    met = Box(np.zeros(3), 1 / _SIDES).leave(position, direction)
    assert np.linalg.norm(met, axis=1) == pytest.approx(_distance_in_room(_normalised(met)))
    assert np.cross(met - position, direction) == pytest.approx(np.zeros((100, 3)), abs=1e-9)
    far = Box(np.zeros(3), np.zeros((2, 3))).leave(position, direction)
    assert _normalised(far) == pytest.approx(direction, abs=1e-5)


def _normalised(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit


def test_even_surroundings_stay_even_and_a_bright_cell_spreads_ever_wider() -> None:
    image = np.ones((256, 256, 3), dtype=np.float32)
    image[128, 128, 0] = 1000
    levels = prefiltered(image, ((0.0, 256), (0.2, 64), (0.5, 32), (1.0, 16)))
    for level in levels:
        assert level[..., 1:] == pytest.approx(np.ones_like(level[..., 1:]), abs=1e-4)
    brightest = [float(level[..., 0].max()) for level in levels]
    assert brightest == sorted(brightest, reverse=True)
    assert brightest[-1] < 3


def test_a_white_metal_mirrors_all_and_a_dielectric_more_at_grazing_angles() -> None:
    cosine, roughness = (grid.ravel() for grid in np.meshgrid([0.1, 0.5, 0.95], [0.1, 0.5, 0.9]))
    white = reflectance(np.ones((9, 3)), cosine, roughness)
    assert white == pytest.approx(np.ones((9, 3)), abs=1e-4)
    dielectric = reflectance(np.full((9, 3), 0.04), cosine, roughness)[:, 0].reshape(3, 3)
    assert dielectric[0, 2] == pytest.approx(0.04, abs=0.004)
    assert (np.diff(dielectric, axis=1) < 0).all()


def test_a_film_of_no_thickness_changes_little_and_a_thick_one_colours() -> None:
    metal, front = np.full((1, 3), 0.6), np.ones(1)
    assert filmed(metal, front, 0, 1.4) == pytest.approx(metal, abs=0.06)
    coloured = filmed(metal, front, 400, 1.4)[0]
    assert coloured[0] > coloured[2] + 0.1


def test_harmonics_are_orthonormal() -> None:
    columns = basis(_unit(200_000))
    assert 4 * np.pi * columns.T @ columns / len(columns) == pytest.approx(np.eye(9), abs=0.03)


def test_textures_are_counted_in_blocks_and_constants_are_free() -> None:
    assert texture_bytes(np.zeros((8, 5, 3))) == 4 * 16
    assert texture_bytes(np.zeros((1, 1, 3))) == 0


def test_bright_light_is_dimmed_to_white_and_keeps_its_colour() -> None:
    dimmed = up_to_white(np.array([[10.0, 5, 0], [0.2, 0.1, 0.3]]))
    assert dimmed[0] @ [0.2126, 0.7152, 0.0722] == pytest.approx(1, abs=1e-3)
    assert dimmed[0, 0] == pytest.approx(2 * dimmed[0, 1])
    assert dimmed[1] == pytest.approx([0.2, 0.1, 0.3])


def test_lookups_blend_texels() -> None:
    image = np.arange(4, dtype=np.float32).reshape(2, 2, 1)
    found = bilinear(image, np.array([[0.25, 0.25], [0.5, 0.5], [0, 1]], dtype=np.float32))
    assert found[:, 0] == pytest.approx([0, 1.5, 2])


def test_camera_is_found_from_the_rays_that_hit() -> None:
    turn = np.linalg.qr(_RNG.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    place = turn @ np.array([0.1, -0.2, 5])
    rays = CameraRays.of_camera(place, turn, 0.3, 24, 2)
    buffer = BakedSurface(_triangle(), np.eye(4), "Bake").gbuffer(rays, np.full(len(rays.away), np.inf))
    assert 0 < buffer.hit.sum() < len(buffer.hit)
    camera = camera_of(buffer)
    assert camera.place == pytest.approx(place, abs=1e-6)
    assert camera.turn == pytest.approx(turn, abs=1e-6)
    assert camera.half == pytest.approx(0.3, abs=1e-6)


def _triangle() -> bpy.types.Mesh:
    """A mesh of one triangle through the origin, with the attributes of a baked copy."""
    mesh = bpy.data.meshes.new("Triangle")
    mesh.from_pydata([(-1.0, -0.6, 0.3), (1.1, -0.5, -0.2), (0.1, 1.2, 0.4)], [], [(0, 1, 2)])
    attributes = cast(Any, mesh).attributes
    for name, values in ((NORMAL, (0.0, 0, 1)), (TANGENT, (1.0, 0, 0))):
        attributes.new(name, "FLOAT_VECTOR", "CORNER").data.foreach_set("vector", values * 3)
    attributes.new(SIGN, "FLOAT", "CORNER").data.foreach_set("value", (1.0,) * 3)
    attributes.new("Bake", "FLOAT2", "CORNER").data.foreach_set("vector", (0.0, 0, 1, 0, 0, 1))
    return mesh


def test_steady_pictures_do_not_flicker_and_shimmer_is_measured() -> None:
    inside = np.ones((4, 4), dtype=bool)
    pictures = [np.full((4, 4, 3), value) for value in (0.2, 0.5, 0.3)]
    steady = measure([Frame(picture, picture, inside) for picture in pictures])
    assert (steady.flicker, steady.share) == (0, 1)
    assert steady.change == pytest.approx((0.3 + 0.2 + 0.1) / 3)
    offset = measure([Frame(picture + 0.1, picture, inside) for picture in pictures])
    assert offset.flicker == pytest.approx(0)  # wrong, but steady
    shimmering = [Frame(picture + 0.1 * (n == 1), picture, inside) for n, picture in enumerate(pictures)]
    assert measure(shimmering).flicker == pytest.approx(0.2 / 3)
