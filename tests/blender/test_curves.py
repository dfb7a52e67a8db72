# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves, surfaces, texts and metaballs are baked as what they evaluate to, and shown as meshes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.sampler import Filter
from radtex_addon.formats.sidecar_file import opened
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.job import bake_object
from radtex_addon.job.assets import read_shown
from radtex_addon.preview.swap import copy_of, switch_off, switch_on
from radtex_addon.scene.digests import read_scene
from radtex_addon.scene.mesh.about_area import about_area
from radtex_addon.scene.mesh.copy import copy_object
from radtex_addon.scene.preview_file import appended
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage
from tests.blender.ui_stage import registered

context: Any = bpy.context  # to the stubs, every pointer may be None
SPEC = BakeSpec(texels=64, samples=1, layout=Layout.LAYERED)
PLAIN = BakeSpec(texels=16, bucket=2, samples=1)
KINDS = ("Cable", "Sign", "Drop", "Cushion")


@pytest.fixture
def scene(empty_file: None) -> Any:
    """A cable, a sign, a drop of two metaballs and a cushion of NURBS; the cable's parent is stretched."""
    stage.hdri(stage.world())
    bpy.ops.curve.primitive_bezier_circle_add(location=(0, 0, 1))
    _called("Cable").data.bevel_depth = 0.2
    bpy.ops.object.text_add(location=(3, 0, 0), rotation=(1.3, 0, 0.2))
    _called("Sign").data.extrude = 0.1
    bpy.ops.object.metaball_add(location=(6, 0, 0))
    _called("Drop")
    bpy.ops.object.metaball_add(location=(7, 0, 0))
    context.object.name = "Drop.001"
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(location=(9, 0, 0))
    _called("Cushion")
    bpy.ops.curve.primitive_bezier_curve_add(location=(12, 0, 0))
    context.object.name = "Line"
    holder = bpy.data.objects.new("Holder", None)
    context.scene.collection.objects.link(holder)
    holder.scale, holder.rotation_euler = (1, 2, 1), (0, 0, 0.5)
    bpy.data.objects["Cable"].parent = holder
    bpy.data.objects["Cable"].rotation_euler.x = 0.3
    context.view_layer.update()
    return context.scene


def _called(name: str) -> Any:
    context.object.name = name
    context.object.data.materials.append(
        stage.material(name, "ShaderNodeBsdfPrincipled", Roughness=0.3, Base_Color=(0.2, 0.5, 0.8, 1))
    )
    return context.object


@pytest.mark.one_blender
@pytest.mark.parametrize("name", ["Sign"])
def test_a_bake_is_that_of_the_same_mesh(scene: Any, tmp_path: Path, name: str) -> None:
    found = [_baked(scene, name, tmp_path / "as it is")]
    for other in list(bpy.data.objects):
        other.select_set(other.name == name)
    context.view_layer.objects.active = bpy.data.objects[name]
    assert bpy.ops.object.convert(target="MESH") == {"FINISHED"}
    found.append(_baked(scene, name, tmp_path / "converted"))
    for field in ("colour", "irradiance", "own", "rest"):
        first, second = (np.asarray(getattr(atlas, field), dtype=np.float64) for atlas in found)
        np.testing.assert_allclose(first, second, atol=2e-2 * np.abs(second).max(), err_msg=field)


def _baked(scene: Any, name: str, folder: Path) -> LayeredAtlas:
    bake_object(scene, name, SPEC, folder)
    return read_layered(opened(folder / f"{name}.radiance.json"))[0]


def test_a_preview_stands_in_its_place(scene: Any, tmp_path: Path) -> None:
    item = scene.objects["Cable"]
    item.constraints.new("COPY_ROTATION").target = scene.objects["Holder"]
    item.keyframe_insert("scale", frame=1)
    item.driver_add("location", 0).driver.expression = "2"
    context.view_layer.update()
    place = np.array(item.matrix_world)
    bake_object(scene, "Cable", PLAIN, tmp_path, preview=Filter.QUADRILINEAR)
    with appended(tmp_path / "Cable.preview.blend", ("Cable",)) as (copy,):
        assert copy is not None
        assert copy.type == "MESH"
        scene.collection.objects.link(copy)
        context.view_layer.update()
        np.testing.assert_allclose(np.array(copy.matrix_world), place, atol=1e-5)
        moved: Any = copy.animation_data
        assert (len(copy.constraints), len(moved.drivers)) == (1, 1)
        assert moved.action.name.startswith(item.animation_data.action.name)


def test_the_panel_shows_a_bake_in_the_place_of_a_cable(scene: Any, tmp_path: Path) -> None:
    item = scene.objects["Cable"]
    sidecar = tmp_path / "Cable.radiance.json"
    with registered():
        bake_object(scene, "Cable", PLAIN, tmp_path, preview=Filter.QUADRILINEAR)
        before = [one.name for one in scene.objects]
        switch_on(item, sidecar)
        copy = copy_of(item)
        assert copy is not None
        assert (copy.type, item.hide_render) == ("MESH", True)
        switch_off(item)
        assert (item.hide_render, [one.name for one in scene.objects]) == (False, before)


def test_their_surfaces_are_known_before_a_bake(scene: Any) -> None:
    layer = context.view_layer
    items = [scene.objects[name] for name in KINDS]
    assert all(about_area(item, layer).surface > 1 for item in items)
    assert about_area(scene.objects["Line"], layer).surface == 0
    surfaces = read_shown(scene)(items)
    assert all(surface is not None and surface.areas.sum() > 1 for surface in surfaces)
    assert read_shown(scene)([scene.objects["Line"], scene.objects["Drop.001"]]) == [None, None]


def test_a_change_of_a_curve_is_its_own(scene: Any) -> None:
    def asked() -> Any:
        with scratch_scene(scene) as scratch:
            return read_scene(scratch).of_bake("Cable", SPEC, context.view_layer)

    before = asked()
    assert asked() == before
    scene.objects["Cable"].data.bevel_depth = 0.3
    after = asked()
    assert after.mesh != before.mesh
    assert after.surroundings == before.surroundings


def test_a_copy_has_the_objects_rays(scene: Any) -> None:
    item = scene.objects["Sign"]
    item.visible_glossy = False
    item["mine"] = 3
    copy: Any = copy_object(item, bpy.data.meshes.new("Sign"))
    assert (copy.visible_glossy, copy.visible_diffuse, copy["mine"]) == (False, True, 3)
