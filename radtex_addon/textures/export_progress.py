# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of a running export."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Task(StrEnum):
    """The tasks of an export, in order."""

    TEXTURES = "textures"
    FLAT = "flat"
    MESH = "mesh"
    PACK = "pack"


@dataclass(frozen=True)
class Step:
    """`done` of `total` units of a task are finished."""

    stage: Task
    done: int
    total: int
