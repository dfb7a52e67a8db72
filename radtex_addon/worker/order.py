# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker is asked for: what is run, and what is told of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TypeVar

_Stage = TypeVar("_Stage", bound=str)

_BAKE = Path(__file__).resolve().parents[2] / "bake.py"


@dataclass(frozen=True)
class Program:
    """What runs `bake.py`: Blender, or a Python that has the bpy module.

    `paths` are folders of modules that Blender does not find by itself, as those of an extension's wheels.
    """

    binary: str
    is_blender: bool
    paths: tuple[str, ...] = ()


@dataclass(frozen=True)
class Handover:
    """A scene as it was at one moment, in a folder of its own.

    `images` holds the pixels that were painted and not saved, if there are any; `device` is what `auto`
    means in the session; `stalled` is how long the session stood still, in seconds.
    """

    folder: Path
    blend: Path
    scene: str
    images: Path | None
    device: str
    stalled: float


class Work(StrEnum):
    """What a worker can do."""

    BAKE = "bake"
    EXPORT = "export"
    COMPARISON = "comparison"


@dataclass(frozen=True)
class Order:
    """One run of `bake.py`, and what is told of it.

    `object` says whom it is about, `part` which part of it, `variant` which frame or light, and `about` what
    else tells it from others. In `folder` the worker works; it goes away with the last of its orders. In
    `out` the run's files appear. `command` is the first of its words, empty for a bake; then come the `blend`
    to open, if there is one, and `arguments`. `stages` are all that it may speak of, in order, each with its
    part of the whole, 0 for one that it does not go through. `remedy` is what to do when it ended early.
    `shared` are the objects of an atlas that several share, which `object` is then the name of.
    """

    work: Work
    object: str
    folder: Path
    out: Path
    arguments: tuple[str, ...]
    stages: Mapping[str, float]
    remedy: str
    about: str = ""
    part: str = ""
    variant: str = ""
    shared: tuple[str, ...] = ()
    command: str = ""
    blend: Path | None = None

    def ended_early(self, reason: str) -> str:
        """What to tell of a run that ended without a word of its own."""
        return f"the {self.work} ended early ({reason}): {self.remedy}"


def parts(shares: Mapping[_Stage, float]) -> dict[str, float]:
    """Stages by how long they take roughly, made parts of 1."""
    whole = sum(shares.values())
    return {str(stage): share / whole for stage, share in shares.items()}


def command_line(program: Program, order: Order) -> list[str]:
    """The command line of the worker, which runs no script that lies in the .blend."""
    command = [order.command] if order.command else []
    blend = [str(order.blend)] if order.blend is not None else []
    if not program.is_blender:
        return [program.binary, str(_BAKE), *command, *blend, *order.arguments]
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
        *blend,
        "--python-expr",
        find,
        "--python",
        str(_BAKE),
        "--",
        *command,
        *order.arguments,
    ]
