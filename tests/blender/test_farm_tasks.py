# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm whose machines have RadTex: tasks in any order make what one machine makes; faults are named."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import BakeError, FormatError, InputError, RadTexError
from radtex_addon.core.sampler import Filter
from radtex_addon.farm import claims
from radtex_addon.farm.assemble_tasks import TasksLeftError, assemble_tasks_steps
from radtex_addon.farm.claims import Claim, claimed
from radtex_addon.farm.farm_files import tasks_file
from radtex_addon.farm.prepare_tasks import prepare_tasks_steps
from radtex_addon.farm.run_task import task_steps
from radtex_addon.farm.task_graph import Subject, keyed, tasks_of
from radtex_addon.farm.tasks import Done, TaskFarm, read_tasks
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind, Layout
from tests.blender.batch_process import Batch, refusal
from tests.blender.farming import BALL, LAYERED, PLATE, build, do
from tests.blender.killed import digests
from tests.real.root import REPOSITORY

SHADOW = BakeSpec(kind=Kind.SHADOW, texels=16, bucket=4, samples=1)
BAKES = ((BALL, LAYERED), (PLATE, LAYERED), (PLATE, SHADOW))


def shuffled(farm: TaskFarm, seed: int) -> list[str]:
    """All tasks in an order in which they can be done, by chance."""
    draw, done, order = random.Random(seed), set[str](), list[str]()
    while len(order) < len(farm.tasks):
        ready = [one.name for one in farm.tasks if one.name not in done and done.issuperset(one.needs)]
        order.append(draw.choice(ready))
        done.add(order[-1])
    return order


@dataclass(frozen=True)
class Worked:
    """A farm all of whose tasks are done, and the folder of the same bakes, made by one process."""

    farm: TaskFarm
    local: Path


