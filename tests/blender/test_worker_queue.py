# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Real workers, one after another: what they bake, and how they end."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.preview.swap import switch_on
from radtex_addon.report.side_by_side import ComparisonSpec, read_picture
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec, Kind, Unwrap
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui.jobs.bug_report import report_of
from radtex_addon.version import VERSION
from radtex_addon.worker.handover import hand_over, this_program, work_folder
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.order import Handover, Program
from radtex_addon.worker.orders import order_bake, order_comparison, order_export
from radtex_addon.worker.queue import Queue
from tests.blender import stage, worker_parent
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene
from tests.blender.test_swap import GLOW, NAME, PLAIN, bake_of, ball

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None
blocks: Any = bpy.data

TINY = BakeSpec(texels=8, bucket=2, samples=1, uv_layer="UVMap")
ENDLESS = BakeSpec(texels=64, bucket=8, samples=1_000_000, uv_layer="UVMap")
LONG = 100.0  # seconds that a test waits on a machine that has much else to do


@pytest.fixture
def jobs(tmp_path: Path) -> Path:
    return tmp_path / "Aufträge für später"


@pytest.fixture
def queue() -> Iterator[Queue]:
    made = Queue(this_program())
    yield made
    made.close()


def card(name: str = "Card", image: Any = None) -> Any:
    """A plane that glows: white, or by an image."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = name
    glow: Any = stage.material(f"glow of {name}", "ShaderNodeEmission", Color=(1, 1, 1, 1))
    if image is not None:
        texture = glow.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image, texture.interpolation = image, "Closest"
        glow.node_tree.links.new(texture.outputs[0], glow.node_tree.nodes["Emission"].inputs[0])
    context.object.data.materials.append(glow)
    return context.object


def until(queue: Queue, reached: Callable[[Job], bool], number: int = 1) -> Job:
    """Advance the queue as a timer does, until a job has come that far."""
    give_up = time.monotonic() + LONG
    while True:
        queue.advance()
        job = queue.snapshot()[number - 1]
        if reached(job):
            return job
        assert not job.ended, job
        assert time.monotonic() < give_up, job
        time.sleep(0.02)


def finish(queue: Queue) -> tuple[Job, ...]:
    give_up = time.monotonic() + LONG
    while queue.advance():
        assert time.monotonic() < give_up
        time.sleep(0.02)
    return queue.snapshot()


def mean_light(path: Path) -> Any:
    """The light that a flat atlas shows, by row and column of texels."""
    pixels, header = read_atlas(path)
    shape = (header.height, header.bucket, header.width, header.bucket, -1)
    return pixels[..., :3].astype(float).reshape(shape).mean(axis=(1, 3))


def finished(folder: Path) -> list[str]:
    """What is in a folder but for what a bake keeps to go on with."""
    return [path.name for path in folder.glob("*") if path.suffix != ".radtex-unfinished"]


# what is baked


def test_painted_images_linked_data_and_unsaved_changes_are_in_the_bake(
    queue: Queue, jobs: Path, tmp_path: Path
) -> None:
    card("Linked").location.z = 9
    library = tmp_path / "Bücher" / "linked things.blend"
    library.parent.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(library))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "empty room.blend"))
    with blocks.libraries.load(str(library), link=True, relative=True) as (_, wanted):
        wanted.objects = ["Linked"]
    painted: Any = blocks.images.new("painted", 2, 2, float_buffer=True)
    painted.colorspace_settings.name = "Non-Color"
    card("Größe 2 – neu", painted)
    context.scene.collection.objects.link(blocks.objects["Linked"])
    painted.pixels.foreach_set(np.array([4, 0, 0, 1, 0, 2, 0, 1, 0, 0, 8, 1, 1, 1, 1, 1], dtype=np.float32))
    assert painted.is_dirty
    handover = hand_over(context.scene, jobs)
    out = tmp_path / "out put" / "größer"
    for name in ("Größe 2 – neu", "Linked"):
        queue.add(order_bake(handover, name, TINY, out, Filter.NEAREST))
    done = finish(queue)
    assert [job.state for job in done] == [JobState.DONE, JobState.DONE], done
    assert [job.fraction for job in done] == [1, 1]
    assert all("8 x 8 texels" in str(job.message) for job in done)
    assert {path for job in done for path in job.files} == set(out.iterdir())
    light = mean_light(next(path for path in done[0].files if path.suffix == ".exr"))
    quarters = light[[1, 1, 6, 6], [1, 6, 1, 6]]
    np.testing.assert_allclose(quarters, [[4, 0, 0], [0, 2, 0], [0, 0, 8], [1, 1, 1]], atol=1e-2)
    np.testing.assert_allclose(mean_light(done[1].files[0]), 1, atol=1e-3)
    assert not handover.folder.exists()
    bpy.ops.wm.open_mainfile(filepath=str(next(path for path in done[1].files if path.suffix == ".blend")))
    assert blocks.images["painted"].packed_file, "the painted card stands beside the linked one"


def test_the_scene_on_the_screen_is_baked_and_stays_what_it_was(queue: Queue, jobs: Path, out: Path) -> None:
    lived_in_scene()
    other = blocks.scenes["elsewhere"]
    context.window.scene = other
    name = card("Only here").name
    context.window.scene = blocks.scenes["Scene"]
    before = fingerprint()
    queue.add(order_bake(hand_over(other, jobs), name, TINY, out))
    (done,) = finish(queue)
    assert done.state is JobState.DONE, done.message
    assert differences(before, fingerprint()) == {}
    assert list(jobs.iterdir()) == []


def test_jobs_wait_for_one_another_and_one_that_fails_or_is_cancelled_holds_up_none(
    queue: Queue, jobs: Path, out: Path
) -> None:
    card()
    handover = hand_over(context.scene, jobs)
    other = replace(TINY, kind=Kind.INCIDENT)
    for name, spec, folder in (
        ("Card", TINY, "one"),
        ("Crad", TINY, "two"),
        ("Card", TINY, "never"),
        ("Card", other, "three"),
    ):
        queue.add(order_bake(handover, name, spec, out / folder))
    assert [job.state for job in queue.snapshot()] == [JobState.WAITING] * 4
    until(queue, lambda job: job.stage is not None)
    queue.cancel(3)  # at once, as it only waits
    assert [job.state for job in queue.snapshot()] == [
        JobState.RUNNING,
        JobState.WAITING,
        JobState.CANCELLED,
        JobState.WAITING,
    ]
    first, second, _, third = finish(queue)
    states = [job.state for job in (first, second, third)]
    assert states == [JobState.DONE, JobState.FAILED, JobState.DONE], (first.message, third.message)
    assert not (out / "never").exists()
    assert "'Crad'" in str(second.message)
    assert "did you mean 'Card'?" in str(second.message)
    assert "\n" not in str(second.message)
    assert second.files == ()
    report = report_of(second).splitlines()
    assert report[0].startswith(f"RadTex {VERSION}, Blender {bpy.app.version_string}")
    assert "bake of Crad: failed, at 0% (None)" in report
    assert str(second.message) in report
    assert second.log.strip().splitlines()[-1] in report[-1]
    assert {path.parent.name for path in third.files} == {"three"}
    assert not handover.folder.exists()
    queue.forget_ended()
    assert queue.snapshot() == ()


def test_a_comparison_sees_the_previews_that_the_session_shows(queue: Queue, jobs: Path, out: Path) -> None:
    sidecar = bake_of(PLAIN, out / "baked")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    item = ball(NAME)
    switch_on(item, sidecar)
    eye = Viewpoint.of_view(np.array(Matrix.Translation((0, 0, -5))), np.diag([0.5, 1.0, -0.002, 1.0]))
    handover, spec = hand_over(context.scene, jobs), ComparisonSpec(32, 1)
    queue.add(order_comparison(handover, [NAME], None, eye, spec, out / "pictures"))
    (compared,) = finish(queue)
    assert compared.state is JobState.DONE, compared.message
    assert compared.facts["psnr"] > 30
    np.testing.assert_allclose(read_picture(Path(compared.facts["traced"]))[8, 16], GLOW, rtol=0.02)
    assert compared.object == NAME
    assert list(jobs.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
def test_an_export_that_is_killed_is_one_line_and_leaves_nothing(queue: Queue, jobs: Path, out: Path) -> None:
    sidecar = bake_of(PLAIN, out)
    before = set(out.iterdir())
    folder = work_folder(jobs)
    queue.add(order_export(folder, [(NAME, sidecar, out / "made")], ExportSpec(Target.RAW)))
    until(queue, lambda job: job.stage is not None)
    assert set(out.iterdir()) > before, "it is written beside its place"
    os.kill(running_pid(queue), signal.SIGKILL)
    failed = until(queue, lambda job: job.state is JobState.FAILED)
    assert str(failed.message) == "the export ended early (killed by signal 9): export again"
    assert set(out.iterdir()) == before
    assert list(jobs.iterdir()) == []


# cancelling


def rendering(job: Job) -> bool:
    return job.stage == "capture"


def test_cancelling_amid_an_unwrap_takes_two_seconds_at_most_and_leaves_nothing(
    queue: Queue, jobs: Path, out: Path
) -> None:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=7)
    spec = replace(ENDLESS, uv_layer=None, unwrap=Unwrap.XATLAS)
    queue.add(order_bake(hand_over(context.scene, jobs), context.object.name, spec, out))
    until(queue, lambda job: job.stage == "unwrap")
    pid = running_pid(queue)
    if sys.platform == "linux":
        give_up = time.monotonic() + LONG
        while len(alive_in_group(pid)) < 2:  # xatlas is a process of the worker's own
            assert time.monotonic() < give_up
            queue.advance()
            time.sleep(0.02)
    since = time.monotonic()
    queue.cancel(1)
    assert queue.snapshot()[0].cancelling
    ended = until(queue, lambda job: job.ended)
    assert time.monotonic() - since < 2
    assert (ended.state, str(ended.message)) == (JobState.CANCELLED, "cancelled")
    assert is_gone(pid)
    assert not alive_in_group(pid)
    assert not finished(out)
    assert list(jobs.iterdir()) == []


def test_closing_the_queue_ends_all_and_leaves_nothing(queue: Queue, jobs: Path, out: Path) -> None:
    card()
    handover = hand_over(context.scene, jobs)
    for _ in range(2):
        queue.add(order_bake(handover, "Card", ENDLESS, out))
    until(queue, rendering)
    pid = running_pid(queue)
    since = time.monotonic()
    queue.close()
    assert time.monotonic() - since < 2
    assert is_gone(pid)
    assert {job.state for job in queue.snapshot()} == {JobState.CANCELLED}
    assert not finished(out)
    assert list(jobs.iterdir()) == []


# dying


def running_pid(queue: Queue) -> int:
    assert queue._running is not None
    return queue._running[1].pid


def is_gone(pid: int) -> bool:
    """Whether a process has ended; a zombie has, which waits for somebody to ask how."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (ProcessLookupError, FileNotFoundError):
        return True


