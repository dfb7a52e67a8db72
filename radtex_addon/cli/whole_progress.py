# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a run of several bakes is as a whole, and how long the rest of it takes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from time import monotonic
from typing import Protocol

from ..bake.progress import Stage
from ..job.variants import Bake
from ..settings.estimate import BakeWork, typical_seconds
from ..settings.spec import BakeSpec

_PRIOR = (
    4.0  # typical seconds for which a stage is taken to be as slow as all stages so far, and these as usual
)
_TRIANGLES = 16_000  # of usual objects
_LEAST = 2.0  # seconds that must have gone by before the time left is told


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
    """Of a whole run: the `share` of its work that is done, 0 to 1, and the seconds left, None if unknown."""

    share: float
    seconds_left: float | None


class WholeProgress:
    """Counts bakes in typical seconds of their stages, and learns from each stage how long it takes here.

    `works` are the typical seconds of each bake's stages, in the order in which they are baked.
    """

    def __init__(self, works: Iterable[Mapping[str, float]], clock: Callable[[], float] = monotonic) -> None:
        self._works = [dict(work) for work in works]
        self._clock = clock
        self._since = self._last = clock()
        self._bake, self._stage = -1, ""
        self._reached: dict[str, float] = {}  # typical seconds that are done, by stage, of the current bake
        self._done: dict[str, float] = {}  # … and of all bakes
        self._took: dict[str, float] = {}  # seconds that these took
        self._share = 0.0

    def begin(self) -> None:
        """The next bake begins: all stages of the one before are done, or were left out."""
        if self._stage:
            self._advance(self._stage, self._works[self._bake].get(self._stage, 0.0))
        self._bake, self._stage, self._reached = self._bake + 1, "", {}

    def at(self, step: Reached) -> Whole:
        """The current bake has reached `step`."""
        now, stage = self._clock(), str(step.stage)
        work = self._works[self._bake]
        self._took[self._stage or stage] = self._took.get(self._stage or stage, 0.0) + now - self._last
        self._last = now
        if self._stage and stage != self._stage:
            self._advance(self._stage, work.get(self._stage, 0.0))
        self._stage = stage
        self._advance(stage, work.get(stage, 0.0) * (step.done / step.total if step.total else 1.0))
        self._share = max(self._share, self._done_share())
        return Whole(self._share, self._left(now))

    def _advance(self, stage: str, reached: float) -> None:
        gain = max(0.0, reached - self._reached.get(stage, 0.0))
        self._reached[stage] = self._reached.get(stage, 0.0) + gain
        self._done[stage] = self._done.get(stage, 0.0) + gain

    def _rest(self) -> dict[str, float]:
        """Typical seconds that are left of all bakes, by stage."""
        rest: dict[str, float] = {}
        for number, work in enumerate(self._works[self._bake :]):
            for stage, seconds in work.items():
                left = seconds if number else max(0.0, seconds - self._reached_of(stage, seconds))
                rest[stage] = rest.get(stage, 0.0) + left
        return rest

    def _reached_of(self, stage: str, seconds: float) -> float:
        """How much of a stage of the current bake is done; all of it, where a later one has begun.

        Stages that are none of a bake's, as those of an export, come after all of them.
        """
        order = list(map(str, Stage))
        if self._stage not in order or order.index(stage) < order.index(self._stage):
            return seconds
        return self._reached.get(stage, 0.0)

    def _done_share(self) -> float:
        whole = sum(sum(work.values()) for work in self._works)
        return min(1.0, 1.0 - sum(self._rest().values()) / whole) if whole else 1.0

    def _left(self, now: float) -> float | None:
        spent = now - self._since
        if spent < _LEAST:
            return None
        pace = (spent + _PRIOR) / (sum(self._done.values()) + _PRIOR)
        left = 0.0
        for stage, seconds in self._rest().items():
            took, done = self._took.get(stage, 0.0), self._done.get(stage, 0.0)
            left += seconds * (took + _PRIOR * pace) / (done + _PRIOR)
        return left


def whole_progress(bakes: Iterable[Bake], preview: bool) -> WholeProgress:
    """The progress of a run of these bakes, in their order."""

    def work(spec: BakeSpec) -> Mapping[str, float]:
        typical = typical_seconds(BakeWork.of(spec, _TRIANGLES, preview=preview, device=spec.device))
        return {stage: typical[stage] for stage in map(str, Stage) if stage in typical}

    return WholeProgress(work(spec) for _, spec in bakes)
