# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Atlases of several objects, and of parts, among other bakes of the objects: found, shown, kept apart."""

from __future__ import annotations

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
from radtex_addon.export.gltf import to_gltf
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.job import bake_object
from radtex_addon.job.assets import find_assets, read_shown
from radtex_addon.job.layout_choice import OpenLayout
from radtex_addon.job.variants import variants_in
from radtex_addon.preview.swap import copy_of
from radtex_addon.report.finished_bake import find_bakes
from radtex_addon.report.shown import bakes_of, shown_bake
from radtex_addon.report.side_by_side import ComparisonSpec, compare_steps
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec, Kind, Split, View
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui.panel import jobs_panel
from radtex_addon.worker.handover import hand_over
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.orders import order_bake
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_export_gltf import corners
from tests.blender.test_together import QUICK, ROOM, room, triangles_in, two_coloured
from tests.blender.ui_stage import ops, registered

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

TOGETHER = replace(QUICK, objects=tuple(ROOM))
TINY = replace(QUICK, texels=24)
HOT, COLD = (replace(TINY, split=Split.MATERIAL, part=part) for part in ("Hot", "Cold / wet"))


@pytest.fixture
def window() -> Iterator[None]:
    with registered():
        yield


def bake(name: str, spec: BakeSpec, out: Path, preview: bool = True, **options: Any) -> Path:
    """The sidecar of a bake with a preview."""
    shown = Filter.NEAREST if preview else None
    return bake_object(context.scene, name, spec, out, preview=shown, **options).files.sidecar


def worn_materials(name: str) -> set[str]:
    """What the preview of an object wears."""
    copy = copy_of(context.scene.objects[name])
    assert copy is not None
    return {slot.material.name for slot in copy.material_slots}


# previews of parts


def test_a_part_of_another_view_is_shown_as_it_is(out: Path) -> None:
    two_coloured()
    bake("Cube", replace(COLD, kind=Kind.TRANSFER, texels=16, view=View.AROUND), out)
    bake("Cube", replace(HOT, kind=Kind.TRANSFER, texels=16), out)
    _, worn = triangles_in(out / "Cube.material.preview.blend", "Cube")
    assert worn == ["RadTex Cube Hot"] * 6 + ["Cold / wet"] * 6


def test_a_part_of_another_layout_is_shown_as_it_is(out: Path) -> None:
    two_coloured()
    cold = bake("Cube", COLD, out)
    text = cold.read_text()
    assert text.count('"layout": "buckets"') == 1
    cold.write_text(text.replace('"layout": "buckets"', '"layout": "layered"'))
    bake("Cube", HOT, out)
    _, worn = triangles_in(out / "Cube.material.preview.blend", "Cube")
    assert worn == ["RadTex Cube Hot"] * 6 + ["Cold / wet"] * 6


def test_another_kind_does_not_take_the_preview_that_parts_share(out: Path) -> None:
    two_coloured()
    bake("Cube", HOT, out)
    shown = out / "Cube.material.preview.blend"
    before = shown.stat().st_mtime_ns
    other = replace(HOT, kind=Kind.SHADOW, half=True)
    with pytest.raises(
        InputError, match=r"Cube\.material\.preview\.blend is already there, and shows no shad"
    ):
        bake("Cube", other, out)
    assert shown.stat().st_mtime_ns == before
    bake("Cube", other, out, overwrite=True)
    assert shown.stat().st_mtime_ns > before
    bake("Cube", COLD, out)  # of whose kind there is a part


# frames, and lamps alone


def test_of_parts_the_plain_bakes_go_before_their_frames(out: Path) -> None:
    two_coloured()
    frames = [bake("Cube", replace(part, frame=2), out, preview=False) for part in (HOT, COLD)]
    assert variants_in(out, "Cube", "radiance") == tuple(sorted(frames))
    assert _found(out) == sorted(frames)
    bake("Cube", replace(HOT, frame=3), out, preview=False)
    with pytest.raises(InputError, match="name one of these files instead of the folder"):
        find_bakes(out, "Cube", "exported")
    plain = bake("Cube", HOT, out)
    assert _found(out) == [plain]
    assert variants_in(out, "Cube", "radiance") == ()
    assert shown_bake(out, "Cube").path == plain
    whole = bake("Cube", TINY, out)
    assert _found(out) == [whole]


