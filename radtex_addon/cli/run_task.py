# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py work`, where it does tasks of a farm."""

from __future__ import annotations

from functools import partial
from time import sleep

from ..core.errors import Cancelled
from ..farm.claims import Claim, claimed
from ..farm.run_task import task_steps
from ..farm.tasks import Task, TaskFarm, read_tasks
from .failure import end_process
from .interruption import INTERRUPTED, Interruption
from .reporting import Report
from .work_arguments import TaskRequest

_WAIT = 2.0  # seconds between looks at what others do


def run_tasks(request: TaskRequest, report: Report, interruption: Interruption) -> None:
    """Do the tasks, and report each. Raises RadTexError."""
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    farm = read_tasks(request.folder)
    for task in [farm.task(name) for name in request.tasks]:
        _do(farm, task, report, interruption)
    if not request.tasks:
        _do_all(farm, report, interruption)


def _do(farm: TaskFarm, task: Task, report: Report, interruption: Interruption) -> None:
    leave = partial(end_process, Cancelled(INTERRUPTED), report)
    with interruption.leaving(leave):
        done = interruption.between(task_steps(farm, task.name), partial(report.progress, task.name))
    files = [str(farm.mark(task.name))]
    if not done:
        report.event("done", object=task.name, summary=f"{task.name}: was done already", files=files)
        return
    seconds = farm.done(task.name).seconds
    left = len(farm.left())
    summary = f"{task.name}: done in {seconds:.1f} s, {left} of {len(farm.tasks)} tasks are left"
    report.event("done", object=task.name, summary=summary, files=files)


def _do_all(farm: TaskFarm, report: Report, interruption: Interruption) -> None:
    """Do what is left, one task after another, of what no other machine does."""
    claims: dict[str, Claim] = {}
    while left := farm.left():
        chain = farm.chains()
        ready = [task for task in left if all(map(farm.is_done, task.needs))]
        for task in sorted(ready, key=lambda task: -chain[task.name]):
            with claimed(farm, task.name, claims) as own:
                if own and not farm.is_done(task.name):
                    _do(farm, task, report, interruption)
                    break
        else:
            sleep(_WAIT)  # others do what comes first
            interruption.check()
    report.event(
        "note", message=f"all {len(farm.tasks)} tasks are done: join them by bake.py assemble {farm.folder}"
    )
