# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Atlases of several objects, or of parts of one, once they are baked: shown in the scene, and exported."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.sidecar_file import SidecarFile
from radtex_addon.job import bake_object, part_specs
from radtex_addon.preview.swap import is_on, switch_all_on, switch_off
from radtex_addon.report.finished_bake import check_whole, find_bake, find_bakes
from radtex_addon.settings.spec import BakeSpec, Split
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui import registration
from radtex_addon.ui.settings.request import request_of, values_of
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.test_together import ROOM, room, two_coloured
from tests.blender.ui_stage import ops
from tests.finished_bakes import finished_bake

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

QUICK = BakeSpec(texels=48, bucket=2, samples=1)


@pytest.fixture
def registered() -> Iterator[None]:
    registration.register()
    yield
    registration.unregister()


def baked_room(out: Path) -> Path:
    """The sidecar of the room in one atlas; the room is open."""
    finished_bake(out, bake_room)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    room()
    return out / "Room.radiance.json"


def bake_room(out: Path) -> None:
    room()
    spec = replace(QUICK, objects=tuple(ROOM))
    bake_object(context.scene, "Room", spec, out, preview=Filter.NEAREST)


def baked_parts(out: Path) -> list[Path]:
    """The sidecars of the cube's parts; the cube is open."""
    finished_bake(out, bake_parts)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    two_coloured()
    return sorted(out.glob("*.json"), reverse=True)


def bake_parts(out: Path) -> None:
    two_coloured()
    for part in part_specs(context.scene, "Cube", replace(QUICK, split=Split.MATERIAL)):
        bake_object(context.scene, "Cube", part, out, preview=Filter.NEAREST)


def test_objects_that_share_an_atlas_share_its_material_and_image(out: Path) -> None:
    sidecar = baked_room(out)
    before, images = fingerprint(), len(bpy.data.images)
    items = [context.scene.objects[name] for name in ROOM]
    made = switch_all_on(items, sidecar)
    worn = {slot.material for preview in made for slot in preview.copy.material_slots}
    assert [material.name for material in worn] == ["RadTex Room"]
    assert len(bpy.data.images) == images + 1
    assert all(item.hide_render for item in items)
    for item in items:
        switch_off(item)
    assert not any(map(is_on, items))
    assert differences(before, fingerprint()) == {}


def test_one_of_them_can_be_shown_alone_and_a_stranger_cannot(out: Path) -> None:
    sidecar = baked_room(out)
    (preview,) = switch_all_on([context.scene.objects["Middle"]], sidecar)
    np.testing.assert_allclose(np.array(preview.copy.matrix_world), np.array(preview.original.matrix_world))
    stranger = context.scene.objects["Left"].copy()
    context.scene.collection.objects.link(stranger)
    with pytest.raises(InputError, match=r"'Middle', 'Right', and 'Left[.]001' is none of them"):
        switch_all_on([stranger], sidecar)
    assert not is_on(stranger)


def test_the_atlas_is_found_by_its_name_and_by_its_objects(out: Path) -> None:
    sidecar = baked_room(out)
    assert (
        find_bake(out, "Room") == find_bake(out, "Right") == find_bake(out, None) == SidecarFile.read(sidecar)
    )
    alone = bake_object(context.scene, "Right", QUICK, out).files.sidecar
    assert find_bake(out, "Right").path == alone
    check_whole(sidecar)  # which a report judges


def test_parts_are_shown_together(out: Path) -> None:
    sidecars = baked_parts(out)
    cube = context.scene.objects["Cube"]
    (preview,) = switch_all_on([cube], sidecars[0])
    worn = [slot.material.name for slot in preview.copy.material_slots]
    assert worn == ["RadTex Cube Hot", "RadTex Cube Cold / wet"]
    index = [polygon.material_index for polygon in preview.copy.data.polygons]
    assert index == [0] * 6 + [1] * 6
    assert [found.path for found in find_bakes(out, "Cube", "exported")] == sorted(sidecars)
    with pytest.raises(InputError, match="name one of these files instead of the folder"):
        find_bake(out, "Cube")
    with pytest.raises(InputError, match="is of a part of an object, which no report judges"):
        check_whole(sidecars[0])


