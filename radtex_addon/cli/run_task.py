# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py work`, where it does tasks of a farm."""

from __future__ import annotations

from functools import partial
from time import sleep

from ..core.errors import Cancelled, InputError, RadTexError
from ..farm.claims import Claim, claimed, release_claims
from ..farm.run_task import task_steps
from ..farm.tasks import Task, TaskFarm, read_tasks
from .failure import end_process
from .interruption import INTERRUPTED, Interruption
from .reporting import Report
from .work_arguments import TaskRequest

_NAMED = 8  # most tasks that are named
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
    def leave() -> None:
        release_claims()
        end_process(Cancelled(INTERRUPTED), report)

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
    """Do what is left, one task after another, of what no other machine does.

    A task that fails, and what needs it, is left out, but what failed for another's lost piece is tried once
    more. Raises the first failure at the end, with the names of all that failed, and that no other machine
    has done since.
    """
    claims: dict[str, Claim] = {}
    failed: dict[str, RadTexError] = {}
    given_up: set[str] = set()
    chain = farm.chains()
    while left := farm.left():
        farm.check_same()
        names = {task.name for task in left}
        ready = [task for task in left if names.isdisjoint(task.needs) and task.name not in given_up]
        if not ready:
            break
        for task in sorted(ready, key=lambda task: (farm.lacks_pictures(task), -chain[task.name])):
            with claimed(farm, task.name, claims) as own:
                if not own or farm.is_done(task.name):
                    continue
                try:
                    _do(farm, task, report, interruption)
                except Cancelled:
                    raise
                except RadTexError as error:
                    if task.name in failed or isinstance(error, InputError):
                        given_up.add(task.name)
                    failed[task.name] = error
                else:
                    failed.pop(task.name, None)
                break
        else:
            sleep(_WAIT)  # others do what comes first
            interruption.check()
    if failed := {name: error for name, error in failed.items() if not farm.is_done(name)}:
        first, *others = failed.values()
        said = f"{len(failed)} tasks failed here ({', '.join(list(failed)[:_NAMED])}); the first one: "
        raise first.saying(said + first.message.problem) if others else first
    report.event(
        "note", message=f"all {len(farm.tasks)} tasks are done: join them by bake.py assemble {farm.folder}"
    )
