# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of a job: plain data, which a panel draws and events change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from ..bake.progress import Stage
from ..bake.spec import BakeSpec, Layout
from .order import Order

# How long stages take, in parts of the whole: roughly, for a bar that runs evenly enough.
_SHARES = {
    Stage.EVALUATE: 1,
    Stage.UNWRAP: 5,
    Stage.RASTER: 2,
    Stage.PROBE: 4,
    Stage.CAPTURE: 80,
    Stage.FILL: 2,
    Stage.FIT: 30,
    Stage.CONDENSE: 60,
    Stage.WRITE: 3,
    Stage.PREVIEW: 2,
}


class State(StrEnum):
    """How far a job is; the last three are for good."""

    WAITING = "waiting"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


@dataclass(frozen=True)
class Job:
    """One bake of a queue: what was ordered, and what is known of it.

    `stage` is None until the worker is ready to bake. `fraction` is of the whole bake, 0 to 1, and never
    falls. `seconds_left` is a guess, None while there is none. `message` is one line: what a bake made, or
    why it failed. `picture` is the latest picture of what is baked so far. `files` are there when it is done,
    and `facts` are all that the worker said then.
    """

    number: int
    object: str
    spec: BakeSpec
    out: Path
    preview: bool
    state: State = State.WAITING
    cancelling: bool = False
    stage: Stage | None = None
    fraction: float = 0.0
    seconds_left: float | None = None
    message: str = ""
    warnings: tuple[str, ...] = ()
    picture: Path | None = None
    files: tuple[Path, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, number: int, order: Order) -> Job:
        """A job that waits."""
        return cls(number, order.object, order.spec, order.out, order.preview is not None)

    @property
    def ended(self) -> bool:
        """Whether nothing will change any more."""
        return self.state not in (State.WAITING, State.RUNNING)

    def hears(self, event: Mapping[str, Any]) -> Job:
        """What is known after the worker said `event`; of what it does not know it learns nothing."""
        match event.get("event"):
            case "progress":
                return self._progressed(
                    Stage(event["stage"]), event["done"], event["total"], event["seconds_left"]
                )
            case "warning":
                return replace(self, warnings=(*self.warnings, str(event["message"])))
            case "picture":
                return replace(self, picture=Path(event["path"]))
            case "done":
                files = tuple(Path(path) for path in event["files"])
                return replace(self, files=files, message=str(event["summary"]), facts=event)
        return self

    def ends(self, state: State, message: str) -> Job:
        """The job when its worker is gone; an empty message leaves the one that is there."""
        whole = 1.0 if state is State.DONE else self.fraction
        return replace(self, state=state, fraction=whole, seconds_left=None, message=message or self.message)

    def _progressed(self, stage: Stage, done: int, total: int, left: float | None) -> Job:
        shares = _shares(self.spec, self.preview)
        here, order = shares.get(stage, 0.0), list(Stage)
        past = sum(share for other, share in shares.items() if order.index(other) < order.index(stage))
        part = done / total if total else 1.0
        seconds = self.seconds_left
        if left is not None and done < total and here:
            rest = 1.0 - past - here
            seconds = left + rest / here * left / (1.0 - part)
        fraction = max(self.fraction, min(past + here * part, 1.0))
        return replace(self, stage=stage, fraction=fraction, seconds_left=seconds)


def _shares(spec: BakeSpec, preview: bool) -> dict[Stage, float]:
    """The part of each stage that such a bake goes through; together 1."""
    absent = {Stage.FILL} if spec.layout is Layout.SHARED else {Stage.FIT}
    if not spec.condensed:
        absent.add(Stage.CONDENSE)
    if not preview:
        absent.add(Stage.PREVIEW)
    present = {stage: share for stage, share in _SHARES.items() if stage not in absent}
    return {stage: share / sum(present.values()) for stage, share in present.items()}
