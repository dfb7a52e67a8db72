# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse light that is traced anew: less noise indoors, edges as texels see them, smooth light as it was."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.forms.layered.capture.light_map import texels_shown
from radtex_addon.forms.layered.fit.light_map import nearer
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.bench.lightmap.ours import Ours, bake_ours
from tests.bench.lightmap.rooms import lamplit
from tests.blender import stage

context: Any = bpy.context
_SIDE = 24  # texels
_EDGE = 0.03  # metres from the middle of a plane of two: where the shade ends, in the middle of no texel


def baked(name: str, folder: Path, samples: int = 16, texels: int = _SIDE) -> Ours:
    """The diffuse light of the open scene's object."""
    spec = BakeSpec(layout=Layout.LAYERED, texels=texels, samples=samples)
    kept: list[bpy.types.ID] = []
    with scratch_scene(context.scene, None, kept) as scratch:
        prepared = finished(prepare(scratch, [find_object(scratch, name)], spec, kept))
        return bake_ours(scratch, prepared, spec, folder)


def card() -> None:
    """A plane of 2 x 2 metres of a diffuse material."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    context.scene.render.engine = "CYCLES"
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    context.object.data.materials.append(
        stage.material("White", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )


def test_smooth_light_is_left_alone(tmp_path: Path) -> None:
    card()
    stage.world((0.5, 0.6, 0.7))
    found = baked("Card", tmp_path)
    assert found.paths[0] == found.paths[1]
    assert (found.before == found.after).all()


def test_a_texel_that_an_edge_crosses_has_its_mean(tmp_path: Path) -> None:
    card()
    stage.world((0.02, 0.02, 0.02))
    bpy.ops.object.light_add(type="SUN", location=(0, 0, 3))
    context.object.data.energy, context.object.data.angle = 3.0, 0.0
    bpy.ops.mesh.primitive_plane_add(size=4, location=(_EDGE - 2, 0, 0.5))
    found = baked("Card", tmp_path)
    x, y = found.plan.points[:, 0], found.plan.points[:, 1]
    place = np.unique(x.round(4))
    wide = float(np.median(np.diff(place)))
    inside = (np.abs(y) < 1 - 2 * wide) & (np.abs(x) < 1 - 2 * wide)
    lit = np.clip((x - _EDGE) / wide + 0.5, 0, 1)
    crossed = inside & (lit > 0.05) & (lit < 0.95)
    bright = float(found.after[inside & (lit == 1)].mean())
    assert crossed.any()
    assert np.abs(found.after[crossed, 1] / bright - lit[crossed]).max() < 0.15
    assert np.abs(found.before[crossed, 1] / bright - lit[crossed]).min() > 0.2
    assert found.paths[1] > found.paths[0]


def test_bounced_light_has_less_noise(tmp_path: Path) -> None:
    lamplit()
    found = baked("Floor", tmp_path, texels=16)
    truth = baked("Floor", tmp_path, samples=64, texels=16)
    off = [float(np.sqrt(np.mean((light - truth.after) ** 2))) for light in (found.before, found.after)]
    assert off[1] < 0.6 * off[0]
    assert found.after.mean() == pytest.approx(truth.after.mean(), rel=0.08)


def plan_of(column: Floats, row: Floats, place: Floats) -> CapturePlan:
    """A plan of texels of an atlas of 8 x 8 that lie in one plane, at places (K, 3)."""
    position = place[None].astype(np.float32)
    up = np.broadcast_to(np.array([0, 0, 1], np.float32), position.shape)
    texel = (row * 8 + column).astype(np.int64)
    return CapturePlan(AtlasLayout(8, 8, 1), texel, position, up, up, up, up)


def halves_and_seam() -> CapturePlan:
    """One surface in two islands: columns 0 to 2, and 5 to 7, which go on from there."""
    row, column = np.divmod(np.arange(64), 8)
    own = (column < 3) | (column > 4)
    row, column = row[own], column[own]
    x = np.where(column > 4, column - 2, column)
    return plan_of(column, row, np.stack([x, row, 0 * x], axis=1))


def test_a_gutter_shows_a_denoiser_what_lies_beyond_the_seam() -> None:
    plan = halves_and_seam()
    shown = texels_shown(plan)
    column = plan.texel[shown] % 8
    assert (column[:, 3] == 5).all()
    assert (column[:, 4] == 2).all()
    assert (plan.texel[shown] // 8 == np.arange(8)[:, None]).all()


def test_a_gutter_beside_nothing_shows_its_island_mirrored() -> None:
    """The rim's texel over and over would be a streak of one noise, which a denoiser takes for an edge."""
    row, column = np.divmod(np.arange(64), 8)
    row, column = row[column < 4], column[column < 4]
    plan = plan_of(column, row, np.stack([column, row, 0 * row], axis=1))
    shown = plan.texel[texels_shown(plan)]
    assert (shown % 8).tolist() == [[0, 1, 2, 3, 3, 2, 1, 0]] * 8
    assert (shown // 8 == np.arange(8)[:, None]).all()


def test_what_is_denoised_counts_where_it_takes_noise_away() -> None:
    plan = halves_and_seam()
    neighbours, count = Neighbours(plan), len(plan.texel)
    none = np.zeros(count, dtype=bool)
    flat = np.ones((count, 3), dtype=np.float32)
    noise = np.random.default_rng(1).normal(0, 0.1, (2, count, 3)).astype(np.float32)
    halves = flat + noise
    found = nearer(halves, np.stack([flat, flat]), flat, none, neighbours)
    assert np.abs(found - 1).mean() < 0.3 * np.abs(halves.mean(axis=0) - 1).mean()


def test_what_is_denoised_does_not_count_where_it_blurs_an_edge() -> None:
    plan = halves_and_seam()
    step = np.repeat((plan.points[:, :1] > 2) + 0.1, 3, axis=1).astype(np.float32)
    blurred = np.full_like(step, step.mean())
    noise = np.random.default_rng(1).normal(0, 0.01, (2, *step.shape)).astype(np.float32)
    edge = np.ones(len(step), dtype=bool)
    found = nearer(step + noise, np.stack([blurred, blurred]), blurred, edge, Neighbours(plan))
    assert np.abs(found - step).max() < 0.05
