# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells that nobody can see: found inside the mesh, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.cycles.find_hidden import find_hidden
from tests.blender import stage


def active_mesh() -> bpy.types.Mesh:
    """The mesh of the object that was made last."""
    mesh = bpy.context.object.data
    assert isinstance(mesh, bpy.types.Mesh)
    return mesh


@pytest.mark.one_blender
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_sheared_convex_mesh_hides_nothing(tmp_path: Path, mirrored: bool) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    mesh = active_mesh()
    matrix = np.eye(4)
    matrix[0, 2], matrix[1, 1] = 2.0, -1.0 if mirrored else 1.0
    turn = np.linalg.inv(matrix[:3, :3])
    point, normal = np.empty((2, len(mesh.polygons), 3))
    mesh.polygons.foreach_get("center", point.ravel())
    mesh.polygons.foreach_get("normal", normal.ravel())
    point, normal = point[::40], normal[::40] @ turn
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    plan = stage.plan_of(point @ matrix[:3, :3].T, normal, 4)
    assert not finished(find_hidden([(mesh, matrix)], plan, tmp_path)).cells.any()


def test_the_inside_of_another_part_is_hidden(tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1)
    plan = stage.plan_of(np.array([[0, 0, 0], [0, 0, 2.0]]), np.array([[0, 0, 1.0], [0, 0, 1.0]]), 4)
    hidden = finished(find_hidden([(active_mesh(), np.eye(4))], plan, tmp_path)).cells
    assert hidden[0].all()
    assert not hidden[1].any()
