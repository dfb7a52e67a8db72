# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress reports of a running job."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass
from enum import StrEnum
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
