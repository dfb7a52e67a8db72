# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stages of a farm beside those of a bake."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from ..bake.progress import Progress


class FarmTask(StrEnum):
    """Work before the frames are rendered, and after."""

    HOLD = "hold"
    CHECK = "check"


@dataclass(frozen=True)
class FarmStep:
    """`done` of `total` units of a task are finished."""

    stage: FarmTask
    done: int
    total: int


AnyStep = Progress | FarmStep
