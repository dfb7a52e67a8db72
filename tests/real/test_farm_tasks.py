# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is written beside a farm's tasks, run for real: OpenJD, Flamenco, Slurm and make."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.farm.steps import STEPS
from radtex_addon.farm.tasks import read_tasks
from radtex_addon.farm.templates import write_task_templates
from tests.blender.killed import digests
from tests.blender.test_farm_templates import farm_of
from tests.real.nodes import OPENJD, NodeUnavailableError, ready_python
from tests.real.root import REPOSITORY
from tests.real.slurm import Cluster, SlurmUnavailableError, slurm_cluster
from tests.real.task_farm import BOX, PreparedFarm, Worker, bake_command, done_in_steps
from tests.real.web import compiled_flamenco_job

pytestmark = [
    pytest.mark.one_blender,
    pytest.mark.skipif(sys.platform != "linux", reason="farms run on Linux alone"),
]
FLAKY, BEHIND = f"{BOX}.own", [f"{BOX}.misled", f"{BOX}.bake"]  # what fails once, and what waits for it
LONGEST = f"{BOX}.around"


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> PreparedFarm:
    return PreparedFarm.made(tmp_path_factory.mktemp("farm"))


@pytest.fixture
def farm(prepared: PreparedFarm, tmp_path: Path) -> Path:
    """A copy in which nothing is done."""
    return prepared.copied(tmp_path)


def _openjd(command: str, farm: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    try:
        program = ready_python(OPENJD) / "openjd"
    except NodeUnavailableError as error:
        pytest.skip(str(error))
    whole = [str(program), command, str(farm / "openjd.yaml"), *arguments]
    return subprocess.run(whole, capture_output=True, text=True, check=False, timeout=240)


def test_openjd_runs_the_whole_job(prepared: PreparedFarm, farm: Path, tmp_path: Path) -> None:
    """All steps by themselves, and the files are joined as one machine would have written them."""
    out = tmp_path / "out"
    joins = f"Assemble={bake_command('assemble')} --out {out}"
    run = _openjd("run", farm, "-p", f"Work={bake_command('work')}", "-p", joins)
    assert run.returncode == 0, run.stdout
    assert digests(out) == prepared.local
    prepared.check_done(farm)


@pytest.fixture(scope="module")
def prepared_with_frames(tmp_path_factory: pytest.TempPathFactory) -> PreparedFarm:
    return PreparedFarm.made(tmp_path_factory.mktemp("framed"), "--stock-frames")


@pytest.fixture
def framed(prepared_with_frames: PreparedFarm, tmp_path: Path) -> Path:
    """A copy of a farm with frames, none of which is rendered."""
    return prepared_with_frames.copied(tmp_path)


def _stock_blender(farm: Path, folder: Path) -> Path:
    """A program that renders as Blender does, and knows nothing of RadTex; it notes what it was asked for."""
    runner = f"{sys.executable} -I {farm / 'frames/render_frames.py'}"
    return _program(folder / "stock", f'echo "$*" >> \'{folder}/asked\'\nexec {runner} "$@" > /dev/null')


def _check_frames(farm: Path, folder: Path) -> None:
    """Each frame was asked for once, and the tasks took it."""
    tasks = read_tasks(farm)
    asked = [line.split() for line in (folder / "asked").read_text().splitlines()]
    wanted = [(each.name, number) for each in tasks.frames for number in range(1, each.count + 1)]
    assert sorted((Path(words[1]).stem, int(words[3])) for words in asked) == sorted(wanted)
    assert {Path(words[1]).suffix for words in asked} == {".blend"}


def test_openjd_lets_stock_blenders_render_frames(
    prepared_with_frames: PreparedFarm, framed: Path, tmp_path: Path
) -> None:
    stock = _stock_blender(framed, tmp_path)
    run = _openjd("run", framed, "-p", f"Work={bake_command('work')}", "-p", f"Blender={stock}")
    assert run.returncode == 0, run.stdout
    _check_frames(framed, tmp_path)
    prepared_with_frames.check_done(framed)


def test_make_and_slurm_let_stock_blenders_render_frames(
    prepared_with_frames: PreparedFarm, framed: Path, tmp_path: Path
) -> None:
    """Make does all but what slurm.sh then finds left: a task, and a frame."""
    stock = _stock_blender(framed, tmp_path)
    command = ["make", "-C", str(framed), f"WORK={bake_command('work')}", f"BLENDER={stock}"]
    run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)
    assert run.returncode == 0, run.stdout + run.stderr
    _check_frames(framed, tmp_path)
    prepared_with_frames.check_done(framed)
    picture, task = framed / f"frames/{BOX}.ends/0002.exr", f"{BOX}.ends"
    before = {path.name: path.read_bytes() for path in (framed / "pieces" / BOX).glob("ends-*")}
    for path in (picture, framed / f"done/{task}.json", *(framed / "pieces" / BOX / name for name in before)):
        path.unlink()
    _program(tmp_path / "bin/sbatch", f'exec {sys.executable} {REPOSITORY}/tests/real/inside/sbatch.py "$@"')
    variables = os.environ | {
        "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}",
        "SBATCH_JOBS": str(tmp_path / "jobs"),
        "WORK": f"{bake_command('work')} --progress none",
        "BLENDER": str(stock),
    }
    assert _submit(framed, variables) == [f"{BOX}.ends-frames", f"{BOX}.ends"]
    jobs = _jobs(tmp_path)
    assert [(job["state"], job["array"]) for job in jobs] == [("COMPLETED", "1"), ("COMPLETED", "0")]
    assert jobs[1]["needs"] == [1]
    assert {path.name: path.read_bytes() for path in (framed / "pieces" / BOX).glob("ends-*")} == before