@pytest.fixture(scope="module")
def worked(tmp_path_factory: pytest.TempPathFactory) -> Worked:
    folder = tmp_path_factory.mktemp("tasks")
    scene = build(folder)
    for name, spec in BAKES:
        bake_object(scene, name, spec, folder / "local")
    made = finished(prepare_tasks_steps(scene, BAKES, folder / "far", preview=Filter.QUADRILINEAR))
    (folder / "picture.png").unlink()  # what machines need travels
    (folder / "things.blend").unlink()
    farm = read_tasks(made.farm.folder)
    assert farm.tasks == made.farm.tasks
    do(farm, shuffled(farm, 5))
    return Worked(farm, folder / "local")


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not there will not appear."""
    monkeypatch.setattr("radtex_addon.store.shared_pieces.PATIENCE", 0.0)
    monkeypatch.setattr("radtex_addon.store.shared_pieces._LOOK", 0.01)


@pytest.fixture
def farm(worked: Worked, tmp_path: Path) -> TaskFarm:
    """A copy to do harm to."""
    copy = shutil.copytree(worked.farm.folder, tmp_path / worked.farm.folder.name)
    return read_tasks(Path(copy))


def assemble(farm: TaskFarm, out: Path) -> Any:
    return finished(assemble_tasks_steps(farm, out))


def test_tasks_in_any_order_make_what_one_machine_makes(worked: Worked, out: Path) -> None:
    assemble(worked.farm, out)
    previews = {f"{name}.preview.blend" for name in (BALL, PLATE)}
    assert {path.name for path in out.iterdir()} == {path.name for path in worked.local.iterdir()} | previews
    for path in worked.local.iterdir():
        assert (out / path.name).read_bytes() == path.read_bytes(), path.name
    bpy.ops.wm.open_mainfile(filepath=str(out / f"{BALL}.preview.blend"))
    assert "radtex_tangent" in bpy.data.objects[BALL].data.attributes


def test_what_is_listed_travels(worked: Worked) -> None:
    told = json.loads(tasks_file(worked.farm.folder).read_text())
    assert [Path(one["path"]).name for one in told["carried"]] == ["picture.png"]
    assert {task["command"][3] for task in told["tasks"]} == {"."}
    bpy.ops.wm.open_mainfile(filepath=str(worked.farm.scene_file))
    assert bpy.utils.blend_paths(absolute=True, packed=False) == []


def test_a_task_that_is_done_is_done_once(farm: TaskFarm) -> None:
    before = {path: path.stat().st_mtime_ns for path in farm.folder.rglob("*") if path.is_file()}
    for task in farm.tasks:
        assert finished(task_steps(farm, task.name)) is False
    assert {path: path.stat().st_mtime_ns for path in before} == before


@pytest.mark.one_blender
def test_a_lost_or_damaged_piece_is_named_with_the_task_that_makes_it(farm: TaskFarm, out: Path) -> None:
    pieces = farm.pieces(BALL)
    light = next(pieces.glob("light-*.piece"))
    light.write_bytes(light.read_bytes()[:-40])
    shutil.rmtree(farm.results(BALL))
    with pytest.raises(BakeError, match=rf"{BALL} is not there|not there.*tasks are not done"):
        assemble(farm, out)
    assert not out.exists()
    with pytest.raises(BakeError) as caught:
        do(farm, [f"{BALL}.bake"])
    assert f"{light.name}, which task {BALL}.bake needs, is damaged" in str(caught.value)
    assert str(caught.value).endswith(f"do it first: {farm.command([f'{BALL}.light'])}")
    with pytest.raises(
        BakeError, match=rf"2 of \d+ tasks are not done: {BALL}.light, {BALL}.bake; do them: "
    ):
        assemble(farm, out)
    do(farm, [f"{BALL}.light", f"{BALL}.bake"])
    assemble(farm, out)


@pytest.mark.one_blender
def test_the_bakes_that_are_done_are_joined_without_the_others(
    farm: TaskFarm, out: Path, batch: Batch, caplog: pytest.LogCaptureFixture
) -> None:
    farm.set_undone(f"{BALL}.bake")
    said = refusal(batch("assemble", farm.folder, "--out", out, "--progress", "none"), code=1)
    assert said.endswith(f"{farm.command([f'{BALL}.bake'])}; or join the bakes that are done, 2: --done\n")
    assert not out.exists()
    made = finished(assemble_tasks_steps(farm, out, some=True))
    assert [(one.name, one.spec.kind) for one in made] == [(PLATE, Kind.RADIANCE), (PLATE, Kind.SHADOW)]
    assert f"1 of {len(farm.tasks)} tasks are not done: {BALL}.bake; do them: " in caplog.text
    assert not list(out.glob(f"{BALL}*"))
    before = {path: path.stat().st_mtime_ns for path in out.iterdir()}
    do(farm, [f"{BALL}.bake"])
    assemble(farm, out)  # what is there stays as it is
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert (out / f"{BALL}.radiance.json").is_file()
    for bake in farm.bakes:
        farm.set_undone(bake.last)
    with pytest.raises(TasksLeftError, match="3 of"):
        finished(assemble_tasks_steps(farm, out, some=True))


@pytest.mark.one_blender
def test_a_task_whose_turn_has_not_come_says_what_comes_first(farm: TaskFarm) -> None:
    shutil.rmtree(farm.folder / "done")
    shutil.rmtree(farm.folder / "pieces")
    with pytest.raises(InputError, match=rf"task {BALL}.light needs what is not done: {BALL}.maps; do that"):
        do(farm, [f"{BALL}.light"])
    with pytest.raises(InputError, match=r"has no task 'Ball\.lihgt'"):
        do(farm, [f"{BALL}.lihgt"])


@pytest.mark.one_blender
def test_a_machine_that_would_bake_otherwise_is_refused_by_name(
    farm: TaskFarm, monkeypatch: pytest.MonkeyPatch
) -> None:
    facts = farm.pieces(PLATE) / "facts.json"
    facts.write_text(facts.read_text().replace('"device": "CPU"', '"device": "OptiX"'))
    farm.set_undone(f"{PLATE}.own")
    with pytest.raises(
        InputError, match=r"differs from what others have begun in .* in device \(OptiX, now CPU\)"
    ):
        do(farm, [f"{PLATE}.own"])
    text = tasks_file(farm.folder).read_text()
    tasks_file(farm.folder).write_text(text.replace(bpy.app.version_string, "4.4.1"))
    with pytest.raises(InputError, match=r"was prepared in Blender 4\.4\.1, and this is "):
        do(read_tasks(farm.folder), [f"{PLATE}.own"])
    monkeypatch.setattr("radtex_addon.store.checkpoint_files.PIECE_FORMAT", 77)
    with pytest.raises(FormatError, match=r"was prepared by RadTex .*use the one that prepared it"):
        read_tasks(farm.folder)


@pytest.mark.one_blender
def test_a_farm_that_was_prepared_anew_gets_nothing_of_the_earlier_one(farm: TaskFarm) -> None:
    farm.set_undone(f"{PLATE}.bake")
    text = tasks_file(farm.folder).read_text()
    tasks_file(farm.folder).write_text(text.replace(farm.job, "0" * 32))
    with pytest.raises(InputError, match="was prepared anew meanwhile: start this again"):
        do(farm, [f"{PLATE}.bake"])
    assert not farm.is_done(f"{PLATE}.bake")
    with pytest.raises(InputError, match=r"differs from what others have begun in .* in farm"):
        do(read_tasks(farm.folder), [f"{PLATE}.bake"])


@pytest.mark.one_blender
def test_what_fails_leaves_other_bakes_alone(farm: TaskFarm, batch: Batch) -> None:
    shutil.rmtree(farm.folder / "done")
    facts = farm.pieces(BALL) / "facts.json"
    facts.write_text(facts.read_text().replace('"device": "CPU"', '"device": "OptiX"'))
    for task in [task for task in farm.tasks if task.bake != BALL and not task.is_last]:
        farm.set_done(task.name, Done((), {}, 1.0, 0, "another"))
    ended = batch("work", farm.folder, "--progress", "none")
    assert ended.code == 2
    assert "in device (OptiX, now CPU): use the same file" in ended.err
    assert [task.name for task in farm.left() if task.bake != BALL] == []
    assert not list((farm.folder / "claims").iterdir())


def test_previews_are_saved_on_a_machine_with_another_device(
    worked: Worked, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def other(_scene: bpy.types.Scene, wish: str) -> Iterator[str]:
        assert wish == "cpu"
        yield "OptiX"

    monkeypatch.setattr("radtex_addon.job.baking.use_device", other)
    assemble(worked.farm, out)
    assert (out / f"{PLATE}.preview.blend").is_file()


@pytest.mark.one_blender
def test_a_folder_that_takes_no_files_loses_nothing(farm: TaskFarm) -> None:
    shutil.rmtree(farm.folder / "done")
    (farm.folder / "done").write_text("no folder")
    with pytest.raises(BakeError, match=rf"done/{PLATE}\.maps\.json could not be written: "):
        do(farm, [f"{PLATE}.maps"])
    (farm.folder / "done").unlink()
    do(farm, [f"{PLATE}.maps"])
    assert not list(farm.folder.rglob(".radtex-*"))


@pytest.mark.one_blender
def test_two_machines_that_do_all_at_once_make_what_one_makes(worked: Worked, tmp_path: Path) -> None:
    """In processes of their own, whose pictures of the surroundings are as large as users'."""
    made = []
    for machines in (1, 2):
        far = Path(shutil.copytree(worked.farm.folder, tmp_path / f"by-{machines}.radtex-farm"))
        for name in ("done", "pieces", "baked"):
            shutil.rmtree(far / name)
        work = [sys.executable, str(REPOSITORY / "bake.py"), "work", str(far), "--progress", "none"]
        workers = [
            subprocess.Popen(work, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY) for _ in range(machines)
        ]
        said = [one.communicate(timeout=240)[0] for one in workers]
        assert [one.returncode for one in workers] == [0] * machines
        assert all(": done in" in one for one in said)  # each did a part
        assert sum(one.count(": done in") for one in said) == len(worked.farm.tasks)
        made.append({bake.key: digests(far / "baked" / bake.key) for bake in worked.farm.bakes})
    assert made[0] == made[1]


