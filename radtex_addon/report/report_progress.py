# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of a running report."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeVar

from ..bake.progress import Progress, Stage, relayed

_Result = TypeVar("_Result")


class ReportTask(StrEnum):
    """The tasks of a report itself; its bakes also go through a bake's stages."""

    FIND_MESH = "find mesh"
    FIND_VIEWS = "find views"
    REFERENCE = "reference"
    COMPARE = "compare"
    PAGE = "page"


@dataclass(frozen=True)
class ReportStep:
    """`done` of `total` units are finished; `about` is the variant being baked, "" for the bake itself."""

    stage: ReportTask | Stage
    done: int
    total: int
    about: str = ""


def steps_of(
    steps: Generator[Progress, None, _Result], about: str = ""
) -> Generator[ReportStep, None, _Result]:
    """Convert a bake's progress to steps; closing this generator closes the bake's."""
    return relayed(steps, lambda step: ReportStep(step.stage, step.done, step.total, about))