def test_an_export_has_each_object_of_the_atlas_as_a_node_and_few_draw_calls(out: Path) -> None:
    sidecar = baked_room(out)
    before = fingerprint()
    made = finished(export_steps(sidecar, ExportSpec(Target.GLTF)))
    assert differences(before, fingerprint()) == {}
    glb = Glb.read(made.folder / "Room.glb")
    document = glb.document
    assert [node["name"] for node in document["nodes"]] == list(ROOM)
    assert document["scenes"][0]["nodes"] == [0, 1, 2]
    meshes = [document["meshes"][node["mesh"]] for node in document["nodes"]]
    assert [mesh["name"] for mesh in meshes] == list(ROOM)
    primitives = [primitive for mesh in meshes for primitive in mesh["primitives"]]
    assert len(primitives) == 3, "a draw call for each object"
    assert len(document["materials"]) == 1
    along = [glb.accessor(each["attributes"]["POSITION"])[:, 0] for each in primitives]
    middles = [(one.min() + one.max()) / 2 for one in along]
    assert np.allclose(middles, [-1, 0, 1], atol=1e-4), "each in its place in the world"
    assert [glb.accessor(each["indices"]).size for each in primitives] == [36] * 3
    manifest = json.loads((made.folder / "Room.export.json").read_text())
    assert manifest["bake"]["objects"] == list(ROOM)


def test_a_loader_that_takes_one_mesh_has_all_objects_in_it(out: Path) -> None:
    made = finished(export_steps(baked_room(out), ExportSpec(Target.UNREAL)))
    (mesh,) = Glb.read(made.folder / "Room.glb").document["meshes"]
    assert mesh["name"] == "Room"
    assert len(mesh["primitives"]) == 1


def test_an_export_of_a_part_has_its_triangles_alone(out: Path) -> None:
    hot, _ = baked_parts(out)
    made = finished(export_steps(hot, ExportSpec(Target.GLTF)))
    assert made.folder.name == "Cube.Hot.gltf"
    glb = Glb.read(made.folder / "Cube.Hot.glb")
    corners = glb.accessor(glb.document["meshes"][0]["primitives"][0]["indices"])
    assert corners.size == 18


@pytest.mark.usefixtures("registered")
def test_the_window_shows_and_exports_all(out: Path) -> None:
    baked_room(out)
    assert ops.radtex.preview_toggle(object="Room", bake=str(out), action="ON") == {"FINISHED"}
    assert all(is_on(context.scene.objects[name]) for name in ROOM)
    assert ops.radtex.preview_toggle(object="Room", bake=str(out), action="OFF") == {"FINISHED"}
    for name in ROOM:
        assert not is_on(context.scene.objects[name])
        context.scene.objects[name].select_set(True)
    assert ops.radtex.export(target="raw", bake=str(out)) == {"FINISHED"}
    assert [path.name for path in out.iterdir() if path.is_dir()] == ["Room.raw"]


@pytest.mark.usefixtures("registered")
def test_the_panel_asks_for_one_atlas_or_one_for_each_part(out: Path) -> None:
    room()
    settings = context.scene.radtex
    settings.together, settings.atlas_name, settings.directory = "one", "Room", str(out)

    def asked(*names: str, guess: bool = False) -> tuple[tuple[str, BakeSpec], ...]:
        return request_of(values_of(settings), names).asked(context.scene, guess=guess)

    ((name, spec),) = asked(*ROOM)
    assert (name, spec.objects) == ("Room", tuple(ROOM))
    ((name, spec),) = asked("Left")  # nobody to share with
    assert (name, spec.objects) == ("Left", ())
    settings.atlas_name = " "
    with pytest.raises(InputError, match="the atlas that objects share has no name"):
        asked(*ROOM)
    two_coloured()
    settings.split = "material"
    for guess in (True, False):
        bakes = asked("Cube", guess=guess)
        assert [(name, each.part) for name, each in bakes] == [("Cube", "Hot"), ("Cube", "Cold / wet")]
    settings.part = "Hot"
    assert len(asked("Cube")) == 1
