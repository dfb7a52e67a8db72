# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Going on with parts and variants, adding to them, and asking for them in the panel."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.core.errors import InputError
from radtex_addon.formats.bucket_files import read_counts
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object, bake_steps, part_specs
from radtex_addon.job.bake_plan import BakePlan, plan_bakes, preflight
from radtex_addon.job.variants import bakes_to_resume, skipped_warning
from radtex_addon.settings.spec import BakeSpec, Kind, Split
from radtex_addon.store.bake_folder import BakeFolder
from radtex_addon.ui.jobs import estimates, jobs
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.settings.request import request_of, values_of
from radtex_addon.worker.job import JobState
from tests.blender.batch_process import Batch
from tests.blender.test_together import ROOM, cube, glow, room, two_coloured
from tests.blender.ui_stage import finish_jobs, ops, preferences, registered, settings

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

QUICK = BakeSpec(texels=24, bucket=2, samples=1, padding=1)
BY_MATERIAL = replace(QUICK, split=Split.MATERIAL)
BY_TILE = replace(QUICK, split=Split.UDIM, uv_layer="UVMap")


@pytest.fixture
def panel(out: Path) -> Iterator[Any]:
    with registered():
        settings().directory = str(out)
        settings().atlas_layout = "buckets"
        for name in ("texels", "bucket", "samples", "padding"):
            setattr(settings(), name, getattr(QUICK, name))
        yield settings()


def parts_baked(out: Path, spec: BakeSpec = BY_MATERIAL) -> tuple[BakeSpec, ...]:
    two_coloured()
    parts = part_specs(context.scene, "Cube", spec)
    for part in parts:
        bake_object(context.scene, "Cube", part, out)
    return parts


def interrupt(spec: BakeSpec, out: Path) -> None:
    """Bake until all is rendered, and no further."""
    steps = bake_steps(context.scene, "Cube", spec, out)
    for step in steps:
        if step.stage is Stage.WRITE:
            break
    steps.close()


def _plan(chosen: Any) -> BakePlan:
    return plan_bakes(context.scene, request_of(values_of(chosen), ("Cube",)))


def asked(out: Path) -> tuple[tuple[str, BakeSpec], ...]:
    return _plan(settings()).wanted


@pytest.mark.parametrize("again", ["accumulate", "refresh"])
def test_what_was_added_to_is_gone_on_with_only_where_it_is_unfinished(again: str, out: Path) -> None:
    more = [
        replace(part, accumulate=again == "accumulate", refresh=again == "refresh")
        for part in parts_baked(out)
    ]
    wanted = [("Cube", part) for part in more]
    with pytest.raises(
        InputError, match=rf"no bake of 'Cube' is unfinished.*{again}e?d already: name those that lack"
    ):
        bakes_to_resume(wanted, out)
    bake_object(context.scene, "Cube", more[0], out)
    with pytest.raises(InputError, match="no bake of 'Cube' is unfinished"):
        bakes_to_resume(wanted, out)
    interrupt(more[1], out)
    assert bakes_to_resume(wanted, out) == (wanted[1],)
    assert skipped_warning(wanted, wanted[1:]).startswith("1 of 2 bakes go on, those that are unfinished")
    assert skipped_warning(wanted, wanted) == ""


def test_the_batch_adds_samples_to_the_unfinished_part_alone_and_says_so(
    tmp_path: Path, out: Path, batch: Batch
) -> None:
    _, cold = parts_baked(out)
    scene = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    words = ["--object=Cube", "--split=material", "--texels=24", "--bucket=2", "--samples=1", "--padding=1"]
    asked_for = [str(scene), *words, f"--out={out}", "--accumulate", "--resume", "--progress=json"]
    refused = batch(*asked_for)
    assert refused.code == 2
    assert "no bake of 'Cube' is unfinished" in refused.err
    interrupt(replace(cold, accumulate=True), out)
    done = batch(*asked_for)
    assert done.code == 0, done.err
    events = [json.loads(line) for line in done.out.splitlines()]
    assert [each["message"][:18] for each in events if each["event"] == "warning"] == ["1 of 2 bakes go on"]
    (made,) = [each for each in events if each["event"] == "done"]
    assert (made["part"], made["objects"]) == ("Cold / wet", [])
    samples = [read_sidecar(next(out.glob(f"Cube.{name}*.json"))).samples for name in ("Hot", "Cold")]
    assert samples == [1, 2]


@pytest.mark.parametrize(
    "spec",
    [
        replace(QUICK, kind=Kind.AO, bucket=4, samples=2),
        replace(QUICK, kind=Kind.AO, bucket=4, samples=3, ao_distance=0.5),
    ],
)
def test_finished_ambient_occlusion_is_known(spec: BakeSpec, out: Path) -> None:
    cube("Cube", glow("Red", (1, 0, 0)), 0)
    assert not BakeFolder("Cube", spec, out).is_finished()
    bake_object(context.scene, "Cube", spec, out)
    assert BakeFolder("Cube", spec, out).is_finished()
    assert not BakeFolder("Cube", replace(spec, samples=spec.samples + 7), out).is_finished()
    assert not BakeFolder("Cube", replace(spec, ao_distance=0.75), out).is_finished()
    assert not BakeFolder("Cube", replace(spec, bucket=8), out).is_finished()


