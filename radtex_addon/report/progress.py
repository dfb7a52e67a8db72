# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a running report says of itself."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeVar

from ..bake.progress import Progress, Stage, relayed

_Result = TypeVar("_Result")


class Task(StrEnum):
    """What a report does itself; it also goes through a bake's stages."""

    FIND_MESH = "find mesh"
    FIND_VIEWS = "find views"
    REFERENCE = "reference"
    COMPARE = "compare"
    PAGE = "page"


@dataclass(frozen=True)
class Step:
    """`done` of `total` units are finished; `about` names the variant in hand, "" for the bake itself."""

    stage: Task | Stage
    done: int
    total: int
    about: str = ""


def steps_of(steps: Generator[Progress, None, _Result], about: str = "") -> Generator[Step, None, _Result]:
    """Pass a bake's steps on; closed with it."""
    return relayed(steps, lambda step: Step(step.stage, step.done, step.total, about))
