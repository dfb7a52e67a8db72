# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fifteen bakes wait, three fail, one is cancelled, and Blender ends: what the next one shows and does."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.panel.jobs_panel import RADTEX_PT_jobs, _draw_all, in_order
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.kept_jobs import KeptJobs, kept_folders, left_lists
from radtex_addon.worker.order import Order, Work
from tests.blender import left_session
from tests.blender.left_session import CANCELLED, DONE, FAILING, RUNNING
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_worker_queue import is_gone
from tests.blender.ui_stage import finish_jobs, ops, registered

pytestmark = pytest.mark.one_blender


@pytest.fixture(autouse=True)
def _registered(empty_file: None) -> Iterator[None]:
    with registered():
        yield


def ended_session(folder: Path, manner: str) -> int:
    """Run a session to its end; the number of the worker that it had."""
    script = str(Path(left_session.__file__))
    with subprocess.Popen(
        [sys.executable, script, str(folder), manner], stdout=subprocess.PIPE, text=True
    ) as session:
        assert session.stdout is not None
        words = next(line.split() for line in session.stdout if line.startswith("ready"))
        if manner == "killed":
            session.kill()
    return int(words[2])


@pytest.mark.parametrize("manner", ["quit", "killed"])
def test_nothing_of_fifteen_bakes_is_lost_when_blender_ends(tmp_path: Path, manner: str) -> None:
    worker = ended_session(tmp_path, manner)
    until = time.monotonic() + 10
    while not is_gone(worker):
        assert time.monotonic() < until, "the worker goes on unseen"
        time.sleep(0.05)
    jobs.take_over(tmp_path / "lists")
    found = {job.object: job for job in jobs.snapshot()}
    assert len(found) == 15
    assert {name for name, job in found.items() if job.state == "failed"} == set(FAILING)
    assert all(str(tmp_path / "file") in str(found[name].message) for name in FAILING)
    assert found[CANCELLED].state == "cancelled"
    assert {name for name, job in found.items() if job.state == "done"} == set(DONE)
    left = [job.object for job in jobs.left()]
    assert left == [RUNNING, *(f"Card {number:02}" for number in range(7, 15))]
    assert [job.begun for job in jobs.left()] == [True, *[False] * 8]
    assert not jobs.busy()
    layout = RecordedLayout()
    _draw_all(layout, jobs.snapshot())
    assert "Blender ended before 9 of these were done" in " ".join(layout.texts)
    assert "Go On with 9" in layout.texts
    assert in_order(jobs.snapshot())[0].object == RUNNING
    assert RADTEX_PT_jobs.poll(None)

    assert ops.radtex.clear_jobs() == {"FINISHED"}
    assert [job.object for job in jobs.snapshot()] == left, "what is left is not cleared with the rest"
    before = sum(1 for _ in (tmp_path / "out").glob("*.radtex-unfinished"))
    assert before == 1
    if manner == "quit":  # the rest is the same
        return
    assert ops.radtex.go_on() == {"FINISHED"}
    assert not jobs.left()
    assert {job.state for job in jobs.snapshot()} == {"running", "waiting"}
    assert len(jobs.snapshot()) == 9
    for job in jobs.snapshot()[2:]:  # the others are the same
        jobs.cancel(job.number)
    assert [job.state for job in finish_jobs()] == ["done"] * 2 + ["cancelled"] * 7, jobs.snapshot()
    assert {path.name.partition(".")[0] for path in (tmp_path / "out").glob("*.json")} == {*left[:2], *DONE}
    assert not list((tmp_path / "out").glob("*.radtex-unfinished"))
    assert not list((tmp_path / "cache").iterdir())
    assert not list((tmp_path / "lists").glob("*.json")), "nothing is left to be told"


def bake(folder: Path, state: JobState = JobState.WAITING) -> Job:
    (folder / "work").mkdir(parents=True, exist_ok=True)
    order = Order(Work.BAKE, "Card", folder / "work", folder / "out", {}, {"capture": 1.0}, "bake again")
    return Job(1, order, state=state)


def test_a_list_is_its_sessions_alone_while_that_lives(tmp_path: Path) -> None:
    kept = KeptJobs(tmp_path, "RadTex 1")
    kept.write([bake(tmp_path)])
    script = (
        "import sys; from pathlib import Path; from radtex_addon.worker.kept_jobs import left_lists;"
        f"print(len(list(left_lists(Path({str(tmp_path)!r}), 'RadTex 1'))))"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert said.stdout.split() == ["0"], said
    assert kept_folders(tmp_path) == {tmp_path / "work"}
    kept.close()
    (found,) = left_lists(tmp_path, "RadTex 1")
    assert [job.state for job in found.jobs] == ["left"]
    found.remove()
    assert list(tmp_path.glob("radtex-list-*")) == []


def test_a_list_of_another_version_and_a_copy_that_is_gone_say_what_to_do(tmp_path: Path) -> None:
    kept = KeptJobs(tmp_path, "RadTex 1")
    kept.write([bake(tmp_path)])
    kept.close()
    (found,) = left_lists(tmp_path, "RadTex 2")
    assert "another version of Blender or RadTex is open now: open its .blend" in str(found.jobs[0].message)
    found.lock.release()
    (tmp_path / "work").rmdir()
    (found,) = left_lists(tmp_path, "RadTex 1")
    assert found.jobs[0].state == "failed"
    assert "the copy of its scene is gone" in str(found.jobs[0].message)
    found.remove()


@pytest.mark.parametrize(
    "text", ["", "[]", '{"made_by": "RadTex 1"}', '{"made_by": "RadTex 1", "jobs": [1]}']
)
def test_a_damaged_list_is_deleted(tmp_path: Path, text: str) -> None:
    (tmp_path / "radtex-list-1.json").write_text(text)
    assert list(left_lists(tmp_path, "RadTex 1")) == []
    assert list(tmp_path.iterdir()) == []


def test_what_is_done_or_cancelled_alone_is_not_kept(tmp_path: Path) -> None:
    kept = KeptJobs(tmp_path, "RadTex 1")
    kept.write([bake(tmp_path)])
    kept.write([replace(bake(tmp_path), state=JobState.DONE)])
    kept.close()
    assert not list(tmp_path.glob("radtex-list-*"))
