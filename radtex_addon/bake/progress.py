# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress reports of a running job."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias, TypeVar

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
