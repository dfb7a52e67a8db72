# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The rays in which paths leave a sheet of glass, traced by Cycles, against the law of refraction."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import plan_capture
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.progress import finished
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.cycles.path_ends import Body
from radtex_addon.forms.layered.capture.exits import capture_exits
from radtex_addon.forms.layered.fit.through import fit_ways
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from tests.bench.fidelity.scenes.materials import assign, principled
from tests.bench.fidelity.scenes.meshes import as_subject, made

pytestmark = pytest.mark.one_blender
_CELLS, _TIMES, _INDEX, _THICK = 4, 3, 1.5, 0.2


def test_a_sheet_of_glass_moves_rays_aside(tmp_path: Path) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add(size=1)
    sheet = as_subject(made())
    sheet.dimensions = (2, 2, _THICK)
    bpy.ops.object.transform_apply(scale=True)
    assign(sheet, principled("Glass", (1, 1, 1), Transmission_Weight=1.0, IOR=_INDEX, Roughness=0.0))
    kept: list[bpy.types.ID] = []
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, sheet.name)
        prepared = finished(prepare(scratch, [item], BakeSpec(layout=Layout.LAYERED, texels=32), kept))
        plan = plan_capture(prepared.texels(), _CELLS)
        body = Body(item, prepared.mesh, np.eye(4))
        exits = capture_exits(scratch, [body], np.zeros(3, np.float32), 1.6, plan, _TIMES, 1, tmp_path)
    ways = fit_ways(exits, Neighbours(plan))
    top = (plan.normals[:, 2] > 0.99) & (np.abs(plan.points[:, :2]).max(axis=1) < 0.6)  # far from the sides
    assert top.sum() > 20
    viewer = square_to_direction(cell_centres(_CELLS).reshape(-1, 2))
    steep = viewer[:, 2] > 0.5
    found = ways[:, top][:, :, steep] / ways[3, top][:, steep]
    straight = np.broadcast_to(-viewer[steep].T[:, None], found[:3].shape)
    assert (np.abs(found[:3] - straight).max(axis=0) < 5e-3).mean() > 0.97
    sine = np.sqrt(1 - viewer[steep, 2] ** 2)
    inside = sine / _INDEX
    aside = _THICK * (inside / np.sqrt(1 - inside**2) * viewer[steep, 2] - sine)  # against the ray's drift
    length = np.linalg.norm(found[4:7], axis=0)
    assert (np.abs(length + aside) < 3e-3).mean() > 0.97  # a path may go astray
    normal = (1 - 1 / _INDEX) ** 2 / (1 + 1 / _INDEX) ** 2
    assert abs(float(np.median(ways[3, top][:, steep])) - (1 - normal) ** 2) < 0.06
