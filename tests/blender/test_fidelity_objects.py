# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layered bakes of several objects in one atlas, held against path-traced pictures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import Progress, Stage, finished
from radtex_addon.core.sampler import Filter
from radtex_addon.export.export_manifest import EXTENSION
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.gltf import extension_in
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.forms.layered.files.layered_files import read_layered_sidecar
from radtex_addon.job import bake_object, bake_steps, part_specs
from radtex_addon.settings.spec import BakeSpec, Layout, Split, Unwrap
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender.objects_stage import corner, detailed, pair, view

pytestmark = [pytest.mark.usefixtures("temporary"), pytest.mark.one_blender]
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(layout=Layout.LAYERED, texels=32, samples=4, unwrap=Unwrap.BLENDER)


def test_objects_that_share_an_atlas_look_as_cycles_sees_them(out: Path) -> None:
    stage = pair()
    spec = replace(SPEC, objects=("Ball", "Box"))
    made = bake_object(context.scene, "Pair", spec, out, preview=Filter.QUADRILINEAR)
    front, behind = (view(stage, camera, [made.files.sidecar]) for camera in stage.tuning)
    assert front.psnr() > 25
    assert behind.psnr() > 28
    facts = read_layered_sidecar(made.files.sidecar)
    assert len(facts.materials) == 3, "gold, red and blue are in five slots"
    exported = finished(export_steps(made.files.sidecar, ExportSpec(Target.GODOT))).folder
    glb = Glb.read(exported / "Pair.glb")
    numbers = [extension_in(each)["material"] for each in glb.document["materials"]]
    assert numbers == [0, 1, 2]
    shown = {mesh["name"]: len(mesh["primitives"]) for mesh in glb.document["meshes"]}
    assert shown == {"Ball": 2, "Box": 3}, "a draw call for each object and material"
    manifest = json.loads((exported / f"Pair.{EXTENSION}").read_text())
    assert manifest["bake"]["objects"] == ["Ball", "Box"]


def test_a_shared_bake_that_is_resumed_has_the_same_bytes(out: Path) -> None:
    pair()
    spec = replace(SPEC, texels=16, samples=1, objects=("Ball", "Box"))
    _resumed_alike("Pair", spec, out)


def test_parts_with_atlases_of_their_own_mirror_one_another(out: Path) -> None:
    stage = corner()
    specs = part_specs(context.scene, "Corner", replace(SPEC, split=Split.MATERIAL))
    assert [spec.part for spec in specs] == ["Gold", "Blue"]
    found = [
        bake_object(context.scene, "Corner", spec, out, preview=Filter.QUADRILINEAR).files.sidecar
        for spec in specs
    ]
    assert [len(read_layered_sidecar(sidecar).materials) for sidecar in found] == [1, 1]
    front, behind = (view(stage, camera, found) for camera in stage.tuning)
    assert front.psnr() > 29
    assert behind.psnr() > 26
    exported = finished(export_steps(found[1], ExportSpec(Target.GLTF))).folder
    (mesh,) = Glb.read(exported / "Corner.Blue.glb").document["meshes"]
    assert len(mesh["primitives"]) == 1


def test_a_detailed_object_is_shown_by_a_simple_one(out: Path) -> None:
    stage = detailed()
    spec = replace(SPEC, source="High", extrusion=0.06)
    made = bake_object(context.scene, "Low", spec, out, preview=Filter.QUADRILINEAR)
    front, behind = (view(stage, camera, [made.files.sidecar]) for camera in stage.tuning)
    assert front.psnr() > 24.5
    assert behind.psnr() > 24.5
    assert len(read_layered_sidecar(made.files.sidecar).materials) == 2
    blue = front.expected[..., 2] > 2 * front.expected[..., 0]
    assert front.psnr(blue) > 22
    exported = finished(export_steps(made.files.sidecar, ExportSpec(Target.GLTF))).folder
    materials = Glb.read(exported / "Low.glb").document["materials"]
    assert [extension_in(each)["material"] for each in materials] == [0, 1]


def _resumed_alike(name: str, spec: BakeSpec, out: Path) -> None:
    whole = bake_object(context.scene, name, spec, out / "whole").files
    steps = bake_steps(context.scene, name, spec, out / "resumed")
    captured = (step for step in steps if isinstance(step, Progress) and step.stage is Stage.CAPTURE)
    assert any(step.done > step.total / 2 for step in captured)
    steps.close()
    resumed = bake_object(context.scene, name, spec, out / "resumed", resume=True).files
    assert [path.name for path in resumed.images] == [path.name for path in whole.images]
    for one, other in zip((whole.sidecar, *whole.images), (resumed.sidecar, *resumed.images), strict=True):
        assert one.read_bytes() == other.read_bytes(), one.name