def test_the_panel_goes_on_with_tiles_once_the_first_is_done(panel: Any, out: Path) -> None:
    parts = parts_baked(out, BY_TILE)
    panel.split, panel.uv_layer, panel.resume, panel.preview = "udim", "UVMap", True, False
    with pytest.raises(RuntimeError, match="All variants are finished"):
        ops.radtex.bake(object="Cube")
    lacking = out / "Cube.1012.radiance.json"
    lacking.unlink()
    lacking.with_suffix(".exr").unlink()
    assert [part.part for part in parts] == ["1001", "1012"]
    assert [spec.part for _, spec in asked(out)] == ["1012"]
    assert preflight(context.scene, _plan(panel)).errors == ()
    assert ops.radtex.bake(object="Cube") == {"FINISHED"}
    assert lacking.is_file()


def test_the_panel_goes_on_with_faces_without_material(panel: Any, out: Path) -> None:
    made = two_coloured()
    made.material_slots[1].material = None
    panel.split, panel.resume, panel.preview = "material", True, False
    assert [spec.part for _, spec in asked(out)] == ["Hot", "none"]
    bake_object(context.scene, "Cube", asked(out)[0][1], out)
    assert ops.radtex.bake(object="Cube") == {"FINISHED"}
    assert read_sidecar(out / "Cube.none.radiance.json").samples == QUICK.samples


def test_other_parts_may_be_baked_meanwhile(panel: Any, tmp_path: Path, out: Path) -> None:
    two_coloured()
    preferences().cache_directory = str(tmp_path / "cache")
    panel.split, panel.part, panel.preview = "material", "Hot", False
    jobs.submit(context.scene, [_plan(panel)])
    panel.part = ""
    with pytest.raises(InputError, match="object 'Cube' is being baked there already"):
        jobs.submit(context.scene, [_plan(panel)])
    panel.resume = True
    jobs.submit(context.scene, [_plan(panel)])
    assert [job.order.part for job in jobs.snapshot()] == ["Hot", "Cold / wet"]
    finish_jobs()
    assert [job.state for job in jobs.snapshot()] == [JobState.DONE] * 2, jobs.snapshot()


def test_parts_without_a_face_of_the_place_are_left_out(out: Path) -> None:
    made = two_coloured()
    attribute = made.data.attributes.new("Upper", "BOOLEAN", "FACE")
    attribute.data.foreach_set("value", [True, False, True, False, False, False])
    for part in part_specs(context.scene, "Cube", BY_MATERIAL):
        bake_object(context.scene, "Cube", part, out)
    more = replace(BY_MATERIAL, accumulate=True, where="Upper")
    (found,) = part_specs(context.scene, "Cube", more)
    assert found.part == "Hot"
    files = bake_object(context.scene, "Cube", found, out).files
    facts = read_sidecar(files.sidecar)
    counts = read_counts(facts.texel_samples, facts.width, facts.height, "the sidecar")
    assert {1, 2} <= set(counts.ravel().tolist())
    attribute = made.data.attributes["Upper"]
    attribute.data.foreach_set("value", [False] * 6)
    with pytest.raises(InputError, match="no face belongs to 'Upper'"):
        part_specs(context.scene, "Cube", more)


@pytest.mark.parametrize("split", ["material", "udim"])
def test_an_object_that_is_missing_is_named_though_it_is_to_be_split(panel: Any, split: str) -> None:
    two_coloured()
    panel.uv_layer = "UVMap"
    with pytest.raises(RuntimeError, match="No object 'Nope' in scene"):
        ops.radtex.bake(object="Nope", split=split)
    with pytest.raises(RuntimeError, match="No object 'Nope' in scene"):
        ops.radtex.bake(object="Nope", split=split, resume=True)


def test_no_time_is_told_of_parts(panel: Any) -> None:
    room()
    for name in ROOM:
        context.scene.objects[name].select_set(True)
    assert ops.radtex.estimate() == {"FINISHED"}
    assert panel_state.refresh(context.scene, context.view_layer).seconds is not None
    panel.together = "one"
    assert panel_state.refresh(context.scene, context.view_layer).seconds is not None
    assert ops.radtex.estimate() == {"FINISHED"}
    panel.together, panel.split = "off", "material"
    assert panel_state.refresh(context.scene, context.view_layer).seconds is None
    with pytest.raises(RuntimeError, match="Only the time of whole objects is estimated"):
        ops.radtex.estimate()
    estimates.unregister()


def flat_triangle(place: tuple[float, float]) -> None:
    """The cube of `two_coloured` with a small triangle more, whose coordinates are all in one place."""
    made = two_coloured()
    mesh = made.data
    vertices = [tuple(vertex.co) for vertex in mesh.vertices] + [(0, 0, 0), (0.01, 0, 0), (0, 0.01, 0)]
    faces = [tuple(polygon.vertices) for polygon in mesh.polygons]
    uv = [tuple(each.vector) for each in mesh.uv_layers[0].uv]
    more = bpy.data.meshes.new("More")
    more.from_pydata(vertices, [], [*faces, tuple(range(len(vertices) - 3, len(vertices)))])
    for material in mesh.materials:
        more.materials.append(material)
    layer = more.uv_layers.new(name="UVMap")
    for corner, value in zip(layer.uv, [*uv, place, place, place], strict=True):
        corner.vector = value
    made.data = more


def test_triangles_without_an_area_open_no_tile(out: Path) -> None:
    for place in ((1.0, 0.5), (0.5, 1.0), (2.0, 1.5), (5.0, 0.0), (-0.5, 0.5)):
        flat_triangle(place)
        parts = part_specs(context.scene, "Cube", BY_TILE)
        assert [part.part for part in parts] == ["1001", "1012"], place
        for part in parts:
            bake_object(context.scene, "Cube", part, out, overwrite=True)
        bpy.data.objects.remove(bpy.data.objects["Cube"])
