# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a run of several bakes is as a whole, and how long the rest of it takes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from time import monotonic
from typing import Protocol

from ..job.variants import Bake
from ..settings.estimate import EXPORT, START, BakeWork, Estimate, estimate
from ..settings.spec import BakeSpec
from ..settings.time_left import Course, Left, time_left
from ..textures.export_spec import ExportTask

_TRIANGLES = 16_000  # of usual objects
_STEP = 5.0  # seconds that steps take, of which nothing is known
_EXPORTS = frozenset(map(str, ExportTask))


class Reached(Protocol):
    """Progress of one bake: `done` of `total` units of a stage."""

    @property
    def stage(self) -> StrEnum: ...

    @property
    def done(self) -> int: ...

    @property
    def total(self) -> int: ...


@dataclass(frozen=True)
class Whole:
    """Of a whole run: the `share` of its work that is done, 0 to 1, and the time left."""

    share: float
    left: Left


class WholeProgress:
    """The courses of bakes that are `expected`, in this order: those that are over tell of those to come."""

    def __init__(self, expected: Iterable[Estimate], clock: Callable[[], float] = monotonic) -> None:
        self._waiting = list(expected)
        self._whole = sum(one.total for one in self._waiting)
        self._clock = clock
        self._since = clock()
        self._ended: list[Course] = []
        self._running: Course | None = None
        self._share = 0.0

    def begin(self) -> None:
        """The next bake begins: all stages of the one before are done, or were left out."""
        now = self._clock()
        if self._running is not None:
            self._ended.append(self._running.end(now - self._since))
        self._running, self._since = Course(self._waiting.pop(0)), now

    def at(self, step: Reached) -> Whole:
        """The current bake has reached `step`."""
        assert self._running is not None
        now = self._clock() - self._since
        share = step.done / step.total if step.total else 1.0
        if step.stage in _EXPORTS:
            self._running = self._running.at(EXPORT, 0.0, now)  # of one export of several
        else:
            self._running = self._running.at(str(step.stage), share, now)
        done = sum(one.expected.total for one in self._ended) + self._running.done
        self._share = max(self._share, min(1.0, done / self._whole) if self._whole else 1.0)
        return Whole(self._share, time_left(self._running, now, self._ended, self._waiting))


def whole_progress(bakes: Iterable[Bake], preview: bool, exports: int, unsure: bool) -> WholeProgress:
    """The progress of a run of these bakes, in their order, with so many `exports` of each.

    `unsure`: a part of them may be done already, as where they are resumed.
    """

    def expected(spec: BakeSpec) -> Estimate:
        work = BakeWork.of(spec, _TRIANGLES, preview=preview, exports=exports, device=spec.device)
        made = without_start(estimate(work, "", "", ()))
        return made.unsure() if unsure or spec.incremental else made

    return WholeProgress(expected(spec) for _, spec in bakes)


def without_start(expected: Estimate) -> Estimate:
    """The same of a bake in a process that runs already."""
    seconds = {stage: value for stage, value in expected.seconds.items() if stage != START}
    return replace(expected, seconds=seconds)


class StepClock:
    """The time left of one step of a report, a comparison or an export, by the share of it that is done."""

    def __init__(self) -> None:
        self._key: tuple[str, StrEnum] | None = None
        self._since = 0.0
        self._course = Course(Estimate())

    def left(self, name: str, step: Reached) -> Left:
        """The time until the step is done."""
        if self._key != (name, step.stage):
            self._key, self._since = (name, step.stage), monotonic()
            self._course = Course(Estimate({str(step.stage): _STEP}))
        now = monotonic() - self._since
        self._course = self._course.at(str(step.stage), step.done / step.total if step.total else 1.0, now)
        return time_left(self._course, now)