def alive_in_group(leader: int) -> list[str]:
    """What runs of the processes that a worker has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, group = stat.read_text().rpartition(")")[2].split()[:3]
            if int(group) == leader and state != "Z":
                found.append(stat.parent.name)
    return found


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
def test_a_worker_that_is_killed_is_one_line_and_the_next_job_goes_on(
    queue: Queue, jobs: Path, out: Path
) -> None:
    card()
    handover = hand_over(context.scene, jobs)
    queue.add(order_bake(handover, "Card", ENDLESS, out))
    queue.add(order_bake(handover, "Card", TINY, out / "next"))
    until(queue, rendering)
    out.mkdir(exist_ok=True)
    litter = out / f".radtex-{running_pid(queue)}-0123.exr"  # as if it had been writing
    litter.write_text("half")
    os.kill(running_pid(queue), signal.SIGKILL)
    failed = until(queue, lambda job: job.state is JobState.FAILED)
    assert str(failed.message) == (
        "the bake ended early (killed by signal 9): bake again, if memory ran out with fewer texels, "
        "cells or samples"
    )
    assert finish(queue)[1].state is JobState.DONE
    assert not litter.exists()
    assert list(jobs.iterdir()) == []


def test_a_program_that_is_no_blender_is_one_line(jobs: Path, out: Path, tmp_path: Path) -> None:
    card()
    queue = Queue(Program(str(tmp_path / "blender"), is_blender=True))
    queue.add(order_bake(hand_over(context.scene, jobs), "Card", TINY, out))
    (failed,) = finish(queue)
    assert failed.state is JobState.FAILED
    assert re.fullmatch(r".*/blender does not start \(No such file or directory\): .*", str(failed.message))
    queue.close()


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such program")
def test_a_program_that_ends_well_and_bakes_nothing_has_failed(jobs: Path, out: Path) -> None:
    card()
    queue = Queue(Program("/bin/true", is_blender=True))
    queue.add(order_bake(hand_over(context.scene, jobs), "Card", TINY, out))
    (failed,) = finish(queue)
    assert failed.state is JobState.FAILED
    assert str(failed.message).startswith("the bake ended early (exit code 0): ")
    queue.close()


def test_a_file_that_is_gone_is_one_line(queue: Queue, jobs: Path, out: Path) -> None:
    folder = jobs / "gone"
    gone = Handover(folder, folder / "room.blend", "Scene", None, "cpu", 0.0)
    queue.add(order_bake(gone, "Card", TINY, out))
    (failed,) = finish(queue)
    assert failed.state is JobState.FAILED
    assert str(folder) in str(failed.message)


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A card in a file."""
    card()
    path = tmp_path / "ein Raum.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def session(room: Path, jobs: Path, out: Path, manner: str) -> subprocess.Popen[str]:
    command = [sys.executable, str(worker_parent.__file__), str(room), str(jobs), str(out), manner]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, encoding="utf-8")


def worker_of(parent: subprocess.Popen[str]) -> int:
    assert parent.stdout is not None
    found = next(found for line in parent.stdout if (found := re.match(r"worker (\d+)", line)))
    return int(found[1])


@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc")
def test_a_worker_ends_with_a_parent_that_is_killed(room: Path, jobs: Path, out: Path) -> None:
    with session(room, jobs, out, "stay") as parent:
        pid = worker_of(parent)
        assert parent.stdout is not None
        assert next(parent.stdout) == "capture\n"
        assert not is_gone(pid)
        parent.kill()
    give_up = time.monotonic() + 20
    while not is_gone(pid):
        assert time.monotonic() < give_up
        time.sleep(0.05)
    assert not finished(out)


@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc")
def test_a_session_that_ends_leaves_no_worker_and_no_folder(room: Path, jobs: Path, out: Path) -> None:
    with session(room, jobs, out, "leave") as parent:
        pid = worker_of(parent)
        parent.communicate(timeout=LONG)
        assert is_gone(pid)
    assert parent.returncode == 0
    assert list(jobs.iterdir()) == []
