# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels beside a seam show what lies beyond it: as far on the surface as their centres are in the atlas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radtex_addon.core.arrays import Bools, Floats, Ints
from radtex_addon.core.seams import Seams, beyond_seams
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import TexelMap, rasterise

TEXELS = 48
COLUMNS, ROWS = 14, 6  # squares of the sheet
FLAT = 1e-4  # of a sheet that is hardly rolled up, in radians
DENSITY = 20.0  # texels along a unit of the sheet, which is 1 x 0.5


def placed(flat: Floats, turn: float, mirrored: bool, low: tuple[float, float]) -> Floats:
    """Islands of flat places (F, 3, 2): turned, mirrored, with their box's lower corner at `low`, in UV."""
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    moved = flat @ rotation.T * (DENSITY / TEXELS) * ((-1, 1) if mirrored else (1, 1))
    shifted: Floats = moved - moved.min(axis=(0, 1)) + np.array(low) / TEXELS
    return shifted


def sheet(roll: float, turn: float, mirrored: bool) -> tuple[SurfaceMesh, Floats, Ints]:
    """A sheet, rolled up by an angle, cut into two islands by a zigzag; its flat places, and islands (F,)."""
    x, y = np.linspace(0, 1, COLUMNS + 1), np.linspace(0, 0.5, ROWS + 1)
    flat = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    corner = np.arange((COLUMNS + 1) * (ROWS + 1)).reshape(ROWS + 1, COLUMNS + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.concatenate(
        [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    )
    angle = roll * (flat[:, 0] - 0.5)
    radius = 1 / roll
    place = np.stack([radius * np.sin(angle), flat[:, 1], radius * np.cos(angle) - radius], axis=1)
    normal = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    tangent = np.stack([np.cos(angle), 0 * angle, -np.sin(angle)], axis=1)
    own = flat[triangles]
    island = (own[..., 0].mean(axis=1) + 0.3 * own[..., 1].mean(axis=1) > 0.55).astype(np.int64)
    uv = np.empty(own.shape)
    uv[island == 0] = placed(own[island == 0], 0.2, False, (2.3, 2.6))
    uv[island == 1] = placed(own[island == 1], turn, mirrored, (20.4, 21.7))
    count = len(triangles)
    surface = SurfaceMesh(place, triangles, normal[triangles], tangent[triangles], np.ones((count, 3)), uv)
    return surface, own, island


def maps(surface: SurfaceMesh) -> tuple[TexelMap, TexelMap, Bools]:
    """The texel map without and with the points beyond seams, and which texels differ."""
    before = rasterise(surface, TEXELS, TEXELS)
    after = beyond_seams(before, surface, Seams.of(surface))
    return before, after, (before.triangle != after.triangle) & before.covered


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("turn", [0.0, 0.7, 2.5])
def test_on_a_plane_points_go_on_as_the_atlas_does(turn: float, mirrored: bool) -> None:
    surface, own, island = sheet(FLAT, turn, mirrored)
    before, after, changed = maps(surface)
    assert np.count_nonzero(changed) > 12
    assert (after.own_triangle == before.triangle).all()
    assert (island[after.own_triangle[changed]] != island[after.triangle[changed]]).any()
    for number in (0, 1):
        some = changed & (island[before.triangle] == number)
        uv, flat = surface.uv[island == number].reshape(-1, 2), own[island == number].reshape(-1, 2)
        affine = np.linalg.lstsq(np.column_stack([uv, np.ones(len(uv))]), flat, rcond=None)[0]
        j, i = np.nonzero(some)
        centre = (np.stack([i, j], axis=1) + 0.5) / TEXELS
        expected = np.column_stack([centre, np.ones(len(centre))]) @ affine
        on_sheet = ((expected > 0) & (expected < (1, 0.5))).all(axis=1)
        assert np.count_nonzero(on_sheet) > 5
        found = np.stack([after.position[some][:, 0] + 0.5, after.position[some][:, 1]], axis=1)
        missed = np.abs(found - expected)[on_sheet].max(axis=1)
        assert np.quantile(missed, 0.8) < 1e-5
        assert missed.max() < 0.1 / DENSITY  # a tooth of the zigzag may be narrower than the way is long
        assert (island[after.triangle[some]] != number).all()


def test_on_a_roll_points_lie_on_it_and_frames_turn_with_it() -> None:
    surface, _, _ = sheet(2.0, 0.7, False)
    before, after, changed = maps(surface)
    same = ~changed & before.inside
    assert not (changed & before.inside).any()
    assert (before.position[same] == after.position[same]).all()
    position, normal = after.position[changed].astype(float), after.normal[changed].astype(float)
    outwards = position + np.array([0, 0, 0.5])
    outwards[:, 1] = 0
    radius = np.linalg.norm(outwards, axis=1)
    assert np.abs(radius - 0.5).max() < 0.5 * (1 - np.cos(1 / COLUMNS))
    assert np.sum(normal * outwards / radius[:, None], axis=1).min() > 1 - 1e-5
    facet = after.facet[changed].astype(float)
    np.testing.assert_allclose(np.linalg.norm(facet, axis=1), 1, atol=1e-6)
    assert np.sum(facet * outwards / radius[:, None], axis=1).min() > np.cos(1 / COLUMNS + 1e-3)
    tangent = after.tangent[changed].astype(float)
    assert np.abs(np.sum(tangent * normal, axis=1)).max() < 1e-6
    # The tangent runs around the roll before, and still does.
    around = np.stack([outwards[:, 2], 0 * radius, -outwards[:, 0]], axis=1) / radius[:, None]
    assert np.sum(tangent * around, axis=1).min() > 1 - 1e-5
    moved = np.linalg.norm(position - before.position[changed], axis=1) * DENSITY
    assert 0.1 < moved.max() < 0.75  # texels: a centre outside a touched texel's island is no farther


def test_what_is_no_seam_stays() -> None:
    surface, _, island = sheet(FLAT, 0.7, False)
    sharp = surface.normal.copy()
    sharp[island == 1] = [0.0, 1.0, 0.0]
    for other in (replace(surface, normal=sharp), replace(surface, material=island)):
        assert not maps(other)[2].any()


def test_ways_end_before_triangles_without_area() -> None:
    surface, own, island = sheet(FLAT, 0.7, False)
    uv = surface.uv.copy()
    some = island == 1
    thin = some & (own[..., 0].mean(axis=1) < 0.75)
    thin &= np.arange(len(thin)) % 2 == 0
    uv[thin, 2] = (uv[thin, 0] + uv[thin, 1]) / 2
    before, after, _ = maps(replace(surface, position=surface.position + 5.0, uv=uv))
    assert np.abs(after.position[before.covered]).min() > 1  # none at the world's origin
