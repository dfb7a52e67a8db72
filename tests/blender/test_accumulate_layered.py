# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""More samples for a layered bake: other paths, less noise, the same materials and surroundings."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import bmesh
import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.job import bake_object, bake_steps
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context

SPEC = BakeSpec(layout=Layout.LAYERED, texels=16, samples=1, half=False, uv_layer="UVMap")
MORE = replace(SPEC, accumulate=True)
SIDECAR = "Floor.radiance.json"


@pytest.fixture(autouse=True)
def floor(empty_file: None) -> Any:
    """A matt floor that a small bright lamp shines on, and a post that shades it."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    made = context.object
    made.name = "Floor"
    made.data.materials.append(stage.material("Floor", "ShaderNodeBsdfPrincipled", Roughness=0.5))
    bpy.ops.object.light_add(type="AREA", location=(1, 0, 1.5))
    context.object.data.size, context.object.data.energy = 2, 60
    bpy.ops.mesh.primitive_cylinder_add(radius=0.2, depth=1, location=(0, 0, 0.6))
    context.object.data.materials.append(stage.material("Post", "ShaderNodeBsdfDiffuse"))
    stage.world((0.2, 0.3, 0.4))
    return made


def bake(out: Path, spec: BakeSpec, **options: Any) -> LayeredAtlas:
    return read_layered(bake_object(context.scene, "Floor", spec, out, **options).files.sidecar)[0]


def off(found: LayeredAtlas, truth: Floats) -> float:
    return float(np.sqrt(((found.irradiance - truth) ** 2).mean()) / truth.mean())


def test_more_samples_bring_a_bake_nearer_to_one_of_many(out: Path) -> None:
    fine = replace(SPEC, texels=20)
    truth = bake(out / "many", replace(fine, samples=30)).irradiance
    first = bake(out, fine)
    at_once = off(bake(out / "at once", replace(fine, samples=5)), truth)
    bakes = [first, *(bake(out, replace(fine, accumulate=True)) for _ in range(4))]
    errors, latest = [off(one, truth) for one in bakes], bakes[-1]
    print(f"\noff by {', '.join(f'{error:.2%}' for error in errors)}; all at once {at_once:.2%}")
    assert errors[-1] < 0.7 * errors[0]
    assert errors[-1] - at_once < errors[0] - errors[-1]
    assert read_layered(out / SIDECAR)[1].bake.samples == 5
    np.testing.assert_array_equal(latest.colour, first.colour)
    np.testing.assert_array_equal(latest.falloff, first.falloff)
    for name in ("weight", "variance"):
        np.testing.assert_array_equal(getattr(latest.materials[0], name), getattr(first.materials[0], name))
    np.testing.assert_array_equal(latest.around.world.levels[0], first.around.world.levels[0])
    assert np.abs(latest.rest - first.rest).max() > 0


def test_what_glows_is_not_added_once_more(out: Path, floor: Any) -> None:
    """What the floor emits is in its colour and irradiance, which stay, and so not in the rest."""
    tree = floor.data.materials[0].node_tree
    glow = tree.nodes["Principled BSDF"].inputs["Emission Color"]
    tree.links.new(tree.nodes.new("ShaderNodeTexChecker").outputs["Color"], glow)
    tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 20.0
    first = bake(out, SPEC)
    assert first.irradiance.max() > 15
    latest = bake(out, MORE)
    np.testing.assert_array_equal(latest.colour, first.colour)
    np.testing.assert_array_equal(latest.irradiance, first.irradiance)
    assert max(np.abs(one.rest).max() for one in (first, latest)) < 2


def test_a_material_narrower_than_texels_is_one_of_the_bake_s(out: Path, floor: Any) -> None:
    """A face that no middle of a texel lies on, beside paint whose roughness is an image."""
    tree = floor.data.materials[0].node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker").outputs["Factor"]
    tree.links.new(checker, tree.nodes["Principled BSDF"].inputs["Roughness"])
    floor.data.materials.append(stage.material("Stud", "ShaderNodeBsdfDiffuse"))
    mesh: Any = bmesh.new()
    mesh.from_mesh(floor.data)
    corners = [mesh.verts.new((x, y, 0.1)) for x, y in ((0.9, 0.9), (0.91, 0.9), (0.9, 0.91))]
    stud = mesh.faces.new(corners)
    stud.material_index = 1
    for loop, uv in zip(stud.loops, ((0.5, 0.5), (0.505, 0.5), (0.5, 0.505)), strict=True):
        loop[mesh.loops.layers.uv["UVMap"]].uv = uv
    mesh.to_mesh(floor.data)
    mesh.free()
    assert len(bake(out, SPEC).materials) == 2
    assert len(bake(out, MORE).falloff) == 2


def test_new_samples_count_by_their_number(out: Path) -> None:
    before = bake(out, replace(SPEC, samples=4)).irradiance
    again = Path(shutil.copytree(out, out.with_name("again")))
    few = bake(out, MORE).irradiance
    many = bake(again, replace(MORE, samples=16)).irradiance
    assert np.abs(few - before).mean() < 0.7 * np.abs(many - before).mean()


def test_a_stopped_accumulation_is_gone_on_with_to_the_same_bytes(out: Path) -> None:
    bake(out, SPEC)
    whole = bake(Path(shutil.copytree(out, out.with_name("whole"))), MORE)
    steps = bake_steps(context.scene, "Floor", MORE, out)
    for step in steps:
        if step.stage == "fit":
            steps.close()
    latest = bake(out, MORE, resume=True)
    np.testing.assert_array_equal(latest.irradiance, whole.irradiance)
    np.testing.assert_array_equal(latest.rest, whole.rest)


def test_a_bake_of_something_else_stays_what_it_is(out: Path, floor: Any) -> None:
    bake(out, SPEC)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    for spec, words in (
        (replace(MORE, texels=24), "has 16 x 16 texels of 14 cells, this bake 24 x 24"),
        (replace(MORE, lights=("Area",)), "Floor-Area"),
        (MORE, "has 1 materials, the object 2"),
    ):
        if spec is MORE:
            floor.data.materials.append(stage.material("Second", "ShaderNodeBsdfDiffuse"))
            floor.data.polygons[0].material_index = 1
        with pytest.raises(InputError, match=words):
            bake(out, spec)
        assert {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()} == before


def test_a_part_of_the_surface_alone_is_refused() -> None:
    with pytest.raises(InputError, match="the layered layout is accumulated as a whole"):
        replace(MORE, where="Rim")
