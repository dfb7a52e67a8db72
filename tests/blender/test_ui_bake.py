# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The button's operator as scripts call it, and the workers behind it in a window."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.bake_history import read_history
from radtex_addon.bake.estimate import Basis
from radtex_addon.core.errors import InputError
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.textures.export_spec import Target
from radtex_addon.ui.jobs import bake_times, estimates, jobs
from radtex_addon.ui.panel import panel_state
from radtex_addon.ui.panel.jobs_panel import phrase, results
from radtex_addon.ui.panel.labels import duration, size
from radtex_addon.ui.panel.panel_state import Next
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from radtex_addon.worker.job import State
from tests.blender import stage
from tests.blender.ui_stage import context, ops, preferences, registered, settings

TINY = {"atlas_layout": "buckets", "texels": 4, "bucket": 2, "samples": 1, "preview": False}
PATIENCE = 120.0


@pytest.fixture(autouse=True)
def _registered(empty_file: None, out: Path, tmp_path: Path) -> Iterator[None]:
    with registered():
        stage.world()
        settings().directory = str(out)
        settings().atlas_layout = "buckets"
        preferences().cache_folder = str(tmp_path / "cache")
        yield


def plane(name: str = "Card", at: float = 0) -> None:
    bpy.ops.mesh.primitive_plane_add(size=2, location=(at, 0, 0))
    context.object.name = name


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def facts(path: Path) -> dict[str, object]:
    found: dict[str, object] = json.loads(path.read_text())
    return found


def test_keyword_arguments_go_before_settings_and_settings_before_defaults(out: Path) -> None:
    plane()
    settings().texels, settings().samples, settings().preview = 4, 3, False
    assert ops.radtex.bake(bucket=2, samples=1, kind="incident") == {"FINISHED"}
    sidecar = facts(out / "Card.incident.json")
    assert (sidecar["texels"], sidecar["bucket"], sidecar["samples"]) == ([4, 4], 2, 1)
    assert names(out) == ["Card.incident.exr", "Card.incident.json"]
    assert settings().samples == 3


def test_a_layout_given_to_the_operator_brings_its_cells(out: Path) -> None:
    plane()
    settings().bucket = 3
    assert ops.radtex.bake(atlas_layout="layered", texels=8, samples=1, preview=False) == {"FINISHED"}
    assert facts(out / "Card.radiance.json")["bucket"] == 14


def test_all_selected_meshes_are_baked_or_the_one_that_is_named(out: Path) -> None:
    plane("A")
    plane("B", at=5)
    bpy.ops.object.select_all(action="SELECT")
    assert ops.radtex.bake(object="A", **TINY) == {"FINISHED"}
    assert names(out) == ["A.radiance.exr", "A.radiance.json"]
    assert ops.radtex.bake(overwrite=True, **TINY) == {"FINISHED"}
    assert names(out) == ["A.radiance.exr", "A.radiance.json", "B.radiance.exr", "B.radiance.json"]


def test_nothing_is_baked_where_one_of_them_would_fail(out: Path) -> None:
    plane("A")
    context.object.data.uv_layers.new(name="Own")
    plane("B", at=5)
    settings().uv_layer = "Own"
    bpy.ops.object.select_all(action="SELECT")
    with pytest.raises(RuntimeError, match="Object 'B' has no UV layer 'Own'"):
        ops.radtex.bake(**TINY)
    assert not out.exists()


def test_an_export_follows_the_bake(out: Path) -> None:
    plane()
    assert ops.radtex.bake(**TINY | {"preview": True}, export_targets={"raw"}) == {"FINISHED"}
    assert "Card.glb" in names(out / "Card.raw")


def test_without_a_mesh_the_button_says_what_to_do() -> None:
    with pytest.raises(RuntimeError, match="Add a mesh object"):
        ops.radtex.bake()
    with pytest.raises(RuntimeError, match="Nothing is being baked"):
        ops.radtex.cancel()
    with pytest.raises(RuntimeError, match="No bake on the list has ended"):
        ops.radtex.clear_jobs()
    with pytest.raises(RuntimeError, match="bake first"):
        ops.radtex.open_folder()


def test_the_panels_page_says_how_scripts_do_it(tmp_path: Path) -> None:
    page = Path(__file__).parents[2] / "docs" / "panel.md"
    (script,) = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    plane("Suzanne")
    settings().bucket, settings().samples = 2, 1
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    exec(script, {"bpy": bpy})
    assert "Suzanne.preview.blend" in names(tmp_path / "baked")
    assert (tmp_path / "baked" / "Suzanne.godot" / "project.godot").is_file()
    assert context.scene.objects["Suzanne"].hide_render  # its preview stands there


def wait_for(state: State) -> None:
    """Pulse as the timer does, until the first job is in that state."""
    until = time.monotonic() + PATIENCE
    while jobs.snapshot()[0].state is not state:
        assert time.monotonic() < until, jobs.snapshot()
        jobs.advance()
        time.sleep(0.05)


def submit(**choice: object) -> None:
    for name, value in choice.items():
        setattr(settings(), name, value)
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values_of(settings()), ("Card",)))])


def test_a_worker_bakes_and_exports_what_the_button_asks_for(out: Path, tmp_path: Path) -> None:
    plane()
    submit(texels=8, bucket=4, samples=2, export_targets={"gltf"})
    assert bpy.app.timers.is_registered(jobs._pulse)
    assert phrase(jobs.snapshot()[0]) == "Starting"
    wait_for(State.DONE)
    (job,) = jobs.snapshot()
    assert (job.fraction, phrase(job)) == (1.0, "Done")
    assert "Card.preview.blend" in names(out)
    assert out / f"Card.{Target.GLTF}" in job.files
    assert not jobs.busy()
    assert list((tmp_path / "cache").iterdir()) == []
    (told,) = results(job, jobs.snapshot())
    files = [path for path in job.files if path.is_file()]
    assert told == f"{duration(job.took or 0)}, {size(sum(path.stat().st_size for path in files))} in 3 files"
    assert ops.radtex.clear_jobs() == {"FINISHED"}
    assert jobs.snapshot() == ()


