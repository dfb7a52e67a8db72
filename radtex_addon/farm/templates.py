# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the files beside a farm's .blend: for OpenJD, Flamenco, Slurm and make, and a runner for bpy."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import ceil
from pathlib import Path

from ..core.quoting import in_comment, yaml_string
from .farm_files import RUNNER, FarmFiles
from .farm_manifest import FarmManifest
from .steps import Step, steps_of
from .tasks import Task, TaskFarm

_FOLDER = Path(__file__).parent / "templates"
OPENJD, FLAMENCO = "openjd.yaml", "radtex_farm.js"
TASKS_OPENJD, TASKS_FLAMENCO, SLURM, MAKEFILE = "openjd_tasks.yaml", "radtex_tasks.js", "slurm.sh", "Makefile"
_NAME_MOST = 100  # OpenJD's limit is 128
_MEMORY = 1.5  # times what a task is thought to take, above which Slurm may end it …
_SECONDS, _BEGIN = 10, 1200.0  # … as it does when a task takes so many times longer, and this many seconds


def write_templates(files: FarmFiles, manifest: FarmManifest) -> None:
    """Write the templates into the farm's folder, with the farm's frame numbers."""
    name = yaml_string(f"RadTex {in_comment(manifest.name)[:_NAME_MOST]} {manifest.spec.kind}")
    frames = f"1-{manifest.sheets}" if manifest.sheets > 1 else "1"
    for source in (OPENJD, FLAMENCO, files.runner.name):
        _write(files.folder / source, source, NAME=name, FRAMES=frames)


def write_runner(target: Path) -> None:
    """Write the script that renders frames with the bpy module."""
    _write(target, RUNNER)


def write_task_templates(farm: TaskFarm) -> None:
    """Write what does a farm's tasks, each after those that it needs, into its folder."""
    tasks = farm.with_frames()
    steps = steps_of(tasks)
    title = farm.bakes[0].name if len(farm.bakes) == 1 else Path(farm.blend).stem or farm.scene
    name = yaml_string(f"RadTex {in_comment(title)[:_NAME_MOST]}")
    last = " ".join(f"done/{task.name}.json" for task in farm.tasks if task.is_last)
    ends = _openjd_needs([step.name for step in steps if step.is_last])
    folder = farm.folder
    renders = _OPENJD_BLENDER if farm.frames else ""
    rows = "".join(map(_openjd_step, steps))
    _write(folder / OPENJD, TASKS_OPENJD, NAME=name, BLENDER=renders, STEPS=rows, ENDS=ends)
    _write(folder / TASKS_FLAMENCO, TASKS_FLAMENCO)
    _write(folder / SLURM, SLURM, STEPS=_slurm_steps(steps), LAST=_slurm_last(steps))
    _write(folder / MAKEFILE, MAKEFILE, LAST=last, RULES=_make_rules(tasks))


def _write(target: Path, source: str, **values: str) -> None:
    """Write a template, with the values where their names stand, as in @NAME@."""
    text = (_FOLDER / source).read_text(encoding="utf-8")
    text = re.sub("@([A-Z]+)@", lambda found: values[found[1]], text)
    target.write_text(text, encoding="utf-8", newline="\n")


def _openjd_step(step: Step) -> str:
    tasks = "".join(f"            - {yaml_string(task.name)}\n" for task in step.tasks)
    return (
        f"  - name: {yaml_string(step.name)}\n"
        f"{_openjd_needs(step.needs)}"
        "    hostRequirements:\n"
        "      amounts:\n"
        "        - name: amount.worker.memory\n"
        f"          min: {_mebibytes(step.memory)}\n"
        "    parameterSpace:\n"
        "      taskParameterDefinitions:\n"
        "        - name: Task\n"
        "          type: STRING\n"
        "          range:\n"
        f"{tasks}"
        "    script:\n"
        f"{_OPENJD_FRAME if step.is_rendered else _OPENJD_WORK}"
    )


_OPENJD_WORK = """\
      actions:
        onRun:
          command: bash
          args: ["-c", '$0 "$@"', "{{Param.Work}}", "{{Param.Folder}}", "{{Task.Param.Task}}"]
"""
_OPENJD_FRAME = """\
      embeddedFiles:
        - name: Run
          type: TEXT
          filename: frame.sh
          data: |
            set -euo pipefail
            picture="$1/$2" blender="$3" number="$(basename "$2" .exr)"
            [ ! -s "$picture" ] || exit 0 # `work` names a damaged one
            # Blender ends well where a frame was not rendered.
            $blender -b "$(dirname "$picture").blend" -f "$((10#$number))"
            [ -s "$picture" ] || { echo "not rendered: $picture" >&2; exit 1; }
      actions:
        onRun:
          command: bash
          args: ["{{Task.File.Run}}", "{{Param.Folder}}", "{{Task.Param.Task}}", "{{Param.Blender}}"]
"""
_OPENJD_BLENDER = """\
  - name: Blender
    type: STRING
    default: blender
    description: The command that renders frames, on machines without RadTex, with arguments that come first.
"""


def _openjd_needs(needs: Sequence[str]) -> str:
    if not needs:
        return ""
    return "    dependencies:\n" + "".join(f"      - dependsOn: {yaml_string(need)}\n" for need in needs)


def _slurm_steps(steps: Sequence[Step]) -> str:
    """A line for each step: its number, name, MiB, minutes, the numbers of those it needs, its tasks."""
    numbers = {step.name: str(number) for number, step in enumerate(steps)}
    lines = [
        f"step {numbers[step.name]} {step.name} {_mebibytes(step.memory * _MEMORY)} {_minutes(step.seconds)} "
        f'"{" ".join(numbers[need] for need in step.needs)}" {" ".join(task.name for task in step.tasks)}'
        for step in steps
    ]
    return "\n".join(lines)


def _slurm_last(steps: Sequence[Step]) -> str:
    """What joining needs: MiB, and the numbers of the steps that come first."""
    memory = max(step.memory for step in steps if step.is_last)
    needs = " ".join(str(number) for number, step in enumerate(steps) if step.is_last)
    return f'{_mebibytes(memory * _MEMORY)} "{needs}"'


def _minutes(seconds: float) -> int:
    return ceil((_BEGIN + seconds * _SECONDS) / 60)


def _mebibytes(size: float) -> int:
    return ceil(size / (1 << 20))


def _make_rules(tasks: Sequence[Task]) -> str:
    made = {task.name: task.name if task.is_frame else f"done/{task.name}.json" for task in tasks}
    rules = (
        f"{made[task.name]}: |{''.join(f' {made[need]}' for need in task.needs)}\n\t{_make_recipe(task)}\n"
        for task in tasks
    )
    return "\n".join(rules)


def _make_recipe(task: Task) -> str:
    if not task.is_frame:
        return f"$(WORK) . {task.name}"
    picture = Path(task.name)
    blend = f"{picture.parent.as_posix()}.blend"
    return f"$(BLENDER) -b {blend} -f {int(picture.stem)} && test -s $@ || {{ rm -f $@; false; }}"
