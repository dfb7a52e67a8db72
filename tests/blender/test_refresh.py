# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Refreshing: after a change, what it touches is as if baked anew, all else stays, most paths are saved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import BakeResult, bake_object
from tests.blender import stage

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=48, bucket=4, samples=16, half=False, uv_layer="UVMap")
AGAIN = replace(SPEC, refresh=True, samples=1)


def room() -> Any:
    """A large card in dim light, a small lamp low over one of its corners; returns the lamp."""
    stage.world((0.1, 0.1, 0.1))
    stage.clamps_off()
    bpy.ops.mesh.primitive_plane_add(size=8)
    context.object.name = "Card"
    context.object.data.materials.append(
        stage.material("d", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    bpy.ops.object.light_add(type="SPOT", location=(-2.5, -2.5, 1.5))
    lamp = context.object
    lamp.data.energy, lamp.data.spot_size, lamp.data.shadow_soft_size = 100, 1.2, 0.1
    return lamp


def bake(out: Path, spec: BakeSpec) -> tuple[Floats, BakeResult]:
    made = bake_object(context.scene, "Card", spec, out)
    return read_buckets(made.files.sidecar)[0], made


def test_what_has_changed_is_refreshed_and_all_else_stays(out: Path) -> None:
    lamp = room()
    before, first = bake(out, SPEC)
    unchanged, made = bake(out, AGAIN)
    assert np.array_equal(unchanged, before)
    assert made.paths < first.paths / 16
    lamp.data.energy = 300
    refreshed, made = bake(out, AGAIN)
    anew, _ = bake(out / "anew", SPEC)
    print(f"\n{made.paths} paths of {first.paths}: {made.paths / first.paths:.2f}")
    assert made.paths < first.paths / 2
    changed = np.abs(anew - before).mean(axis=-1)
    left = np.abs(refreshed - anew).mean(axis=-1)
    print(f"error {left.mean():.5f} of a change of {changed.mean():.5f}, at most {left.max():.4f}")
    assert left.mean() < 0.05 * changed.mean()
    assert np.array_equal(refreshed[-40:, -40:], before[-40:, -40:]), "the far corner was touched"
    touched = (refreshed != before).any(axis=-1).mean()
    assert 0.05 < touched < 0.5
    assert read_sidecar(out / "Card.radiance.json").samples == 16
    stage.world((1, 1, 1))  # light that is everywhere
    refreshed, _ = bake(out, AGAIN)
    assert np.array_equal(refreshed, bake(out / "all anew", SPEC)[0])


def test_refreshing_and_accumulating_exclude_each_other(out: Path) -> None:
    with pytest.raises(InputError, match="contradict each other"):
        BakeSpec(accumulate=True, refresh=True)
    room()
    with pytest.raises(InputError, match=r"Card\.radiance\.json is not there to refresh: bake it first"):
        bake(out, AGAIN)