def test_one_job_is_taken_off_the_list() -> None:
    plane()
    submit(texels=4, bucket=2, samples=1, preview=False)
    wait_for(State.DONE)
    submit(kind="shadow")
    while jobs.advance():
        time.sleep(0.05)
    first, second = jobs.snapshot()
    assert ops.radtex.clear_jobs(number=first.number) == {"FINISHED"}
    assert jobs.snapshot() == (second,)


def test_a_bake_can_be_cancelled_and_another_comes_after_it(out: Path) -> None:
    plane()
    submit(texels=256, bucket=8, samples=64, preview=False)
    wait_for(State.RUNNING)
    submit(texels=4, bucket=2, samples=1, kind="incident")
    number = jobs.snapshot()[0].number
    assert ops.radtex.cancel(number=number) == {"FINISHED"}
    assert phrase(jobs.snapshot()[0]) == "Stopping"
    wait_for(State.CANCELLED)
    assert phrase(jobs.snapshot()[0]) == "Cancelled"
    jobs.forget_ended()
    wait_for(State.DONE)
    assert (out / "Card.incident.exr").exists()


def test_what_is_being_baked_is_not_baked_twice_at_once(out: Path) -> None:
    plane()
    submit(texels=256, bucket=8, samples=64, preview=False)
    wait_for(State.RUNNING)
    with pytest.raises(
        InputError, match="object 'Card' is being baked there already: wait for it, or cancel"
    ):
        submit(texels=8, overwrite=True)
    submit(texels=4, bucket=2, samples=1, kind="shadow")
    assert [job.order.about for job in jobs.snapshot()] == ["", "shadow"]
    jobs.cancel()
    wait_for(State.CANCELLED)


def test_a_cancelled_bake_can_be_gone_on_with(out: Path) -> None:
    plane()
    submit(texels=64, bucket=8, samples=16, preview=False)
    until = time.monotonic() + PATIENCE
    while not list(out.glob("*.radtex-unfinished")) or jobs.snapshot()[0].fraction < 0.3:
        assert time.monotonic() < until
        jobs.advance()
        time.sleep(0.02)
    jobs.cancel()
    wait_for(State.CANCELLED)
    found = panel_state.refresh(context.scene, context.view_layer)
    assert (found.next, found.errors, found.unfinished) == (Next.RESUME, (), 1)
    jobs.forget_ended()
    submit(resume=True)
    wait_for(State.DONE)
    assert names(out) == ["Card.radiance.exr", "Card.radiance.json"]


def finish_estimate() -> None:
    until = time.monotonic() + PATIENCE
    while estimates.advance():
        assert time.monotonic() < until
        time.sleep(0.05)


def test_a_worker_measures_all_objects_and_can_be_cancelled() -> None:
    plane()
    plane("Other", at=5)
    settings().texels, settings().bucket, settings().samples = 64, 4, 2
    bakes = [(name, spec_of(values_of(settings()))) for name in ("Card", "Other")]
    estimates.ask(context.scene, bakes)
    assert estimates.asking()
    assert estimates.progress() == (1, 2)
    assert not ops.radtex.estimate.poll()
    assert ops.radtex.cancel_estimate() == {"FINISHED"}
    finish_estimate()
    assert (estimates.message(), estimates.took()) == (None, None)
    known = estimates.seconds_known(context.scene, bakes)
    assert known is not None
    assert known.basis == Basis.NOTHING
    assert not ops.radtex.cancel_estimate.poll()
    estimates.ask(context.scene, bakes)
    finish_estimate()
    assert estimates.message() is None
    assert estimates.took() is not None
    known = estimates.seconds_known(context.scene, bakes)
    assert known is not None
    assert known.basis == Basis.MEASURED
    assert list(Path(preferences().cache_folder).iterdir()) == []


def test_what_cannot_be_measured_is_told() -> None:
    plane()
    spec = spec_of(values_of(settings()))
    context.object.hide_render = True
    estimates.ask(context.scene, [("Card", spec)])
    finish_estimate()
    assert "Card" in str(estimates.message())
    assert estimates.took() is None


def test_a_finished_bakes_time_is_remembered_and_expected_again() -> None:
    bake_times.history_file().unlink(missing_ok=True)
    plane()
    submit(texels=16, bucket=4, samples=2, preview=True)
    begun = time.monotonic()
    wait_for(State.DONE)
    took = time.monotonic() - begun
    (made,) = read_history(bake_times.history_file())
    facts = jobs.snapshot()[0].facts
    assert made.name == "Card"
    assert (made.work.texels, made.work.triangles, made.work.covered) == (16, 2, facts["covered_texels"])
    assert (made.work.preview, made.work.device) == (True, "cpu")
    assert {stage: made.seconds[stage] for stage in facts["seconds"]} == facts["seconds"]
    assert sum(made.seconds.values()) == pytest.approx(took, abs=1.0)
    known = estimates.seconds_known(context.scene, [("Card", spec_of(values_of(settings())))])
    assert known is not None
    assert known.basis == Basis.BAKED
    assert known.seconds == pytest.approx(sum(made.seconds.values()), rel=0.1)

    finer: Any = bpy.data.objects["Card"].modifiers.new("finer", "SUBSURF")
    finer.levels = 6  # 4096 quads, of one
    spec = spec_of(values_of(settings()))
    assert estimates._work_of(context.scene, "Card", spec).triangles == 8192
    bake_times.history_file().unlink()