def test_parts_of_any_kind_are_shown(out: Path) -> None:
    two_coloured()
    sidecar = bake("Cube", replace(HOT, kind=Kind.SHADOW, half=True), out)
    assert shown_bake(out, "Cube").path == sidecar


def _found(out: Path) -> list[Path]:
    return [found.path for found in find_bakes(out, "Cube", "exported")]


# several objects, by their name


@pytest.mark.usefixtures("window")
def test_what_the_atlas_shows_goes_before_bakes_of_its_objects(out: Path) -> None:
    room()
    bake("Left", TINY, out)
    bake("Room", TOGETHER, out)
    assert ops.radtex.preview_toggle(object="Room", bake=str(out), action="ON") == {"FINISHED"}
    assert {name: worn_materials(name) for name in ROOM} == {name: {"RadTex Room"} for name in ROOM}
    ops.radtex.preview_toggle(object="Room", bake=str(out), action="OFF")
    ops.radtex.preview_toggle(object="Left", bake=str(out))
    assert worn_materials("Left") == {"RadTex Left"}


@pytest.mark.usefixtures("window")
def test_a_job_shows_its_own_bake_and_resumes_that_of_several_objects(out: Path, tmp_path: Path) -> None:
    room()
    handover = hand_over(context.scene, tmp_path)
    order = order_bake(handover, "Room", TOGETHER, out, Filter.NEAREST)
    assert order.shared == tuple(ROOM)
    files = (out / "Room.radiance.exr", out / "Room.radiance.json", out / "Room.preview.blend")
    done, failed = RecordedLayout(), RecordedLayout()
    jobs_panel._draw_job(done, Job(1, order, JobState.DONE, files=files))
    drawn = dict(done.buttons)
    for name in ("radtex.preview_toggle", "radtex.compare", "radtex.export", "radtex.show_in_browser"):
        assert (drawn[name].object, drawn[name].bake) == ("Room", str(files[1]))
    jobs_panel._draw_job(failed, Job(2, order, JobState.FAILED))
    assert [name for name, _ in failed.buttons] == [
        "radtex.fold_job",
        "radtex.clear_jobs",
        "radtex.bake",
        "radtex.copy_report",
    ]
    again = dict(failed.buttons)["radtex.bake"]
    assert (again.objects.split("\n"), again.atlas_name) == (list(ROOM), "Room")
    assert (again.together, again.texels, again.resume) == ("one", TOGETHER.texels, True)
    failed.buttons.clear()
    alone = order_bake(handover, "Left", TINY, out, Filter.NEAREST)
    jobs_panel._draw_job(failed, Job(3, alone, JobState.CANCELLED))
    assert [name for name, _ in failed.buttons] == ["radtex.fold_job", "radtex.clear_jobs", "radtex.bake"]


@pytest.mark.usefixtures("window")
def test_the_atlas_is_exported_by_its_name_and_into_one_folder(out: Path, tmp_path: Path) -> None:
    room()
    bake("Left", TINY, out)
    bake("Room", TOGETHER, out)
    chosen = {"target": "raw", "bake": str(out), "directory": str(tmp_path / "one")}
    assert ops.radtex.export(object="Room", **chosen) == {"FINISHED"}
    assert (tmp_path / "one" / "Room.export.json").is_file()
    for name in ("Middle", "Right"):  # two objects, and one bake
        context.scene.objects[name].select_set(True)
    context.scene.objects["Left"].select_set(False)
    assert ops.radtex.export(overwrite=True, **chosen) == {"FINISHED"}
    context.scene.objects["Left"].select_set(True)
    with pytest.raises(RuntimeError, match="Several bakes do not fit in one folder"):
        ops.radtex.export(overwrite=True, **chosen)
    with pytest.raises(RuntimeError, match="holds no bake of 'Hall': it has 'Left', 'Room'"):
        ops.radtex.export(object="Hall", **chosen)


