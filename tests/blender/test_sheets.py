# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheets are pictures of their own: in whatever order, and however they are cut, their bits are the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import CapturePlan, Tile
from radtex_addon.bake.spec import Kind
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.scene.scratch import scratch_scene
from tests.blender import stage

SIDE = 12  # buckets along the packed image


@pytest.fixture
def plan() -> CapturePlan:
    """Points on a glossy ball over a floor, five sheets of three rows."""
    stage.world()
    bpy.ops.mesh.primitive_uv_sphere_add()
    glossy = stage.material("glossy", "ShaderNodeBsdfAnisotropic", Roughness=0.3)
    bpy.context.object.data.materials.append(glossy)
    bpy.ops.mesh.primitive_plane_add(size=9, location=(0, 0, -1))
    normal = np.random.default_rng(3).normal(size=(SIDE * SIDE - 5, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    row = stage.plan_of(normal, normal, 4)

    def folded(field: Floats) -> Floats:
        padded = field.reshape(-1, 3)[np.minimum(np.arange(SIDE * SIDE), len(normal) - 1)]
        return padded.reshape(SIDE, SIDE, 3)

    fields: Any = {name: folded(getattr(row, name)) for name in _FIELDS}
    return replace(row, sheet=24, **fields)


_FIELDS = ("position", "tangent", "bitangent", "normal", "facet")


@pytest.mark.parametrize("kind", [Kind.RADIANCE, Kind.INCIDENT])
def test_a_sheet_has_the_same_bits_whichever_came_before(
    plan: CapturePlan, kind: Kind, tmp_path: Path
) -> None:
    assert (plan.sheet_rows, plan.sheets) == (3, 4)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    layer = scene.view_layers[0].name
    with scratch_scene(scene, layer) as scratch:
        capture = PortalCapture(scratch, plan, kind, 2, 5, tmp_path)
        whole = capture.render(Tile(0, plan.rows))
        upwards = [capture.render(Tile(row, 1)) for row in reversed(range(plan.rows))]
    assert np.array_equal(np.concatenate(upwards[::-1]), whole)
    with scratch_scene(scene, layer) as scratch:
        alone = PortalCapture(scratch, plan, kind, 2, 5, tmp_path).render(Tile(6, 3))
    assert np.array_equal(alone, whole[6 * SIDE : 9 * SIDE])


@pytest.mark.one_blender
def test_sheets_have_noise_of_their_own(plan: CapturePlan, tmp_path: Path) -> None:
    """Two sheets of the same point differ; with one seed for all they would repeat it."""
    still = {name: np.broadcast_to(getattr(plan, name)[:1, :1], (SIDE, SIDE, 3)) for name in _FIELDS}
    alike: Any = {name: np.ascontiguousarray(field) for name, field in still.items()}
    same = replace(plan, **alike)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with scratch_scene(scene, scene.view_layers[0].name) as scratch:
        capture = PortalCapture(scratch, same, Kind.RADIANCE, 2, 5, tmp_path)
        first, second = (capture.render(Tile(row, 3)) for row in (0, 3))
    assert not np.array_equal(first, second)
    np.testing.assert_allclose(first.mean(), second.mean(), rtol=0.05)
