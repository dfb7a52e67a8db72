# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared bakes under small and bright lights: little is lost, and what is lost is said."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.formats.shared_files import read_shared
from radtex_addon.job import bake_object
from tests.blender import stage

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(layout=Layout.SHARED, texels=24, bucket=6, samples=4)
FEW = BakeSpec(layout=Layout.SHARED, texels=16, bucket=4, samples=1)
COAT = {"Base Color": (0.5, 0.1, 0.08, 1), "Roughness": 0.5, "Coat Weight": 1.0, "Coat Roughness": 0.15}
GOLD = {"Base Color": (0.9, 0.6, 0.22, 1), "Metallic": 1.0, "Roughness": 0.3}
WINDOWS = [(3, 0, 2), (-2, -3, 1)]


def ball(inputs: dict[str, object]) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    bpy.ops.object.shade_smooth()
    context.object.name = "Ball"
    context.object.data.materials.append(stage.material("Ball", "ShaderNodeBsdfPrincipled", **inputs))


def lamp(radius: float) -> None:
    data: Any = bpy.data.lights.new("Lamp", "POINT")
    data.energy, data.shadow_soft_size = 150, radius
    made = bpy.data.objects.new("Lamp", data)
    made.location = (1.5, -2.2, 2.4)
    context.scene.collection.objects.link(made)


def windows() -> None:
    for number, place in enumerate(WINDOWS):
        bpy.ops.mesh.primitive_plane_add(size=0.5, location=place)
        context.object.rotation_euler = context.object.location.to_track_quat("Z", "Y").to_euler()
        shader = stage.material(f"Window {number}", "ShaderNodeEmission", Strength=300.0)
        context.object.data.materials.append(shader)


@pytest.mark.parametrize("lit", ["lamp", "windows"])
def test_small_bright_lights_lose_little(lit: str, out: Path) -> None:
    stage.world()
    if lit == "lamp":
        lamp(0.05)
        ball(COAT)
    else:
        windows()
        ball(GOLD)
    result = bake_object(context.scene, "Ball", SPEC, out)
    assert result.fireflies < 0.03  # .017 to .021, from one process to the next
    assert read_shared(out / "Ball.radiance.json")[1].bake.fireflies == round(result.fireflies, 6)


def test_what_is_lost_is_said(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    lamp(0.02)
    ball(GOLD | {"Roughness": 0.12})
    with caplog.at_level(logging.WARNING):
        result = bake_object(context.scene, "Ball", FEW, out)
    said = [record.getMessage() for record in caplog.records if "fireflies" in record.getMessage()]
    assert result.fireflies > 0.01
    assert len(said) == 1
    share = f"{100 * result.fireflies:.1f} % of the light of 'Ball' is lost as fireflies"
    assert (
        said[0] == f"{share}, which single paths brought and no others: take more samples, or a larger lamp"
    )
    assert read_shared(out / "Ball.radiance.json")[1].bake.fireflies > 0.01
