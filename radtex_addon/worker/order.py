# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An order for a worker: what to run, and how the panel describes it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from tempfile import mkstemp
from typing import Any, TypeVar

from ..core.quoting import quoted
from ..formats.json_reader import json_text
from ..settings.estimate import Estimate
from ..settings.time_left import Course

_Stage = TypeVar("_Stage", bound=str)

WORK = "work"  # the command of `bake.py` that does what an order says
_BAKE = Path(__file__).resolve().parents[2] / "bake.py"


@dataclass(frozen=True)
class Program:
    """The program that runs `bake.py`: Blender, or a Python with the bpy module.

    `paths` are folders of modules that Blender does not find itself, such as an extension's wheels.
    """

    binary: str
    is_blender: bool
    paths: tuple[str, ...] = ()


@dataclass(frozen=True)
class Handover:
    """A copy of the session's scene in a folder of its own.

    `images` is a folder with painted pixels that were not saved, if there are any; `device` is what `auto`
    means in the session; `stalled` is how long saving blocked the window, in seconds. `original` is the path
    of the session's file, `Path()` if it was never saved.
    """

    folder: Path
    blend: Path
    scene: str
    images: Path | None
    device: str
    stalled: float
    original: Path = Path()


class Work(StrEnum):
    """The kinds of work."""

    BAKE = "bake"
    EXPORT = "export"
    COMPARISON = "comparison"
    ESTIMATE = "estimate"
    PREPARATION = "preparation"
    ASSEMBLY = "assembly"


@dataclass(frozen=True)
class Order:
    """One run of `bake.py`, and how the panel describes it.

    `object` is the object's or the shared atlas's name, `called` what a bake's files are called if not so,
    `part` the part of it, `variant` the frame or lamps, and `about` tells the job from others of the same
    object (kind, or export target). `shared` are the objects of a shared atlas. `folder` has the worker's own
    files; it is deleted with the last of its orders. `out` is the folder of the results. `blend` is the file
    to open, if any; `facts` is the rest of the order, as JSON's types. `stages` are the stages that the
    worker may report, in order, each with its fraction of the whole time, 0 for one that this order skips;
    `seconds` is how long all of it typically takes, and `expected` of a bake what each stage takes and how
    sure that is. `remedy` is what to do if the worker ends early.
    """

    work: Work
    object: str
    folder: Path
    out: Path
    facts: Mapping[str, Any]
    stages: Mapping[str, float]
    remedy: str
    about: str = ""
    part: str = ""
    variant: str = ""
    shared: tuple[str, ...] = ()
    called: str = ""
    seconds: float = 1.0
    expected: Estimate | None = None
    blend: Path | None = None

    @property
    def course(self) -> Course:
        """How the job goes, before it has begun."""
        stages = {stage: share * self.seconds for stage, share in self.stages.items() if share}
        return Course(Estimate(stages) if self.expected is None else self.expected)

    def ended_early(self, reason: str) -> str:
        """The message for a worker that ended without reporting an error."""
        return f"the {self.work} ended early ({reason}): {self.remedy}"


def parts(shares: Mapping[_Stage, float]) -> dict[str, float]:
    """Scale the stages' rough durations to fractions that add up to 1."""
    whole = sum(shares.values())
    return {str(stage): share / whole for stage, share in shares.items()}


def write_order(order: Order) -> Path:
    """Write what a worker reads, for `command_line`, into the order's folder. Raises OSError."""
    blend = None if order.blend is None else str(order.blend)
    text = json_text({"work": order.work, "blend": blend, **order.facts})
    descriptor, name = mkstemp(prefix="order-", suffix=".json", dir=order.folder)
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        file.write(text)
    return Path(name)


def farm_command(program: Program, farm: Path) -> str:
    """What to type to do the tasks of a farm that are left, by a program such as the one that runs RadTex."""
    by = ["blender", "-b", "-P", str(_BAKE), "--"] if program.is_blender else ["python", str(_BAKE)]
    return quoted([*by, WORK, str(farm)])


def command_line(program: Program, order: Order, file: Path) -> list[str]:
    """The command line of a worker for the order that is in `file`; it runs no script of the .blend."""
    if not program.is_blender:
        return [program.binary, str(_BAKE), WORK, str(file)]
    find = f"import sys; sys.path += [path for path in {program.paths!a} if path not in sys.path]"
    options = [
        "--background",
        "--factory-startup",
        "--disable-autoexec",
        "-noaudio",
        "--python-exit-code",
        "1",
    ]
    return [
        program.binary,
        *options,
        *([] if order.blend is None else [str(order.blend)]),
        "--python-expr",
        find,
        "--python",
        str(_BAKE),
        "--",
        WORK,
        str(file),
    ]