@pytest.mark.one_blender
def test_the_same_task_at_once_makes_the_same(farm: TaskFarm) -> None:
    name = f"{PLATE}.bake"
    before = digests(farm.results(PLATE))
    shutil.rmtree(farm.results(PLATE))
    farm.set_undone(name)
    work = [sys.executable, str(REPOSITORY / "bake.py"), "work", str(farm.folder), name, "--progress", "none"]
    both = [subprocess.Popen(work, cwd=REPOSITORY) for _ in range(2)]
    assert [one.wait(240) for one in both] == [0, 0]
    assert digests(farm.results(PLATE)) == before
    assert farm.result_faults(name) == ""


def test_a_claim_of_the_living_keeps_others_away_and_one_of_the_dead_does_not(
    farm: TaskFarm, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(claims, "BEAT", 0.05)
    seen: dict[str, Claim] = {}
    with claimed(farm, "x", {}) as first:
        assert first
        with claimed(farm, "x", seen) as second:
            assert not second
    with claimed(farm, "x", seen) as third:
        assert third
    left = farm.folder / "claims" / "x"
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    left.write_text(f"{claims._machine()} {gone.pid} killed")
    with claimed(farm, "x", seen) as at_once:
        assert at_once
    left.write_text("a machine that died, whose clock was an hour ahead")
    with claimed(farm, "x", seen) as early:
        assert not early
    monkeypatch.setattr(claims, "PATIENCE", 0.0)
    with claimed(farm, "x", seen) as late:
        assert late
    assert not left.exists()


def test_tasks_are_shares_of_a_minute_with_their_needs() -> None:
    large = BakeSpec(layout=Layout.LAYERED, texels=512)
    subjects = [Subject("Vase", large, True, 1000), Subject("vase", large, False, 1000)]
    bakes = keyed(subjects)
    assert [bake.key for bake in bakes] == ["Vase", "vase_2"]
    tasks = {task.name: task for task in tasks_of(bakes, subjects, 1 << 30)}
    light = [task for task in tasks.values() if task.bake == "Vase" and task.part == "light"]
    assert len(light) == 3
    assert [task.share for task in light] == [(number, len(light)) for number in range(len(light))]
    assert set(tasks["Vase.around"].needs) > {task.name for task in light}
    assert tasks["vase_2.around"].needs == ("vase_2.maps",)
    assert "vase_2.exits" not in tasks
    assert set(tasks["vase_2.bake"].needs) >= {"vase_2.misled"}
    farm = TaskFarm(Path("x"), "", "", "", "", "", None, tuple(bakes), tuple(tasks.values()))
    alone, many = farm.seconds_for(1), farm.seconds_for(1000)
    assert alone == pytest.approx(sum(task.seconds for task in tasks.values()))
    assert many == pytest.approx(max(farm.chains().values()))
    assert many < farm.seconds_for(2) < alone


@pytest.mark.one_blender
def test_what_cannot_travel_is_refused_by_name(tmp_path: Path) -> None:
    scene = build(tmp_path)
    far = tmp_path / "far"
    with pytest.raises(InputError, match="a farm bakes anew"):
        finished(prepare_tasks_steps(scene, [(BALL, BakeSpec(accumulate=True))], far))
    cloth = bpy.data.objects[PLATE].modifiers.new("soft", "CLOTH")
    with pytest.raises(InputError, match=rf"object '{PLATE}': nothing is baked of .* modifier 'soft'"):
        finished(prepare_tasks_steps(scene, [(BALL, LAYERED)], far))
    bpy.data.objects[PLATE].modifiers.remove(cloth)
    bpy.data.images["picture"].source = "MOVIE"
    with pytest.raises(RadTexError, match="is a movie"):
        finished(prepare_tasks_steps(scene, [(BALL, LAYERED)], far))
    assert not list(far.iterdir())


@pytest.mark.one_blender
def test_the_batch_prepares_works_and_assembles(tmp_path: Path, batch: Batch) -> None:
    build(tmp_path)
    far = tmp_path / "far"
    options = ("--all", "--texels", "12", "--samples", "1", "--out", far, "--progress", "json")
    done = batch("prepare", tmp_path / "things.blend", *options)
    assert done.code == 0, done.err
    event = json.loads(done.out.splitlines()[-1])
    folder = Path(event["files"][0])
    assert folder.name == "things.radtex-farm"
    assert event["seconds"]["1"] >= event["seconds"]["16"] > 0
    again = batch("prepare", tmp_path / "things.blend", *options)
    assert (again.code, "things.radtex-farm is already there" in again.err) == (2, True)
    said = refusal(batch("assemble", folder, "--progress", "none"), code=1)
    count = len(event["tasks"])
    assert f"{count} of {count} tasks are not done: " in said
    assert f"do them: python bake.py work {folder}" in said
    task = event["tasks"][0]
    one = batch("work", folder, task, "--progress", "json")
    assert json.loads(one.out.splitlines()[-1])["object"] == task
    assert batch("work", folder, task).out.startswith(f"{task}: was done already")
    assert "holds no tasks" in refusal(batch("work", tmp_path))
