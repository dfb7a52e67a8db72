# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress reports of a running job, and how long each of its stages took."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass
from enum import StrEnum
from time import perf_counter
from typing import TypeAlias, TypeVar

_PULSE = 0.1  # seconds between two reports of work in a thread

_Result = TypeVar("_Result")
_Step = TypeVar("_Step")
_Other = TypeVar("_Other")


class Stage(StrEnum):
    """The stages of a job, in order."""

    EVALUATE = "evaluate"
    UNWRAP = "unwrap"
    RASTER = "raster"
    PROBE = "probe"
    CAPTURE = "capture"
    SURROUNDINGS = "surroundings"
    DENOISE = "denoise"
    FILL = "fill"
    FIT = "fit"
    WRITE = "write"
    PREVIEW = "preview"


@dataclass(frozen=True)
class Progress:
    """`done` of `total` units of a stage are finished; a stage without units goes from 0 to 1."""

    stage: Stage
    done: int
    total: int


@dataclass(frozen=True)
class StageParts:
    """A stage of several parts, in order, with the seconds that each typically takes.

    Its units are milliseconds of these, so that its progress is even.
    """

    stage: Stage
    seconds: Mapping[str, float]

    def at(self, part: str, share: float = 0.0) -> Progress:
        """A `share` of the part is done, and all before it."""
        names = list(self.seconds)
        before = sum(self.seconds[name] for name in names[: names.index(part)])
        return self._progress(before + share * self.seconds[part])

    def end(self) -> Progress:
        """All parts are done."""
        return self._progress(sum(self.seconds.values()))

    def _progress(self, seconds: float) -> Progress:
        return Progress(self.stage, round(1000 * seconds), max(1, round(1000 * sum(self.seconds.values()))))


Steps: TypeAlias = Generator[Progress, None, _Result]  # work that yields its progress and returns a result


def finished(steps: Generator[object, None, _Result]) -> _Result:
    """Run a generator to its end, and return its value."""
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            result: _Result = stop.value
            return result


def in_a_thread(work: Callable[[], _Result], told: Progress) -> Steps[_Result]:
    """Let a thread `work`, which must not touch Blender, yield `told` until it is done, return its result.

    Closing this waits for the thread: NumPy cannot be interrupted.
    """
    with ThreadPoolExecutor(1) as pool:
        result = pool.submit(work)
        while not wait([result], _PULSE).done:
            yield told
        return result.result()


def relayed(
    steps: Generator[_Step, None, _Result], each: Callable[[_Step], _Other]
) -> Generator[_Other, None, _Result]:
    """Yield `each` of another generator's steps, and return its value; closing this closes `steps`."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as stop:
                result: _Result = stop.value
                return result
            yield each(step)


class Stopwatch:
    """Seconds by stage; a stage may be entered more than once."""

    def __init__(self) -> None:
        self.seconds: dict[Stage, float] = {}
        self._stage: Stage | None = None
        self._since = 0.0

    def start(self, stage: Stage) -> Progress:
        """Enter a stage without units; returns its first progress."""
        self.enter(stage)
        return Progress(stage, 0, 1)

    def enter(self, stage: Stage) -> None:
        """Leave the current stage, if any, and enter this one."""
        if stage is not self._stage:
            self.stop()
            self._stage, self._since = stage, perf_counter()

    def stop(self) -> None:
        """Leave the current stage."""
        if self._stage is not None:
            spent = perf_counter() - self._since
            self.seconds[self._stage] = self.seconds.get(self._stage, 0.0) + spent
            self._stage = None

    def over(self, steps: Generator[Progress, None, _Result]) -> Generator[Progress, None, _Result]:
        """Yield another generator's steps, and enter their stages; closing this closes `steps`."""

        def entered(step: Progress) -> Progress:
            self.enter(step.stage)
            return step

        return relayed(steps, entered)