def test_flamenco_renders_frames_before_the_tasks_that_need_them(
    prepared_with_frames: PreparedFarm,
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(prepared_with_frames.folder / "scene.blend"), load_ui=False)
    script = prepared_with_frames.folder / "radtex_tasks.js"
    kinds = compiled_flamenco_job(script, {"folder": "/x", "tasks": "a"})["type"]["settings"]
    names: dict[str, Any] = {"bpy": bpy, "C": bpy.context, "Path": Path, "jobname": "", "settings": None}
    worked_out = {each["key"]: eval(each["eval"], {}, names) for each in kinds if "eval" in each}
    made = {task["name"]: task for task in compiled_flamenco_job(script, worked_out)["tasks"]}
    farm = read_tasks(prepared_with_frames.folder)
    assert set(made) == {task.name for task in farm.with_frames()}
    for task in farm.with_frames():
        assert sorted(made[task.name]["dependencies"]) == sorted(task.needs)
    frame = made[f"frames/{BOX}.ends/0002.exr"]
    (command,) = frame["commands"]
    assert (command["name"], command["parameters"]["args"]) == ("blender-render", ["--render-frame", "2"])
    assert command["parameters"]["blendfile"] == f"{farm.folder}/frames/{BOX}.ends.blend"


@pytest.mark.parametrize("workers", [2, 4])
def test_openjd_workers_do_what_one_does(
    prepared: PreparedFarm, farm: Path, tmp_path: Path, workers: int
) -> None:
    """So many at once, each a task whose step waits for no other; one fails, and is done again."""
    worker = Worker.made(tmp_path, FLAKY)
    done_in_steps(read_tasks(farm), workers, partial(_do_once_more, farm, worker))
    assert {task: len(processes) for task, processes in worker.begun().items()} == {
        task: 1 + (task == FLAKY) for task in read_tasks(farm).by_name
    }
    prepared.check_done(farm)


def _do_once_more(farm: Path, worker: Worker, step: str, task: str) -> None:
    """Let OpenJD do a task in a process of its own, and again if it was lost."""
    one = ("--step", step, "--no-run-dependencies", "-tp", f"Task={task}", "-p", f"Work={worker.command}")
    run = _openjd("run", farm, *one)
    if run.returncode != 0 and "lost" in run.stdout:
        run = _openjd("run", farm, *one)
    assert run.returncode == 0, run.stdout


