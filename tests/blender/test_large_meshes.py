# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways that only meshes of very many triangles go, with low bounds; and tangents, which are Blender's."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest
from mathutils.bvhtree import BVHTree

from radtex_addon.bake.progress import Progress, finished, relayed
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.islands import signed_areas, surface_areas, uv_islands, weld
from radtex_addon.scene.mesh import backs, copy, face_rays
from radtex_addon.scene.mesh.backs import seen_from_behind, seen_from_behind_steps
from radtex_addon.scene.mesh.copy import calc_tangents
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.mesh.triangle_tree import triangle_tree
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv import flatten_in_parts, unwrap_options
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.settings.spec import Unwrap

context: Any = bpy.context  # to the stubs, every pointer may be None


def ball() -> EvaluatedMesh:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
    return read()


def read() -> EvaluatedMesh:
    """The object that was made last."""
    with scratch_scene(context.scene) as scratch:
        return evaluate(scratch, context.object)


@pytest.mark.one_blender
def test_a_mesh_is_flattened_in_parts_that_no_island_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = ball()
    monkeypatch.setattr(flatten_in_parts, "LARGE", 1000)
    monkeypatch.setattr(unwrap_options, "_HUGE", 1000)  # so that none are merged
    seen: list[Progress] = []
    made = finished(relayed(unwrap_steps(mesh, 256, Unwrap.UVUNWRAP), seen.append))
    parts = flatten_in_parts._parts(mesh.position[mesh.triangles].mean(axis=1))
    assert max(map(len, parts)) <= 1000
    assert np.array_equal(np.sort(np.concatenate(parts)), np.arange(len(mesh.triangles)))
    part = np.empty(len(mesh.triangles), dtype=int)
    for number, some in enumerate(parts):
        part[some] = number
    island = uv_islands(weld(mesh.position)[mesh.triangles], made.uv)
    assert len(np.unique(np.stack([island, part]), axis=1).T) == made.islands == island.max() + 1
    assert made.overlap < 1e-3
    texels = np.abs(signed_areas(made.uv * [made.width, made.height]))
    dense = texels / surface_areas(mesh.world_position[mesh.triangles])
    assert np.percentile(dense, 2) > 0.5 * np.median(dense)
    assert (
        len({step.done for step in seen if 0 < step.done < 300}) >= len(parts) - 1
    )  # the bar moves with the parts


@pytest.mark.one_blender
@pytest.mark.parametrize("closed", [False, True])
def test_few_rays_tell_whether_any_back_is_seen(closed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = ball()
    if not closed:
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=40)
        mesh = read()
    every = seen_from_behind(mesh)
    assert every.all() != closed
    monkeypatch.setattr(backs, "_RAYS", 2000)
    monkeypatch.setattr(face_rays, "_AT_ONCE", 100)
    steps = list(seen_from_behind_steps(mesh))
    assert {step.total for step in steps} == ({2000} if closed else {2000, len(mesh.triangles)})
    assert np.array_equal(seen_from_behind(mesh), every)


def test_the_tree_of_arrays_is_that_of_lists() -> None:
    mesh = ball()
    tree: Any = triangle_tree(mesh.position, mesh.triangles)
    lists: Any = BVHTree.FromPolygons(mesh.position.tolist(), mesh.triangles.tolist(), all_triangles=True)
    before = len(bpy.data.meshes), len(bpy.data.scenes), len(bpy.data.objects)
    chance = np.random.default_rng(0)
    for start, way in chance.normal(size=(500, 2, 3)).tolist():
        assert tree.ray_cast(start, way) == lists.ray_cast(start, way)
    triangle_tree(mesh.position, mesh.triangles)
    assert (len(bpy.data.meshes), len(bpy.data.scenes), len(bpy.data.objects)) == before


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
    monkeypatch.setattr(copy, "_ALONE", most)
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
