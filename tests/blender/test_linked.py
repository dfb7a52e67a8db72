# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of libraries: linked, in linked collections, overridden, of linked data; baked, saved, exported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake import progress
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.job import bake_object
from radtex_addon.report.report_bake import ReportSpec, report_path, report_steps
from radtex_addon.report.side_by_side import ComparisonSpec, compare_steps
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None
data: Any = bpy.data

TINY = BakeSpec(texels=16, bucket=2, samples=1)
NAMES = ("Ball", "Cone")


def write_library(path: Path) -> Path:
    """A collection "Home", and in it another, "Room", with the glowing balls NAMES."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    home, room = bpy.data.collections.new("Home"), bpy.data.collections.new("Room")
    context.scene.collection.children.link(home)
    home.children.link(room)
    for number, name in enumerate(NAMES):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, location=(3 * number, 0, 0))
        context.object.name = context.object.data.name = name
        context.object.data.materials.append(
            stage.material(name, "ShaderNodeEmission", Color=(0.5,) * 3 + (1,))
        )
        room.objects.link(context.object)
        context.scene.collection.objects.unlink(context.object)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world((0.1, 0.1, 0.1))
    return path


def linked_objects(path: Path, names: tuple[str, ...] = NAMES) -> None:
    with data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.objects = list(names)
    for item in wanted.objects:
        context.scene.collection.objects.link(item)


def linked_collection(path: Path) -> Any:
    with data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.collections = ["Home"]
    context.scene.collection.children.link(wanted.collections[0])
    return wanted.collections[0]


def overrides(path: Path) -> None:
    home = linked_collection(path)
    context.view_layer.update()
    home.override_hierarchy_create(context.scene, context.view_layer)
    context.scene.collection.children.unlink(home)


def linked_data(path: Path) -> None:
    with data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.meshes = list(NAMES)
    for mesh in wanted.meshes:
        context.scene.collection.objects.link(bpy.data.objects.new(mesh.name, mesh))


def with_a_stranger(path: Path) -> None:
    """In another scene a local object bears the linked one's name."""
    linked_objects(path)
    other = bpy.data.scenes.new("Other")
    other.collection.objects.link(bpy.data.objects.new("Ball", bpy.data.meshes.new("Stranger")))


def held() -> list[Any]:
    """Every object, what holds it, and how its layer collections are: without counts of users."""
    context.view_layer.update()
    objects = [(item.name, str(item.library), item.hide_render) for item in bpy.data.objects]
    homes = [
        (
            home.name,
            str(home.library),
            [item.name for item in home.objects],
            [item.name for item in home.children],
        )
        for home in (context.scene.collection, *bpy.data.collections)
    ]
    return [objects, homes]


@pytest.mark.parametrize(
    ("way", "together"),
    [
        (linked_objects, False),
        (linked_collection, True),
        (overrides, True),
        (linked_data, False),
        pytest.param(with_a_stranger, False, marks=pytest.mark.one_blender),
        pytest.param(overrides, False, marks=pytest.mark.one_blender),
    ],
)
def test_what_a_library_holds_is_baked_reported_and_exported(
    way: Callable[[Path], object], together: bool, tmp_path: Path, out: Path
) -> None:
    way(write_library(tmp_path / "library.blend"))
    spec, name = (replace(TINY, objects=NAMES), "All") if together else (TINY, "Ball")
    before = held()
    made = bake_object(context.scene, name, spec, out, preview=Filter.QUADRILINEAR).files
    assert held() == before
    if not together:
        found = progress.finished(
            report_steps(context.scene, made.sidecar, ReportSpec(1, 32, 1), report_path(made.sidecar))
        )
        assert found.energy == pytest.approx(1, abs=0.05)
    made_folder = progress.finished(export_steps(made.sidecar, ExportSpec(Target.RAW))).folder
    assert (made_folder / f"{name}.glb").is_file()
    assert made.preview is not None
    bpy.ops.wm.open_mainfile(filepath=str(made.preview))
    worn = {item.name: [slot.material.name for slot in item.material_slots] for item in context.scene.objects}
    baked = NAMES if together else ("Ball",)
    assert {shown: worn[shown] for shown in baked} == {key: [f"RadTex {name}"] for key in baked}
    assert sorted(worn) == sorted(NAMES)