def test_openjd_takes_a_farm_of_300_bakes(tmp_path: Path) -> None:
    many = farm_of(tmp_path, 300)
    write_task_templates(many)
    run = _openjd("check", tmp_path)
    assert run.returncode == 0, run.stdout
    said = json.loads(_openjd("summary", tmp_path, "--output", "json").stdout)
    assert said["total_steps"] <= STEPS + 1
    assert said["total_tasks"] == len(many.tasks) + 1


def test_flamenco_compiles_the_tasks_of_the_open_file(prepared: PreparedFarm) -> None:
    """Its settings are worked out as its add-on does, with the names that its manual lists."""
    bpy.ops.wm.open_mainfile(filepath=str(prepared.folder / "scene.blend"), load_ui=False)
    script = prepared.folder / "radtex_tasks.js"
    given = {"work": 'python "/my tools/bake.py" work', "assemble": "/opt/join --overwrite"}
    kinds = compiled_flamenco_job(script, given | {"folder": "/x", "tasks": "a"})["type"]["settings"]
    names: dict[str, Any] = {"bpy": bpy, "C": bpy.context, "Path": Path, "jobname": "", "settings": None}
    worked_out = {each["key"]: eval(each["eval"], {}, names) for each in kinds if "eval" in each}
    assert set(worked_out) == {"folder", "tasks"}
    *tasks, joined = compiled_flamenco_job(script, given | worked_out)["tasks"]
    known = read_tasks(prepared.folder).tasks
    assert [(task["name"], task["dependencies"]) for task in tasks] == [
        (task.name, list(task.needs)) for task in known
    ]
    folder = str(prepared.folder)
    for task in tasks:
        (command,) = task["commands"]
        arguments = ["/my tools/bake.py", "work", folder, task["name"]]
        assert command == {"name": "exec", "parameters": {"exe": "python", "args": arguments}}
    assert (joined["name"], joined["dependencies"]) == ("assemble", [f"{BOX}.bake"])
    (command,) = joined["commands"]
    assert command["parameters"] == {"exe": "/opt/join", "args": ["--overwrite", folder]}
    assert [task["name"] for task in compiled_flamenco_job(script, worked_out)["tasks"]] == [
        task.name for task in known
    ]


def test_make_goes_on_where_a_killed_worker_ended(prepared: PreparedFarm, farm: Path, tmp_path: Path) -> None:
    worker = Worker.made(tmp_path)
    command = ["make", "-C", str(farm), "-j2", f"WORK={worker.command}"]
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    note = worker.notes / LONGEST
    until = time.monotonic() + 120
    while not (note.exists() and note.read_text().strip()):
        assert time.monotonic() < until
        time.sleep(0.05)
    time.sleep(1)  # it is in the midst of it
    os.kill(int(note.read_text()), signal.SIGKILL)
    said, _ = run.communicate(timeout=240)
    assert run.returncode == 2, said
    marks = {mark.name: mark.stat().st_mtime_ns for mark in (farm / "done").iterdir()}
    assert f"{BOX}.maps.json" in marks
    assert f"{LONGEST}.json" not in marks
    again = subprocess.run(command, capture_output=True, text=True, check=False, timeout=240)
    assert again.returncode == 0, again.stdout + again.stderr
    begun = worker.begun()
    assert len(begun.pop(LONGEST)) == 2
    assert {len(processes) for processes in begun.values()} == {1}  # nothing that was done is done again
    assert {name: (farm / "done" / name).stat().st_mtime_ns for name in marks} == marks
    prepared.check_done(farm)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    try:
        with slurm_cluster(tmp_path_factory.mktemp("slurm")) as made:
            yield made
    except SlurmUnavailableError as error:
        pytest.skip(str(error))


def _submit(farm: Path, variables: dict[str, str], *options: str) -> list[str]:
    """The names of the jobs that slurm.sh submits."""
    command = ["bash", str(farm / "slurm.sh"), *options]
    run = subprocess.run(command, env=variables, capture_output=True, text=True, check=True, timeout=240)
    return [line.split(": job ")[0] for line in run.stdout.splitlines()]


