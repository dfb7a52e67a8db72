# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of a job: plain data, which a panel draws and events change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from .order import Order, Work


class State(StrEnum):
    """How far a job is; the last three are for good."""

    WAITING = "waiting"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


@dataclass(frozen=True)
class Job:
    """One order of a queue, and what is known of it.

    `stage` is None until the worker is at one. `fraction` is of the whole, 0 to 1, and never falls.
    `seconds_left` is a guess, None while there is none. `message` is one line: what was made, or why that
    failed. `picture` is the latest picture of what is done so far. `files` are there when it is done, and
    `facts` are all that the worker said then.
    """

    number: int
    order: Order
    state: State = State.WAITING
    cancelling: bool = False
    stage: str | None = None
    fraction: float = 0.0
    seconds_left: float | None = None
    message: str = ""
    warnings: tuple[str, ...] = ()
    picture: Path | None = None
    files: tuple[Path, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def work(self) -> Work:
        """What is done."""
        return self.order.work

    @property
    def object(self) -> str:
        """Whom it is about."""
        return self.order.object

    @property
    def out(self) -> Path:
        """Where its files appear."""
        return self.order.out

    @property
    def ended(self) -> bool:
        """Whether nothing will change any more."""
        return self.state not in (State.WAITING, State.RUNNING)

    def hears(self, event: Mapping[str, Any]) -> Job:
        """What is known after the worker said `event`; of what it does not know it learns nothing."""
        match event.get("event"):
            case "progress":
                return self._progressed(event["stage"], event["done"], event["total"], event["seconds_left"])
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

    def _progressed(self, stage: str, done: int, total: int, left: float | None) -> Job:
        here, past = self.order.stages.get(stage, 0.0), self._past(stage)
        part = done / total if total else 1.0
        seconds = self.seconds_left
        if left is not None and done < total and here:
            rest = 1.0 - past - here
            seconds = left + rest / here * left / (1.0 - part)
        fraction = max(self.fraction, min(past + here * part, 1.0))
        return replace(self, stage=stage, fraction=fraction, seconds_left=seconds)

    def _past(self, stage: str) -> float:
        """The part that lies before a stage; nothing before one that nobody foresaw."""
        stages = list(self.order.stages)
        before = stages[: stages.index(stage)] if stage in stages else []
        return sum(self.order.stages[other] for other in before)
