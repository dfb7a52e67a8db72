# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points keep their distance from edges, move no farther than that, and stay on their triangle."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.inset import inset
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import TexelMap, rasterise

TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]


def surface(uv: Floats) -> SurfaceMesh:
    """Loose triangles (F, 3, 2) in UV, lying in space as they lie there, turned and shifted."""
    count = len(uv)
    flat = np.concatenate([4 * uv, np.zeros((count, 3, 1))], axis=-1)
    position = (flat @ TURN.T + [1, 2, 3]).reshape(-1, 3)
    normal, tangent = (np.broadcast_to(TURN[:, axis], (count, 3, 3)) for axis in (2, 0))
    return SurfaceMesh(
        position, np.arange(3 * count).reshape(-1, 3), normal, tangent, np.ones((count, 3)), uv
    )


def distances(texels: TexelMap, mesh: SurfaceMesh) -> Floats:
    """Signed distances (K, 3) of the covered texels' points from their triangles' edges, positive inside."""
    corner = mesh.corner_position[texels.triangle[texels.covered]]
    point = texels.position[texels.covered].astype(float)[:, None]
    along = np.roll(corner, -1, axis=1) - corner
    normal = np.cross(along[:, 0], along[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    inwards = np.cross(normal[:, None], along)
    inwards /= np.linalg.norm(inwards, axis=2, keepdims=True)
    gap: Floats = np.sum((point - corner) * inwards, axis=-1)
    return gap


SQUARE = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], dtype=float)


def test_points_on_a_rim_move_inside_and_others_stay_to_the_bit() -> None:
    mesh = surface(0.25 + 0.5 * SQUARE)  # its border runs through the centres of texels
    texels = rasterise(mesh, 10, 10)
    before, gaps = texels.position.copy(), distances(texels, mesh)
    assert np.isclose(gaps, 0, atol=1e-6).any()
    moved = inset(texels, mesh, 0.01)
    np.testing.assert_array_equal(texels.position, before)  # the given map is not written
    assert distances(moved, mesh).min() > 0.01 - 1e-6
    step = np.linalg.norm(moved.position - before, axis=-1)
    assert step.max() < 0.04
    far = gaps.min(axis=1) > 0.01 + 1e-6
    assert far.sum() > 10
    assert (step[~texels.covered] == 0).all()
    assert (step[texels.covered][far] == 0).all()
    for field in ("normal", "tangent", "sign", "facet", "triangle", "inside"):
        np.testing.assert_array_equal(getattr(moved, field), getattr(texels, field))


@pytest.mark.parametrize("height", [1e-3, 1e-9])
def test_a_triangle_too_small_is_met_in_its_middle(height: float) -> None:
    needle = np.array([[[0.1, 0.5], [0.9, 0.5], [0.5, 0.5 + height]]])
    mesh = surface(needle)
    moved = inset(rasterise(mesh, 8, 8), mesh, 0.1)
    along = (moved.position[moved.covered] - np.array([1, 2, 3])) @ TURN[:, 1]
    np.testing.assert_allclose(along, 4 * (0.5 + height / 3), atol=1e-6)


def test_points_of_a_triangle_without_area_stay() -> None:
    mesh = surface(SQUARE[:1])
    position = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float)
    line = SurfaceMesh(position, mesh.triangles, mesh.normal, mesh.tangent, mesh.sign, mesh.uv)
    texels = rasterise(line, 4, 4)
    np.testing.assert_array_equal(inset(texels, line, 0.1).position, texels.position)
