# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Some lamps alone in the layered layout: no other light is in any part of it, and the sum is the whole."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.fragments import Fragments
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import sample_layered
from radtex_addon.forms.layered.lookup.environment import MOST_LAMPS
from radtex_addon.forms.layered.shader_values import definitions
from radtex_addon.job import bake_object
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.scene.lights.lamps import each_light
from radtex_addon.scene.lights.put_out import lit_by_lamps_alone
from radtex_addon.scene.scratch import scratch_scene
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context

SPEC = BakeSpec(layout=Layout.LAYERED, texels=8, samples=4, uv_layer="UVMap")
WHITE = (0.8, 0.4, 0.2)
NOON = (1.5, 0.75, 0.375)  # irradiance on what faces the sun
COUNT = 64


def floor(roughness: float = 1.0) -> None:
    """A floor under a sun, a panel, another sun that an empty instances, a world, and a thing that glows."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    material = stage.material("Floor", "ShaderNodeBsdfDiffuse", Color=(*WHITE, 1))
    if roughness < 1:
        material = stage.material("Floor", "ShaderNodeBsdfPrincipled", Roughness=roughness)
    context.object.data.materials.append(material)
    suns = {"Noon": [part / 3 for part in NOON], "Hidden": (1.0, 1.0, 1.0)}
    for name, colour in suns.items():
        bpy.ops.object.light_add(type="SUN")
        context.object.name = name
        context.object.data.energy, context.object.data.angle = 3, 0
        context.object.data.color = colour
    instanced = bpy.data.collections.new("Instanced")
    instanced.objects.link(context.object)
    context.scene.collection.objects.unlink(context.object)
    bpy.ops.object.empty_add()
    context.object.instance_type, context.object.instance_collection = "COLLECTION", instanced
    bpy.ops.object.light_add(type="AREA", location=(0, 0, 2))
    context.object.name = "Panel"
    context.object.data.size, context.object.data.energy = 1, 40
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(0, 1.5, 0.6))
    glow = stage.material("Glow", "ShaderNodeEmission", Color=(1, 1, 1, 1), Strength=5)
    context.object.data.materials.append(glow)
    stage.world((0.1, 0.2, 0.3))
    stage.clamps_off()


def lit(out: Path, lights: tuple[str, ...], unwraps: Unwraps | None = None) -> Floats:
    """Light (N, 3) at random places of the floor, to random viewers."""
    made = bake_object(context.scene, "Floor", replace(SPEC, lights=lights), out, unwraps=unwraps)
    atlas, facts = read_layered(made.files.sidecar)
    assert facts.bake.lights == lights
    rng = np.random.default_rng(7)
    uv = rng.uniform(0.25, 0.75, (COUNT, 2))
    viewer = rng.normal(size=(COUNT, 3))
    viewer[:, 2] = np.abs(viewer[:, 2]) + 0.3
    viewer /= np.linalg.norm(viewer, axis=1, keepdims=True)
    place = np.concatenate([2 * uv - 1, np.zeros((COUNT, 1))], axis=1)
    x, up = np.tile([1.0, 0, 0], (COUNT, 1)), np.tile([0, 0, 1.0], (COUNT, 1))
    y = np.tile([0, 1.0, 0], (COUNT, 1))
    at = Fragments(uv, up, viewer, place, np.zeros(COUNT, dtype=int), x, y)
    return sample_layered(atlas, at.single())


def test_one_lamp_alone_gives_its_light_and_no_other(out: Path) -> None:
    floor()
    before = fingerprint()
    found = lit(out, ("Noon",))
    assert differences(before, fingerprint()) == {}
    expected = np.array(WHITE) / pi * np.array(NOON)
    print(f"\noff by {np.abs(found / expected - 1).max():.1%}")
    assert np.abs(found / expected - 1).max() < 0.02


@pytest.mark.one_blender
def test_all_lamps_and_the_world_add_up_to_the_whole(out: Path) -> None:
    floor(roughness=0.3)
    lights = each_light(context.view_layer)
    assert lights == (("Noon",), ("Panel",), ("world",))
    unwraps: Unwraps = {}
    parts = [lit(out, light, unwraps) for light in lights]
    whole = lit(out, (), unwraps)
    mean = np.sum([part.mean(axis=0) for part in parts], axis=0) / whole.mean(axis=0)
    print(f"\nthe sum of the means is {mean} of the whole's")
    assert min(part.mean() for part in parts) > 0.01
    assert np.abs(mean - 1).max() < 0.05


def test_what_another_file_lights_is_refused_and_nothing_is_left_dark(tmp_path: Path) -> None:
    floor()
    library = tmp_path / "lamps.blend"
    cube = next(item for item in context.scene.objects if item.type == "MESH" and item.name != "Floor")
    bpy.data.libraries.write(str(library), {cube}, fake_user=True)
    bpy.data.objects.remove(cube)
    bpy.data.materials.remove(bpy.data.materials["Glow"])
    libraries: Any = bpy.data.libraries
    with libraries.load(str(library), link=True) as (there, taken):
        taken.objects = there.objects
    context.scene.collection.objects.link(taken.objects[0])
    before = fingerprint()
    words = "'Glow' of .*lamps.blend gives light, which cannot be left out of a bake of Noon alone"
    with (
        scratch_scene(context.scene) as scratch,
        pytest.raises(InputError, match=words),
        lit_by_lamps_alone(scratch, ("Noon",)),
    ):
        pass
    assert differences(before, fingerprint()) == {}


@pytest.mark.one_blender
def test_of_many_lamps_the_eight_brightest_are_mirrored(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A bake that mirrors more than shaders take could not be exported."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    metal = stage.material("Floor", "ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=0.2)
    context.object.data.materials.append(metal)
    for number in range(12):
        bpy.ops.object.light_add(type="POINT", location=(2 * np.cos(number / 2), 2 * np.sin(number / 2), 2))
        context.object.data.energy = 10.0 * (1 + (5 * number) % 12)  # in no order
    stage.world((0.1, 0.1, 0.1))
    made = bake_object(context.scene, "Floor", replace(SPEC, samples=16), out)
    atlas, facts = read_layered(made.files.sidecar)
    assert "12 lamps light the object: the 8 that give most light" in caplog.text
    found = [float(lamp.irradiance.sum()) for lamp in atlas.around.lamps]
    strengths = [1 + (5 * number) % 12 for number in range(12)]
    kept = [strength for strength in strengths if strength > 4]
    assert np.argsort(found).tolist() == np.argsort(kept).tolist(), "in the scene's order"
    assert definitions(facts)["RADTEX_LAMPS"] == MOST_LAMPS
