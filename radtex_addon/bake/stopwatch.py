# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long each stage of a job took."""

from __future__ import annotations

from collections.abc import Generator
from time import perf_counter
from typing import TypeVar

from .progress import Progress, Stage, relayed

_Result = TypeVar("_Result")


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