def test_a_flag_of_a_linked_collection_s_view_stays(tmp_path: Path, out: Path) -> None:
    linked_collection(write_library(tmp_path / "library.blend"))
    bpy.ops.mesh.primitive_cube_add()
    home = context.view_layer.layer_collection.children["Home"]
    context.view_layer.active_layer_collection = home.children["Room"]
    layers = [context.scene.view_layers.new(name) for name in ("Hidden", "Excluded")]
    for layer in layers:
        layer.use = False
    hidden, excluded = (layer.layer_collection.children["Home"] for layer in layers)
    hidden.hide_viewport = hidden.children["Room"].holdout = excluded.exclude = True
    context.view_layer.update()
    before = fingerprint()
    made = bake_object(context.scene, "Ball", TINY, out, preview=Filter.QUADRILINEAR).files
    assert set(map(last_part, differences(before, fingerprint()))) <= {"is_library_indirect"}
    bpy.ops.wm.open_mainfile(filepath=str(made.preview))
    hidden, excluded = (
        context.scene.view_layers[name].layer_collection.children["Home"] for name in ("Hidden", "Excluded")
    )
    assert hidden.hide_viewport
    assert hidden.children["Room"].holdout
    assert excluded.exclude


def last_part(path: str) -> str:
    return path.rpartition(".")[2]


def test_a_name_that_several_objects_bear_is_refused(tmp_path: Path, out: Path) -> None:
    first = write_library(tmp_path / "first.blend")
    second = write_library(tmp_path / "second.blend")
    linked_objects(first)
    linked_objects(second, ("Ball",))
    with pytest.raises(
        InputError, match=r"several objects are called 'Ball', of first\.blend and second\.blend"
    ):
        bake_object(context.scene, "Ball", TINY, out)
    bake_object(context.scene, "Cone", TINY, out)
    bpy.data.objects.remove(bpy.data.objects["Ball", str(second)])
    bpy.ops.mesh.primitive_cube_add()
    context.object.name = "Ball"
    with pytest.raises(InputError, match=r"several objects are called 'Ball', of .*this file"):
        bake_object(context.scene, "Ball", TINY, out)


def test_a_linked_object_that_is_overridden_too_has_no_preview(tmp_path: Path, out: Path) -> None:
    home = linked_collection(write_library(tmp_path / "library.blend"))
    other = bpy.data.scenes.new("Other")
    context.view_layer.update()
    home.override_hierarchy_create(other, other.view_layers[0])
    for layer in [item for item in context.scene.collection.children if item.library is None]:
        context.scene.collection.children.unlink(layer)
    assert [item.library is None for item in context.scene.objects] == [False, False]
    with pytest.raises(InputError, match=r"'Ball' is linked, and '.*' is a library override of it"):
        bake_object(context.scene, "Ball", TINY, out, preview=Filter.QUADRILINEAR)
    assert not out.exists()
    bake_object(context.scene, "Ball", TINY, out)


def test_a_linked_source_cannot_be_hidden_for_a_comparison(tmp_path: Path, out: Path) -> None:
    linked_objects(write_library(tmp_path / "library.blend"), ("Ball",))
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=1.1)
    context.object.name = "Low"
    spec = replace(TINY, source="Ball", extrusion=0.5)
    sidecar = bake_object(context.scene, "Low", spec, out, preview=Filter.QUADRILINEAR).files.sidecar
    camera = bpy.data.objects.new("Viewpoint", bpy.data.cameras.new("Viewpoint"))
    context.scene.collection.objects.link(camera)
    context.scene.camera, camera.location = camera, (0, 0, 5)
    context.view_layer.update()
    eye = Viewpoint.of_camera(context.scene, context.view_layer)
    with pytest.raises(InputError, match=r"object 'Ball' is linked from library\.blend, where nothing"):
        next(compare_steps(context.scene, {bpy.data.objects["Low"]: sidecar}, eye, ComparisonSpec(32, 1)))
