# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake in the artist's own scene: its node group and material as assets, and real copies."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.bake_group import group_in
from radtex_addon.preview.swap import is_on, switch_off, switch_on
from radtex_addon.scene.nodes import open_material
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.ui import registration
from tests.blender.fingerprint import differences
from tests.blender.lookup_stage import add_camera_above, render_exr, set_up_render
from tests.blender.test_swap import LAYERED, NAME, PLAIN, bake_of, ball, digest

context: Any = bpy.context  # to the stubs, every pointer may be None
radtex: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's

SHADOW = BakeSpec(kind=Kind.SHADOW, texels=8, bucket=4, samples=1)
COPY = f"{NAME} (baked copy)"
TITLE = "Ball.radiance"
ALIKE = 1e-4  # of light up to about 1
BY_OSL = 4e-3  # Blender's bilinear filter: see preview/osl.py


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Sidecars of bakes of one ball; not to be written to."""
    specs = {"plain": PLAIN, "layered": LAYERED}
    return {name: bake_of(spec, tmp_path_factory.mktemp(name)) for name, spec in specs.items()}


@pytest.fixture(autouse=True)
def registered(bakes: dict[str, Path]) -> Iterator[None]:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    registration.register()
    yield
    registration.unregister()


def a_ball() -> Any:
    """A ball of the bakes, below a camera in Cycles."""
    made = ball()
    add_camera_above(context.scene, (0, 0), (1, 1), 32)
    set_up_render(context.scene, "CYCLES")
    context.scene.cycles.samples = 4
    return made


def seen(folder: Path) -> Floats:
    return render_exr(context.scene, folder / "view.exr")


def seen_by_preview(item: Any, sidecar: Path, folder: Path) -> Floats:
    switch_on(item, sidecar)
    found = seen(folder)
    switch_off(item)
    assert found[..., :3].max() > 0.1
    return found


@pytest.mark.parametrize("layout", ["plain", "layered"])
def test_the_node_group_shows_what_the_preview_shows(
    bakes: dict[str, Path], layout: str, tmp_path: Path
) -> None:
    item = a_ball()
    wanted = seen_by_preview(item, bakes[layout], tmp_path)
    assert radtex.make_asset(object=NAME, bake=str(bakes[layout])) == {"FINISHED"}
    assert radtex.apply_to_copy(object=NAME, bake=str(bakes[layout])) == {"FINISHED"}
    item.hide_render = True
    copy = bpy.data.objects[COPY]
    assert [slot.material.name for slot in copy.material_slots] == [TITLE]
    np.testing.assert_allclose(seen(tmp_path), wanted, atol=ALIKE)
    material, build = open_material("the user's own")
    color = build.group(bpy.data.node_groups[TITLE])[1]
    build.node("ShaderNodeOutputMaterial", build.node("ShaderNodeEmission", color).outputs[0])
    copy.material_slots[0].material = material
    np.testing.assert_allclose(seen(tmp_path)[..., :3], wanted[..., :3], atol=ALIKE)


@pytest.mark.parametrize("layout", ["plain", "layered"])
def test_the_script_node_shows_it_too(bakes: dict[str, Path], layout: str, tmp_path: Path) -> None:
    item = a_ball()
    wanted = seen_by_preview(item, bakes[layout], tmp_path)
    assert radtex.apply_to_copy(object=NAME, bake=str(bakes[layout]), shader="OSL") == {"FINISHED"}
    assert context.scene.cycles.shading_system
    item.hide_render = True
    material: Any = bpy.data.objects[COPY].material_slots[0].material
    group: Any = group_in(material)
    assert material.name == group.name == f"{TITLE} (OSL)"
    assert any(node.bl_idname == "ShaderNodeScript" for node in group.nodes)
    np.testing.assert_allclose(seen(tmp_path), wanted, atol=BY_OSL)


def test_assets_are_marked_and_made_again_in_place(bakes: dict[str, Path]) -> None:
    ball()
    assert radtex.make_asset(object=NAME, bake=str(bakes["plain"])) == {"FINISHED"}
    material, group = bpy.data.materials[TITLE], bpy.data.node_groups[TITLE]
    for block in (material, group):
        assert block.asset_data.description.startswith("Baked radiance of Ball, 16 x 8 texels, for Eevee")
        assert {tag.name for tag in block.asset_data.tags} == {"RadTex", "radiance", "buckets"}
        block.asset_data.tags.new("mine")
        block.asset_data.catalog_id = "0b2d9e4c-8d0e-4e6f-9a55-0d4ac2b1f001"
    users, build = open_material("the user's own")
    build.node("ShaderNodeOutputMaterial", build.group(group)[0])
    before = {kind: len(getattr(bpy.data, kind)) for kind in ("meshes", "materials", "node_groups", "images")}
    assert radtex.make_asset(object=NAME, bake=str(bakes["plain"])) == {"FINISHED"}
    assert before == {kind: len(getattr(bpy.data, kind)) for kind in before}
    again = bpy.data.node_groups[TITLE]
    assert bpy.data.materials[TITLE] == material
    assert group_in(material) == group_in(users) == again
    assert all(node.outputs["Shader"].is_linked for node in users.node_tree.nodes if node.outputs)
    for block in (material, again):
        assert "mine" in {tag.name for tag in block.asset_data.tags}
        assert block.asset_data.catalog_id == "0b2d9e4c-8d0e-4e6f-9a55-0d4ac2b1f001"


def test_copies_are_objects_of_their_own(bakes: dict[str, Path]) -> None:
    item, parent = ball(), ball("Other")
    home = bpy.data.collections.new("home")
    context.scene.collection.children.link(home)
    home.objects.link(item)
    item.parent, item.location, item.lock_location = parent, (1, 2, 3), (True, True, True)
    item.keyframe_insert("rotation_euler")
    parent.scale = (2, 1, 1)
    context.view_layer.update()
    switch_on(item, bakes["plain"])
    flags = [is_on(item), item.hide_render, bpy.data.objects["Other"].hide_render]
    for _ in range(2):
        assert radtex.apply_to_copy(object=NAME, bake=str(bakes["plain"])) == {"FINISHED"}
    context.view_layer.update()
    switch_off(item)
    made: list[Any] = [bpy.data.objects[f"{COPY}{end}"] for end in ("", ".001")]
    first, second = made
    assert flags == [True, True, False]
    assert first.data != second.data
    assert first.material_slots[0].material == second.material_slots[0].material
    for copy in made:
        assert [home.name for home in copy.users_collection] == ["Radiance Textures"]
        assert (copy.parent, copy.animation_data, copy.hide_render, is_on(copy)) == (None, None, False, False)
        assert not any(copy.lock_location)
        np.testing.assert_allclose(copy.matrix_world, item.matrix_world, atol=1e-6)
    assert list(context.view_layer.objects.selected) == [second]
    second.location.x += 5
    context.view_layer.update()
    assert second.matrix_world.translation.x == item.matrix_world.translation.x + 5


def test_a_copy_keeps_its_bake_when_one_of_another_folder_is_applied(
    bakes: dict[str, Path], tmp_path: Path
) -> None:
    ball()
    night = Path(shutil.copytree(bakes["plain"].parent, tmp_path / "night")) / bakes["plain"].name
    for sidecar in (bakes["plain"], night, bakes["plain"]):
        assert radtex.apply_to_copy(object=NAME, bake=str(sidecar)) == {"FINISHED"}
    first, second, third = (
        bpy.data.objects[f"{COPY}{end}"].material_slots[0].material for end in ("", ".001", ".002")
    )
    assert first != second
    assert first == third


@pytest.mark.parametrize("operator", ["apply_to_copy", "make_asset"])
def test_one_undo_takes_it_back(bakes: dict[str, Path], operator: str) -> None:
    ball()
    bpy.ops.ed.undo_push(message="before")
    before = digest()
    getattr(radtex, operator)(object=NAME, bake=str(bakes["plain"]))
    assert differences(before, digest()) != {}
    bpy.ops.ed.undo()
    assert differences(before, digest()) == {}
    bpy.ops.ed.redo()
    assert TITLE in bpy.data.materials


def test_where_osl_cannot_be_used_the_remedy_is_said(
    bakes: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    ball()
    before = digest()
    context.scene.cycles.device = "GPU"
    with pytest.raises(RuntimeError, match="Device to CPU, or choose the nodes for Eevee and Cycles"):
        radtex.make_asset(object=NAME, bake=str(bakes["plain"]), shader="OSL")
    context.scene.cycles.device = "CPU"
    assert differences(before, digest()) == {}
    monkeypatch.setitem(sys.modules, "oslquery", None)
    for operator in (radtex.make_asset, radtex.apply_to_copy):
        with pytest.raises(RuntimeError, match=r"this Blender has no OSL .* or the node group"):
            operator(object=NAME, bake=str(bakes["plain"]), shader="OSL")
    assert differences(before, digest()) == {}


def test_a_kind_without_a_script_is_refused_and_leaves_nothing(tmp_path: Path) -> None:
    ball()
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    context.scene.collection.objects.link(sun)
    made = bake_object(context.scene, NAME, SHADOW, tmp_path, preview=Filter.NEAREST)
    before = digest()
    sidecar = str(made.files.sidecar)
    with pytest.raises(RuntimeError, match=r"kind shadow, which has no Script node \(OSL\)"):
        radtex.apply_to_copy(object=NAME, bake=sidecar, shader="OSL")
    assert differences(before, digest()) == {}
    assert radtex.make_asset(object=NAME, bake=sidecar) == {"FINISHED"}
    group: Any = bpy.data.node_groups["Ball.shadow"]
    targets = {driver.driver.variables[0].targets[0].id for driver in group.animation_data.drivers}
    assert targets == {sun, sun.data}


def test_a_missing_preview_is_named(bakes: dict[str, Path], tmp_path: Path) -> None:
    ball()
    folder = shutil.copytree(bakes["plain"].parent, tmp_path / "bake")
    (folder / "Ball.preview.blend").unlink()
    with pytest.raises(RuntimeError, match="bake again with a preview"):
        radtex.apply_to_copy(object=NAME, bake=str(folder))
    assert COPY not in bpy.data.objects