@pytest.mark.usefixtures("window")
def test_an_atlas_may_be_called_like_the_empty_that_holds_its_objects(out: Path, tmp_path: Path) -> None:
    """As in what glTF files bring: it is named by that."""
    room()
    root = bpy.data.objects.new("Room", None)
    context.scene.collection.objects.link(root)
    for name in ROOM:
        context.scene.objects[name].parent = root
    context.view_layer.update()
    (asset,) = find_assets(
        context.scene, tuple(ROOM), TOGETHER, OpenLayout(), None, read_shown(context.scene)
    )
    assert asset.name == "Room"
    bake("Room", TOGETHER, out)
    chosen = {"object": "Room", "bake": str(out)}
    assert ops.radtex.export(target="raw", directory=str(tmp_path / "one"), **chosen) == {"FINISHED"}
    assert (tmp_path / "one" / "Room.export.json").is_file()
    assert ops.radtex.preview_toggle(**chosen) == {"FINISHED"}
    assert all(copy_of(context.scene.objects[name]) is not None for name in ROOM)


def test_an_atlas_cannot_be_called_as_a_stranger(out: Path) -> None:
    room()
    with pytest.raises(
        InputError, match="the atlas cannot be called 'Left', as an object that has no part in"
    ):
        bake("Left", replace(TINY, objects=("Middle", "Right")), out)
    assert list(out.glob("*")) == []
    bake("Left", replace(TINY, objects=("Left", "Right")), out, preview=False)


def test_a_comparison_loads_the_image_that_objects_share_once(out: Path) -> None:
    room()
    bake("Room", TOGETHER, out)
    bpy.ops.object.camera_add(location=(0, -6, 0), rotation=(np.pi / 2, 0, 0))
    context.scene.camera = context.object
    context.view_layer.update()
    images = len(bpy.data.images)
    steps = compare_steps(
        context.scene,
        bakes_of([context.scene.objects[name] for name in ROOM], out),
        Viewpoint.of_camera(context.scene, context.view_layer),
        ComparisonSpec(pixels=48, samples=1),
    )
    next(steps)
    assert len(bpy.data.images) == images + 1
    assert worn_materials("Left") == worn_materials("Right") == {"RadTex Room"}
    found = finished(steps)
    assert found.figures.psnr > 30
    assert len(bpy.data.images) == images


# the mesh of several objects


def test_the_frame_of_a_mirrored_object_agrees_with_its_triangles_and_uvs(out: Path) -> None:
    room()
    context.view_layer.update()
    middle = context.scene.objects["Middle"]
    centre = np.array(to_gltf(np.array(middle.matrix_world.translation)))
    assert middle.matrix_world.determinant() < 0
    made = finished(export_steps(bake("Room", TOGETHER, out), ExportSpec(Target.GLTF)))
    glb = Glb.read(made.folder / "Room.glb")
    found = [corners(glb, mesh) for mesh in range(3)]
    place, uv, normal, frame = (
        np.stack(values).reshape(3, 12, 3, -1).astype(np.float64)  # one object after the other
        for values in (
            [each.position for each in found],
            [each.uv * (1, -1) for each in found],
            [each.normal for each in found],
            [each.tangent for each in found],
        )
    )
    assert np.abs(place[1].reshape(-1, 3).mean(axis=0) - centre).max() < 1e-4
    first, second = place[:, :, 1] - place[:, :, 0], place[:, :, 2] - place[:, :, 0]
    u, v = np.moveaxis(np.stack([uv[:, :, 1] - uv[:, :, 0], uv[:, :, 2] - uv[:, :, 0]], axis=-1), 2, 0)
    facing = np.cross(first, second)
    middles = place.mean(axis=(1, 2), keepdims=True)
    assert (np.sum(facing * (place.mean(axis=2) - middles[:, :, 0]), axis=-1) > 0).all()  # wound outwards
    facing /= np.linalg.norm(facing, axis=-1, keepdims=True)
    np.testing.assert_allclose(normal, np.broadcast_to(facing[:, :, None], normal.shape), atol=1e-5)
    area = (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])[..., None]
    along_u = (first * v[..., 1:] - second * v[..., :1]) / area
    along_v = (second * u[..., :1] - first * u[..., 1:]) / area
    tangent, sign = frame[..., :3], frame[..., 3:]
    bitangent = sign * np.cross(normal, tangent)
    for ours, true in ((tangent, along_u), (bitangent, along_v)):
        unit = true / np.linalg.norm(true, axis=-1, keepdims=True)
        assert (np.sum(ours * unit[:, :, None], axis=-1) > 0.99).all()
