# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The button's operator as scripts call it, and the workers behind it in a window."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.core.messages import Message
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.settings.bake_history import read_history
from radtex_addon.settings.estimate import Basis
from radtex_addon.textures.export_spec import Target
from radtex_addon.ui.jobs import bake_times, estimates, jobs
from radtex_addon.ui.panel.jobs_panel import _draw_job, in_order, job_title, phrase, results
from radtex_addon.ui.panel.labels import duration, size
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from radtex_addon.worker.job import JobState
from tests.blender import stage
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import PATIENCE, context, finish_jobs, ops, preferences, registered, settings


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


def test_buttons_that_have_nothing_to_do_say_so() -> None:
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


def wait_for(state: JobState) -> None:
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
    assert phrase(jobs.snapshot()[0]) == "Starting, time left: not known yet"
    wait_for(JobState.DONE)
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


@pytest.mark.one_blender
def test_what_is_being_baked_is_not_baked_twice_and_can_be_cancelled_and_another_comes_after_it(
    out: Path,
) -> None:
    plane()
    submit(texels=256, bucket=8, samples=64, preview=False)
    wait_for(JobState.RUNNING)
    with pytest.raises(
        InputError, match="object 'Card' is being baked there already: wait for it, or cancel"
    ):
        submit(texels=8, overwrite=True)
    submit(texels=4, bucket=2, samples=1, kind="incident")
    assert [job.order.about for job in jobs.snapshot()] == ["", "incident"]
    number = jobs.snapshot()[0].number
    assert ops.radtex.cancel(number=number) == {"FINISHED"}
    assert phrase(jobs.snapshot()[0]) == "Stopping"
    wait_for(JobState.CANCELLED)
    assert phrase(jobs.snapshot()[0]) == "Cancelled"
    assert ops.radtex.clear_jobs(number=number) == {"FINISHED"}
    assert [job.order.about for job in jobs.snapshot()] == ["incident"]
    wait_for(JobState.DONE)
    assert (out / "Card.incident.exr").exists()


def finish_estimate() -> None:
    until = time.monotonic() + PATIENCE
    while estimates.advance():
        assert time.monotonic() < until
        time.sleep(0.05)


@pytest.mark.one_blender
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


@pytest.mark.one_blender
def test_what_cannot_be_measured_is_told() -> None:
    plane()
    spec = spec_of(values_of(settings()))
    context.object.hide_render = True
    estimates.ask(context.scene, [("Card", spec)])
    finish_estimate()
    assert "Card" in str(estimates.message())
    assert estimates.took() is None


@pytest.mark.one_blender
def test_a_finished_bakes_time_is_remembered_and_expected_again() -> None:
    bake_times.history_file().unlink(missing_ok=True)
    plane()
    submit(texels=16, bucket=4, samples=2, preview=True)
    begun = time.monotonic()
    wait_for(JobState.DONE)
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


def test_the_list_has_what_runs_first_and_one_line_for_all_but_the_latest() -> None:
    for number, name in enumerate(("Card", "Post", "Vase")):
        plane(name, at=3 * number)
    for name in ("Card", "Post", "Vase"):
        values = values_of(settings()) | {"texels": 4, "bucket": 2, "samples": 1, "preview": False}
        jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values, (name,)))])
    assert drawn() == [("Card", True), ("Post", False), ("Vase", False)]
    finish_jobs()
    assert drawn() == [("Vase", True), ("Post", False), ("Card", False)]
    first = jobs.snapshot()[0].number
    for unfolded in (True, False):
        assert ops.radtex.fold_job(number=first) == {"FINISHED"}
        assert drawn()[-1] == ("Card", unfolded)
    ops.radtex.clear_jobs()


def test_several_warnings_of_a_finished_job_are_one_line_until_it_is_clicked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plane()
    values = values_of(settings()) | {"texels": 4, "bucket": 2, "samples": 1, "preview": False}
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values, ("Card",)))])
    finish_jobs()
    (job,) = jobs.snapshot()
    two = Message("this is noisy"), Message("that is empty")

    def told(state: JobState, *warnings: Message) -> list[str]:
        shown = replace(job, state=state, warnings=warnings)
        monkeypatch.setattr(jobs._session, "shown", (shown,))
        layout = RecordedLayout()
        _draw_job(layout, shown)
        return [text for text in layout.texts if "warnings" in text or "noisy" in text or "empty" in text]

    assert told(JobState.DONE, *two) == ["2 warnings"]
    assert told(JobState.DONE, two[0]) == ["This is noisy"]
    assert told(JobState.RUNNING, *two) == ["This is noisy", "That is empty"]  # while it can be cancelled
    assert ops.radtex.fold_warnings(number=job.number) == {"FINISHED"}
    assert told(JobState.DONE, *two) == ["2 warnings", "This is noisy", "That is empty"]
    assert ops.radtex.fold_warnings(number=job.number) == {"FINISHED"}
    assert told(JobState.FAILED, *two) == ["2 warnings"]
    monkeypatch.undo()
    ops.radtex.clear_jobs()


def drawn() -> list[tuple[str, bool]]:
    """The titles of the jobs as the panel draws them, and whether more of it is drawn."""
    found = []
    for job in in_order(jobs.snapshot()):
        layout = RecordedLayout()
        _draw_job(layout, job)
        assert job_title(job) in layout.texts
        found.append((job_title(job), not jobs.is_folded(job)))
        if job.ended:
            assert ("radtex.open_folder" in dict(layout.buttons)) is not jobs.is_folded(job)
    return found
