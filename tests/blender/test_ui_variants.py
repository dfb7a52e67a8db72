# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants in the panel: frames and lamps, each a job with its own row, preview and export; and a cage."""

from __future__ import annotations

import time
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
from radtex_addon.worker.job import State
from tests.blender import stage
from tests.blender.ui_stage import ops, preferences, registered, settings

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None
PATIENCE = 120.0  # seconds for a worker
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


def finish() -> None:
    """Pulse as the timer does, until every job has ended."""
    until = time.monotonic() + PATIENCE
    while jobs.busy():
        assert time.monotonic() < until, jobs.snapshot()
        jobs.advance()
        time.sleep(0.05)


def submit() -> None:
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values_of(settings()), ("Card",)))])


def test_each_lamp_is_a_job_with_a_preview_and_an_export_of_its_own(out: Path) -> None:
    settings().variants, settings().export_targets = "lamps", {"gltf"}
    submit()
    found = jobs.snapshot()
    assert [job.order.variant for job in found] == ["light of Fill, left", "light of Key", "light of world"]
    assert job_title(found[1]) == "Card, light of Key"
    assert len({str(job.order.facts["spec"]) for job in found}) == 3
    with pytest.raises(InputError, match="object 'Card' is being baked there already"):
        submit()
    finish()
    assert [job.state for job in jobs.snapshot()] == [State.DONE] * 3, jobs.snapshot()
    for job, lights in zip(jobs.snapshot(), (("Fill, left",), ("Key",), ("world",)), strict=True):
        name = f"Card-{lights[0]}"
        sidecar = out / f"{name}.radiance.json"
        assert read_sidecar(sidecar).lights == lights
        assert {sidecar, out / f"{name}.preview.blend", out / f"{name}.gltf"} <= set(job.files)
        assert (out / f"{name}.gltf" / f"{name}.glb").is_file()
        assert ops.radtex.preview_toggle(object="Card", bake=str(sidecar), action="ON") == {"FINISHED"}
        shown = copy_of(bpy.data.objects["Card"])
        assert shown is not None
        assert is_on(bpy.data.objects["Card"])


def test_finished_bakes_of_all_lamps_are_exported_together(out: Path) -> None:
    settings().variants = "lamps"
    assert ops.radtex.bake() == {"FINISHED"}
    assert ops.radtex.export(object="Card", target="raw") == {"FINISHED"}
    for light in ("Key", "Fill, left", "world"):
        assert (out / f"Card-{light}.raw" / f"Card-{light}.export.json").is_file()
    with pytest.raises(RuntimeError, match="Several bakes do not fit in one folder"):
        ops.radtex.export(object="Card", target="raw", directory=str(out / "one"))


def test_frames_are_baked_on_one_unwrap_and_gone_on_with(out: Path) -> None:
    settings().variants, settings().frames = "frames", "2,4-5"
    request = request_of(values_of(settings()), ("Card",))
    specs = request.specs(context.scene)
    assert [(spec.frame, spec.unwrap_at) for spec in specs] == [(2, 2), (4, 2), (5, 2)]
    assert ops.radtex.bake() == {"FINISHED"}
    files = [out / f"Card-000{frame}.radiance.json" for frame in (2, 4, 5)]
    assert [read_sidecar(file).frame for file in files] == [2, 4, 5]
    with pytest.raises(RuntimeError, match=r"Card-0002\.radiance"):
        ops.radtex.bake()
    before = files[0].stat().st_mtime_ns
    files[1].unlink()
    files[1].with_suffix(".exr").unlink()
    files[1].with_name("Card-0004.preview.blend").unlink()
    assert ops.radtex.bake(resume=True) == {"FINISHED"}
    assert files[1].is_file()
    assert files[0].stat().st_mtime_ns == before, "a finished frame is baked again"
    with pytest.raises(RuntimeError, match="All variants are finished"):
        ops.radtex.bake(resume=True)


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


def test_the_forecast_looks_at_every_variant(out: Path) -> None:
    settings().variants = "lamps"
    assert panel_state.refresh(context.scene, context.view_layer).errors == ()
    assert ops.radtex.bake() == {"FINISHED"}
    found = panel_state.refresh(context.scene, context.view_layer)
    assert (found.errors, found.bakes, found.finished) == ((), 3, 3)
    assert what_is_there(found) == ["3 bakes are there: they will be replaced"]
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
