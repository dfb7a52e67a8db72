# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small farm of tasks, fresh copies of it, and the files that one machine makes of the same bake."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.farm.steps import steps_of
from radtex_addon.farm.tasks import TaskFarm
from tests.blender import stage
from tests.blender.killed import digests
from tests.real.root import REPOSITORY

BOX = "Box"
_OPTIONS = ("--object", BOX, "--texels", "8", "--samples", "1", "--seed", "9", "--progress", "none")
_PATIENCE = 240  # seconds for one task, or a bake, on a busy machine
# Does a task, and first adds a line with its process to the task's note.
_WORKER = """#!/bin/bash
for task; do :; done
echo $$ >> '{notes}'/"$task"
if [ "$task" = '{flaky}' ] && [ "$(wc -l < '{notes}'/"$task")" = 1 ]; then echo lost >&2; exit 1; fi
exec '{python}' '{bake}' work "$@" --progress none
"""


def bake_command(name: str) -> str:
    """The command line of `bake.py`, for programs that run farms."""
    return f"{sys.executable} {REPOSITORY / 'bake.py'} {name}"


@dataclass(frozen=True)
class Worker:
    """A command that does tasks and notes each beginning; the task `flaky` fails once."""

    command: Path
    notes: Path

    @classmethod
    def made(cls, folder: Path, flaky: str = "") -> Worker:
        notes = folder / "notes"
        notes.mkdir()
        command = folder / "worker"
        text = _WORKER.format(notes=notes, flaky=flaky, python=sys.executable, bake=REPOSITORY / "bake.py")
        command.write_text(text, encoding="utf-8")
        command.chmod(0o755)
        return cls(command, notes)

    def begun(self) -> dict[str, list[int]]:
        """The process of each time that a task was begun, by its name."""
        return {note.name: [int(line) for line in note.read_text().split()] for note in self.notes.iterdir()}


@dataclass(frozen=True)
class PreparedFarm:
    """A farm's folder in which nothing is done, and the digests of the files of the same bake, made here."""

    folder: Path
    local: dict[str, str]

    @classmethod
    def made(cls, folder: Path, *options: str) -> PreparedFarm:
        """A plane under lamps and a cube, prepared with options, and baked, as a user would."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        stage.world((0.2, 0.3, 0.4))
        stage.lamps()
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.3, 0.2, 0.6))
        bpy.ops.mesh.primitive_plane_add()
        scene: Any = bpy.context.scene
        scene.objects["Plane"].name = BOX
        blend = folder / "box.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(blend))
        _bake_py("prepare", str(blend), *_OPTIONS, *options, "--out", str(folder / "far"))
        _bake_py(str(blend), *_OPTIONS, "--out", str(folder / "local"))
        (far,) = (folder / "far").iterdir()
        return cls(far, digests(folder / "local"))

    def copied(self, folder: Path) -> Path:
        """A copy of the farm in a folder, as it was prepared."""
        return Path(shutil.copytree(self.folder, folder / self.folder.name))

    def check_done(self, farm: Path) -> None:
        """All of a copy's tasks are done, and each file is that of one machine, byte by byte."""
        assert digests(farm / "baked" / BOX) == self.local


def done_in_steps(farm: TaskFarm, workers: int, do: Callable[[str, str], None]) -> None:
    """Do all tasks by `do(step, task)`, so many at once; no step begins before those that it needs."""
    left = {step.name: step for step in steps_of(farm.tasks)}
    tasks_left = {name: len(step.tasks) for name, step in left.items()}
    with ThreadPoolExecutor(workers) as pool:
        running: dict[Future[None], str] = {}
        while left or running:
            ready = [step for step in left.values() if not any(map(tasks_left.get, step.needs))]
            for step in ready:
                running |= {pool.submit(do, step.name, task.name): step.name for task in step.tasks}
                del left[step.name]
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                future.result()
                tasks_left[running.pop(future)] -= 1


def _bake_py(*arguments: str) -> None:
    command = [sys.executable, str(REPOSITORY / "bake.py"), *arguments]
    run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=_PATIENCE)
    assert run.returncode == 0, run.stderr
