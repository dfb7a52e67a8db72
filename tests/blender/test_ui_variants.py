# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants in the panel: frames and lamps, each a job with its own row, preview and export; and a cage."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.preview.swap import copy_of, is_on
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.jobs_panel import job_title
from radtex_addon.ui.panel.main_panel import what_is_there
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from radtex_addon.worker.job import JobState
from tests.blender import stage
from tests.blender.ui_stage import finish_jobs, ops, preferences, registered, settings

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None
TINY: dict[str, Any] = {"atlas_layout": "buckets", "texels": 4, "bucket": 2, "samples": 1, "padding": 0}


@pytest.fixture(autouse=True)
def _panel(tmp_path: Path, out: Path) -> Iterator[None]:
    with registered():
        preferences().cache_directory = str(tmp_path / "cache")
        settings().directory = str(out)
        for name, value in TINY.items():
            setattr(settings(), name, value)
        bpy.ops.mesh.primitive_plane_add()
        context.object.name = "Card"
        context.object.data.materials.append(stage.material("White", "ShaderNodeBsdfDiffuse"))
        for name in ("Key", "Fill, left"):
            bpy.ops.object.light_add(type="SUN")
            context.object.name = name
        card = bpy.data.objects["Card"]
        bpy.ops.object.select_all(action="DESELECT")
        card.select_set(True)
        context.view_layer.objects.active = card
        yield


def submit() -> None:
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values_of(settings()), ("Card",)))])


def test_each_lamp_is_a_job_with_a_preview_and_an_export_of_its_own(out: Path) -> None:
    bpy.data.objects.remove(bpy.data.objects["Key"])
    settings().variants, settings().export_targets = "lamps", {"gltf"}
    submit()
    found = jobs.snapshot()
    assert [job.order.variant for job in found] == ["light of Fill, left", "light of world"]
    assert job_title(found[0]) == "Card, light of Fill, left"
    assert len({str(job.order.facts["spec"]) for job in found}) == 2
    with pytest.raises(InputError, match="object 'Card' is being baked there already"):
        submit()
    finish_jobs()
    assert [job.state for job in jobs.snapshot()] == [JobState.DONE] * 2, jobs.snapshot()
    for job, lights in zip(jobs.snapshot(), (("Fill, left",), ("world",)), strict=True):
        name = f"Card-{lights[0]}"
        sidecar = out / f"{name}.radiance.json"
        assert read_sidecar(sidecar).lights == lights
        assert {sidecar, out / f"{name}.preview.blend", out / f"{name}.gltf"} <= set(job.files)
        assert (out / f"{name}.gltf" / f"{name}.glb").is_file()
        assert ops.radtex.preview_toggle(object="Card", bake=str(sidecar), action="ON") == {"FINISHED"}
        shown = copy_of(bpy.data.objects["Card"])
        assert shown is not None
        assert is_on(bpy.data.objects["Card"])


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"variants": "frames", "frames": "first"}, "Frames first: give frames' numbers"),
        ({"variants": "lamps", "kind": "shadow"}, "Kind shadow cannot be baked for some lamps alone"),
    ],
)
def test_variants_that_cannot_be_are_named(choice: dict[str, Any], words: str) -> None:
    with pytest.raises(RuntimeError, match=words):
        ops.radtex.bake(**choice)


def test_frames_share_one_unwrap() -> None:
    settings().variants, settings().frames = "frames", "2,4-5"
    specs = request_of(values_of(settings()), ("Card",)).specs(context.scene)
    assert [(spec.frame, spec.unwrap_at) for spec in specs] == [(2, 2), (4, 2), (5, 2)]


def test_the_forecast_looks_at_every_variant_and_all_are_exported_together(out: Path) -> None:
    settings().variants = "lamps"
    assert panel_state.refresh(context.scene, context.view_layer).errors == ()
    assert ops.radtex.bake() == {"FINISHED"}
    found = panel_state.refresh(context.scene, context.view_layer)
    assert (found.errors, found.bakes, found.finished) == ((), 3, 3)
    assert what_is_there(found) == ["3 bakes are there: they will be replaced"]
    assert ops.radtex.export(object="Card", target="raw") == {"FINISHED"}
    for light in ("Key", "Fill, left", "world"):
        assert (out / f"Card-{light}.raw" / f"Card-{light}.export.json").is_file()
    with pytest.raises(RuntimeError, match="Several bakes do not fit in one folder"):
        ops.radtex.export(object="Card", target="raw", directory=str(out / "one"))
    for lamp in ("Key", "Fill, left"):
        bpy.data.objects.remove(bpy.data.objects[lamp])
    (error,) = panel_state.refresh(context.scene, context.view_layer).errors
    assert error.problem == "the scene renders no lamp"


def test_a_cage_takes_the_place_of_the_extrusion() -> None:
    settings().source, settings().extrusion, settings().cage = "High", 0.2, "Cage"
    spec = spec_of(values_of(settings()))
    assert (spec.source, spec.cage, spec.extrusion) == ("High", "Cage", None)
    settings().cage = ""
    spec = spec_of(values_of(settings()))
    assert spec.cage is None
    assert spec.extrusion == pytest.approx(0.2)
    settings().source, settings().cage = "", "Cage"
    assert spec_of(values_of(settings())).cage is None
