# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a job as plain data: the panel draws it, a worker's events change it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from ..core.messages import Message
from ..settings.estimate import EXPORT
from ..settings.time_left import Course, Left
from ..textures.export_spec import ExportTask
from .order import Order, Work

_NOTHING = Message("")
_EXPORTED = frozenset(map(str, ExportTask))


class JobState(StrEnum):
    """The state of a job; all but the first two are final, but that what is LEFT can be gone on with.

    LEFT are jobs that waited or ran when their Blender ended.
    """

    WAITING = "waiting"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"
    LEFT = "left"


@dataclass(frozen=True)
class JobMap:
    """The UV map that is baked on: its `picture`, how many `islands` it has, and its `coverage`, 0 to 1."""

    picture: Path
    islands: int
    coverage: float


@dataclass(frozen=True)
class Job:
    """An order in the queue, and its state.

    `stage` is None until the worker reports one. `fraction` of the work that is done, 0 to 1, never
    decreases. `course` is what its stages took so far; `left` is the time left by that at the last poll, None
    before it runs and after its end. `message` is one line: the result, or why the job failed. `picture` is
    the latest picture of what is done so far, `map` the UV map of a bake; the worker's folder has the
    pictures while it runs. `files` and `facts` are what the worker reported when it was done. `took`: seconds
    from its start to its end, None if it never started. `log`: the end of what a failed worker said on
    standard error, such as a traceback. `begun`: a worker worked on it, if it is left maybe that of an
    earlier Blender.
    """

    number: int
    order: Order
    state: JobState = JobState.WAITING
    cancelling: bool = False
    stage: str | None = None
    fraction: float = 0.0
    course: Course | None = None
    left: Left | None = None
    message: Message = _NOTHING
    warnings: tuple[Message, ...] = ()
    picture: Path | None = None
    map: JobMap | None = None
    files: tuple[Path, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    took: float | None = None
    log: str = ""
    begun: bool = False

    @property
    def work(self) -> Work:
        """The kind of work."""
        return self.order.work

    @property
    def object(self) -> str:
        """The object or atlas that is worked on."""
        return self.order.object

    @property
    def out(self) -> Path:
        """The folder of its files."""
        return self.order.out

    @property
    def ended(self) -> bool:
        """Whether the state is final."""
        return self.state not in (JobState.WAITING, JobState.RUNNING)

    def begins(self) -> Job:
        """The job when its worker starts."""
        return replace(self, state=JobState.RUNNING, course=self.order.course, begun=True)

    def hears(self, event: Mapping[str, Any], now: float = 0.0) -> Job:
        """The job after an event, `now` seconds after the worker's start; unknown events change nothing."""
        match event.get("event"):
            case "progress":
                return self._progressed(event["stage"], event["done"], event["total"], now)
            case "warning":
                return replace(self, warnings=(*self.warnings, Message.of_facts(event)))
            case "picture":
                return replace(self, picture=Path(event["path"]))
            case "map":
                made = JobMap(Path(event["path"]), int(event["islands"]), float(event["coverage"]))
                return replace(self, map=made)
            case "done":
                files = tuple(Path(path) for path in event["files"])
                return replace(self, files=files, message=Message(str(event["summary"])), facts=event)
        return self

    def ends(self, state: JobState, message: Message, took: float | None = None) -> Job:
        """The job after its worker has ended; an empty message keeps the current one."""
        whole = 1.0 if state is JobState.DONE else self.fraction
        course = None if self.course is None or took is None else self.course.end(took)
        return replace(
            self,
            state=state,
            fraction=whole,
            course=course,
            left=None,
            message=message if message.problem else self.message,
            took=took,
        )

    def left_over(self) -> Job:
        """The job once its Blender has ended before it was done."""
        ended = replace(self, state=JobState.LEFT, cancelling=False, picture=None, map=None)
        return replace(ended, course=None, left=None)

    def goes_on(self) -> Job:
        """The job that is left, to be done after all; a bake that was begun is resumed."""
        order = self.order
        if self.begun and order.work is Work.BAKE:
            order = replace(order, facts={**order.facts, "resume": True})
        elif self.begun:  # an export, or of a farm: what there is of it was never finished
            order = replace(order, facts={**order.facts, "overwrite": True})
        return replace(self, order=order, state=JobState.WAITING, stage=None)

    def _progressed(self, stage: str, done: float, total: float, now: float) -> Job:
        here, past = self.order.stages.get(stage, 0.0), self._past(stage)
        part = done / total if total else 1.0
        course = self.course or self.order.course
        if self.work is Work.BAKE and stage in _EXPORTED:
            course = course.at(EXPORT, 0.0, now)  # of one export of several
        else:
            course = course.at(stage, part, now)
        fraction = max(self.fraction, min(past + here * part, 1.0))
        return replace(self, stage=stage, fraction=fraction, course=course)

    def _past(self, stage: str) -> float:
        """The fraction of the work before a stage; 0 for a stage that the order does not list."""
        stages = list(self.order.stages)
        before = stages[: stages.index(stage)] if stage in stages else []
        return sum(self.order.stages[other] for other in before)