def test_slurm_does_what_is_left_when_it_is_submitted_again(
    cluster: Cluster, prepared: PreparedFarm, farm: Path, tmp_path: Path
) -> None:
    """Daemons of this machine's own run the arrays; a task fails, and what needs it is cancelled."""
    worker = Worker.made(tmp_path, FLAKY)
    out = tmp_path / "out"
    variables = cluster.variables | {
        "WORK": str(worker.command),
        "ASSEMBLE": f"{bake_command('assemble')} --out {out} --progress none",
    }
    assert len(_submit(farm, variables)) == len(read_tasks(farm).tasks) + 1
    cluster.wait()
    assert [task.name for task in read_tasks(farm).left()] == [FLAKY, *BEHIND]
    assert _submit(farm, variables, "--time=30") == [FLAKY, *BEHIND, "assemble"]
    cluster.wait()
    assert digests(out) == prepared.local
    begun = worker.begun()
    assert len(begun.pop(FLAKY)) == 2
    assert {len(processes) for processes in begun.values()} == {1}


def test_slurm_script_on_a_stand_in_for_sbatch(tmp_path: Path) -> None:
    """Two bakes with shares: each array's order and options, a failure, and what is left after it."""
    folder = tmp_path / "two bakes"
    folder.mkdir()
    farm = farm_of(folder, 2, texels=384)
    write_task_templates(farm)
    (folder / "done").mkdir()
    needs = "".join(f"{task.name}) needs='{' '.join(task.needs)}';;\n" for task in farm.tasks)
    work = _program(
        tmp_path / "work",
        f"""case "$2" in\n{needs}esac
for need in $needs; do [ -e "$1/done/$need.json" ] || exit 3; done
echo "$2" >> '{tmp_path}/order'
[ "$2" != Thing_1.light.2 ] || [ -e '{tmp_path}/repaired' ] || exit 1
echo '{{}}' > "$1/done/$2.json"
""",
    )
    _program(tmp_path / "bin/sbatch", f'exec {sys.executable} {REPOSITORY}/tests/real/inside/sbatch.py "$@"')
    variables = os.environ | {
        "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}",
        "SBATCH_JOBS": str(tmp_path / "jobs"),
        "WORK": str(work),
        "ASSEMBLE": str(_program(tmp_path / "join", f"ls \"$1/done\" > '{tmp_path}/joined'")),
    }
    with pytest.raises(subprocess.CalledProcessError) as full:
        _submit(folder, variables | {"SBATCH_MOST": "3"}, "--partition=render")
    assert "slurm.sh: sbatch refused Thing_0.light; what was submitted goes on" in full.value.stderr
    assert len(list((folder / "done").iterdir())) == len((tmp_path / "order").read_text().split()) > 0
    _submit(folder, variables, "--partition=render")
    left = {task.name for task in farm.left()}
    assert "Thing_1.light.2" in left
    assert not any(name.startswith("Thing_0") for name in left)  # the other bake is done
    jobs = _jobs(tmp_path)
    states = {job["name"]: job["state"] for job in jobs}
    assert states["Thing_1.light"] == "FAILED"
    assert states["Thing_1.bake"] == states["assemble"] == "CANCELLED"
    assert {job["partition"] for job in jobs} == {"render"}
    assert {job["kill"] for job in jobs if job["needs"]} == {"yes"}
    assert not (tmp_path / "joined").exists()
    (tmp_path / "repaired").touch()
    _submit(folder, variables)
    again = _jobs(tmp_path)[len(jobs) :]
    assert {job["state"] for job in again} == {"COMPLETED"}
    assert (again[0]["name"], again[0]["array"]) == ("Thing_1.light", "1")  # its second share alone
    order = (tmp_path / "order").read_text().split()
    assert sorted(order) == sorted([*(task.name for task in farm.tasks), "Thing_1.light.2"])
    assert len((tmp_path / "joined").read_text().split()) == len(farm.tasks)
    del variables["ASSEMBLE"]
    (said,) = _submit(folder, variables)
    assert said.startswith("All tasks are done. Join them: python bake.py assemble ")


def _program(path: Path, text: str) -> Path:
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"#!/bin/bash\n{text}\n", encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def _jobs(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "jobs").read_text().splitlines()]
