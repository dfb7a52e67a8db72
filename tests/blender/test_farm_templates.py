# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The steps in which programs that run farms do a farm's tasks, and the files for them in its folder."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from radtex_addon.farm.steps import STEPS, TASKS, Step, steps_of
from radtex_addon.farm.task_graph import Subject, keyed, tasks_of
from radtex_addon.farm.tasks import Task, TaskFarm
from radtex_addon.farm.templates import write_task_templates
from radtex_addon.settings.spec import BakeSpec, Layout

LONG = "A name that is much longer than forty letters, and quite alike "
SECONDS = 60.0


def farm_of(folder: Path, bakes: int, texels: int = 512, title: str = "Thing") -> TaskFarm:
    """A farm of objects, of which each third one may let light through."""
    spec = BakeSpec(layout=Layout.LAYERED, texels=texels, samples=64)
    subjects = [Subject(f"{title} {number}", spec, number % 3 == 0, 1000) for number in range(bakes)]
    named = keyed(subjects)
    tasks = tuple(tasks_of(named, subjects, 600 << 20))
    return TaskFarm(folder, "0" * 32, "Scene", "room.blend", "0", "0", None, tuple(named), tasks)


def _check_order(tasks: tuple[Task, ...], steps: list[Step]) -> None:
    """Each task is in one step, behind and bound to the steps of those that it needs."""
    step_of = {task.name: step.name for step in steps for task in step.tasks}
    assert sorted(step_of) == sorted(task.name for task in tasks)
    assert sum(len(step.tasks) for step in steps) == len(tasks)
    assert len({step.name for step in steps}) == len(steps)
    done: set[str] = set()
    for step in steps:
        assert done.issuperset(step.needs)
        assert {step_of[need] for task in step.tasks for need in task.needs} == set(step.needs)
        done.add(step.name)


@pytest.mark.one_blender
@pytest.mark.parametrize(("bakes", "texels"), [(1, 64), (2, 512), (50, 256), (300, 512), (20, 4096)])
def test_steps_are_few_and_keep_the_order(tmp_path: Path, bakes: int, texels: int) -> None:
    farm = farm_of(tmp_path, bakes, texels)
    steps = steps_of(farm.tasks)
    _check_order(farm.tasks, steps)
    assert len(steps) <= STEPS
    assert max(len(step.tasks) for step in steps) <= TASKS
    assert max(len(step.name) for step in steps) <= 64  # OpenJD's limit


@pytest.mark.one_blender
def test_a_few_bakes_wait_for_nothing_of_each_other(tmp_path: Path) -> None:
    steps = {step.name: step for step in steps_of(farm_of(tmp_path, 2).tasks)}
    assert steps["Thing_1.around"].needs == ("Thing_1.maps",)
    assert [name for step in steps.values() for name in step.needs if step.name[:7] != name[:7]] == []
    assert len(steps["Thing_1.light"].tasks) > 1  # shares of one part are one step


@pytest.mark.one_blender
def test_more_tasks_than_a_step_takes_are_several(tmp_path: Path) -> None:
    farm = farm_of(tmp_path, 40, 4096)
    steps = steps_of(farm.tasks, most=1)
    _check_order(farm.tasks, steps)
    of_light = [step for step in steps if ".light" in step.name]
    assert [step.name for step in of_light[:2]] == ["bakes_1-40.light", "bakes_1-40.light_2"]
    assert len(of_light[0].tasks) == TASKS


@pytest.mark.one_blender
def test_names_that_begin_alike_are_told_apart(tmp_path: Path) -> None:
    names = [step.name for step in steps_of(farm_of(tmp_path, 3, title=LONG).tasks) if step.is_last]
    key = "A_name_that_is_much_longer_than_forty_letters"[:40]
    assert sorted(names) == [f"{key}.bake", f"{key}.bake_2", f"{key}.bake_3"]


@pytest.mark.one_blender
def test_templates_of_an_odd_name_are_whole(tmp_path: Path) -> None:
    """A quote, a line end and what templates take for their own marks: each file still reads as it should."""
    farm = farm_of(tmp_path, 1, 64, '"{{Param.Folder}}"\n@STEPS@ $(id)')
    write_task_templates(farm)
    job = (tmp_path / "openjd.yaml").read_text(encoding="utf-8")
    (name,) = re.findall(r"^  - name: Name\n    type: STRING\n    default: (.*)$", job, re.MULTILINE)
    assert json.loads(name) == 'RadTex "{{Param.Folder}}"\\n@STEPS@ $(id) 0'
    assert [step.name for step in _openjd_steps(tmp_path)] == [s.name for s in steps_of(farm.tasks)] + [
        "Assemble"
    ]
    assert not re.search(r"^@|\$\(id\)", (tmp_path / "slurm.sh").read_text(encoding="utf-8"), re.MULTILINE)
    subprocess.run(["bash", "-n", str(tmp_path / "slurm.sh")], check=True)


@pytest.mark.one_blender
def test_openjd_and_slurm_get_each_steps_needs_and_memory(tmp_path: Path) -> None:
    farm = farm_of(tmp_path, 2)
    write_task_templates(farm)
    *given, joins = _openjd_steps(tmp_path)
    lines = (tmp_path / "slurm.sh").read_text(encoding="utf-8").splitlines()
    rows = [shlex.split(line)[1:] for line in lines if line.startswith("step ")]
    steps = steps_of(farm.tasks)
    assert len(given) == len(rows) == len(steps)
    for step, one, (number, name, memory, minutes, needs, *tasks) in zip(steps, given, rows, strict=True):
        names = [task.name for task in step.tasks]
        assert (one.name, name, list(one.tasks), tasks) == (step.name, step.name, names, names)
        assert one.needs == step.needs
        assert [rows[int(need)][1] for need in needs.split()] == list(step.needs)
        assert rows[int(number)][1] == step.name
        assert one.memory is not None
        assert 0 <= one.memory * (1 << 20) - step.memory < 1 << 20
        assert int(memory) * (1 << 20) >= step.memory * 1.5
        assert int(minutes) * SECONDS >= step.seconds * 10
    last = tuple(step.name for step in steps if step.is_last)
    assert joins.needs == last
    assert sorted(last) == ["Thing_0.bake", "Thing_1.bake"]


class Given(NamedTuple):
    """A step of an OpenJD template; its memory is in MiB."""

    name: str
    needs: tuple[str, ...]
    memory: int | None
    tasks: tuple[str, ...]


def _openjd_steps(folder: Path) -> list[Given]:
    """The steps of the template in a folder, of which openjd itself says that it is one (see tests/real)."""
    text = (folder / "openjd.yaml").read_text(encoding="utf-8").split("\nsteps:\n")[1]
    return [_openjd_step(step) for step in re.split("^  - name: ", text, flags=re.MULTILINE)[1:]]


def _openjd_step(text: str) -> Given:
    needs = re.findall(r"^      - dependsOn: \"(.*)\"$", text, re.MULTILINE)
    memory = re.findall(r"^        - name: amount.worker.memory\n          min: (\d+)$", text, re.MULTILINE)
    tasks = re.findall(r"^            - \"(.*)\"$", text, re.MULTILINE)
    name = text.split("\n", maxsplit=1)[0].strip('"')
    return Given(name, tuple(needs), int(memory[0]) if memory else None, tuple(tasks))
