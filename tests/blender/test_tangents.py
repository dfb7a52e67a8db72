# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents are Blender's own, to the last bit, into however many patches the mesh is cut."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.scene.mesh import tangents
from radtex_addon.scene.mesh.tangents import calc_tangents


def head() -> tuple[Any, Floats, Ints, Floats, Floats]:
    """A head with seams and mirrored halves of its UVs, triangulated, and its arrays."""
    bpy.ops.mesh.primitive_monkey_add()
    item: Any = bpy.context.object
    bpy.ops.object.shade_smooth()
    item.modifiers.new("Triangles", "TRIANGULATE")
    bpy.ops.object.modifier_apply(modifier="Triangles")
    mesh = item.data
    count = len(mesh.polygons)
    position, triangles = np.empty((len(mesh.vertices), 3), np.float32), np.empty((count, 3), np.int32)
    normal, uv = np.empty((count, 3, 3), np.float32), np.empty((count, 3, 2), np.float32)
    mesh.vertices.foreach_get("co", position.ravel())
    mesh.loops.foreach_get("vertex_index", triangles.ravel())
    mesh.corner_normals.foreach_get("vector", normal.ravel())
    mesh.uv_layers.active.data.foreach_get("uv", uv.ravel())
    uv[..., 0] = np.where(
        position[triangles][..., 0].mean(axis=1, keepdims=True) < 0, -uv[..., 0], uv[..., 0]
    )
    mesh.uv_layers.active.data.foreach_set("uv", uv.ravel())
    return mesh, position, triangles, normal, uv


@pytest.mark.parametrize("most", [60, 500, 10_000])
def test_they_are_blenders(monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    monkeypatch.setattr(tangents, "_ALONE", most)
    mesh, position, triangles, normal, uv = head()
    before = len(bpy.data.meshes)
    tangent, sign = calc_tangents(position, triangles, normal, uv)
    assert len(bpy.data.meshes) == before
    mesh.calc_tangents()
    expected, turned = np.empty_like(tangent), np.empty_like(sign)
    mesh.loops.foreach_get("tangent", expected.ravel())
    mesh.loops.foreach_get("bitangent_sign", turned.ravel())
    assert np.array_equal(tangent, expected)
    assert np.array_equal(sign, turned)
    assert set(np.unique(sign)) == {-1, 1}


def test_those_of_a_large_mesh_are_the_same_each_time() -> None:
    """Blender's own are not, where there are cores: there are more than 10,000 faces."""
    side = np.arange(81)
    x, y = (part.ravel() for part in np.meshgrid(side / 80, side / 80))
    position = np.stack([x, y, 0.1 * np.sin(9 * x) * np.cos(7 * y)], axis=1).astype(np.float32)
    corner = (side[:80, None] * 81 + side[:80]).ravel()
    quads = np.stack([corner, corner + 1, corner + 82, corner, corner + 82, corner + 81], axis=1)
    triangles = quads.reshape(-1, 3).astype(np.int32)
    normal = np.tile(np.array([0, 0, 1], dtype=np.float32), (len(triangles), 3, 1))
    uv = position[triangles][..., :2] * np.float32(0.9)
    assert len(triangles) > 10_000
    first = calc_tangents(position, triangles, normal, uv)
    assert all(
        np.array_equal(calc_tangents(position, triangles, normal, uv)[part], first[part])
        for part in (0, 1)
        for _ in range(4)
    )
