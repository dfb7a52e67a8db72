# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py work`, where it does tasks of a farm."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..worker.order import WORK
from .options import Parser, ProgressStyle, add_help, add_parent, add_progress, command_parser

_DESCRIPTION = """\
Do tasks of the farm that bake.py prepare wrote into DIR, on any machine that
has RadTex, the same version of Blender, and the folder. Without a TASK all
that are left are done, one after another, beside other machines that do the
same: each takes what nobody does. A task may be done twice, or at once on two
machines; what it makes appears whole or not at all."""

_EPILOG = """\
examples:
  python bake.py work baked/room.radtex-farm
  python bake.py work baked/room.radtex-farm Vase.light.2 Vase.light.3

exit codes: as of a bake; 2 where a task needs what is not done yet"""


@dataclass(frozen=True)
class TaskRequest:
    """Tasks of the farm in `folder`, by name; all that are left if none is named."""

    folder: Path
    tasks: tuple[str, ...]
    progress: ProgressStyle
    verbose: bool
    parent_pipe: bool


def is_of_tasks(arguments: list[str]) -> bool:
    """Whether `bake.py work` is asked for tasks of a farm, and not by the panel's order, a file."""
    return len(arguments) != 1 or arguments[0].startswith("-") or not Path(arguments[0]).is_file()


def parse_tasks(arguments: list[str], inside_blender: bool) -> TaskRequest:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    found = build_parser(inside_blender).parse_args(arguments)
    return TaskRequest(
        folder=Path(found.farm),
        tasks=tuple(dict.fromkeys(found.tasks)),
        progress=found.progress,
        verbose=found.verbose,
        parent_pipe=found.parent_pipe,
    )


def build_parser(inside_blender: bool) -> Parser:
    """The options of `work`, in the groups of `--help`."""
    parser = command_parser(WORK, "DIR [TASK ...]", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=False)
    what = parser.add_argument_group("what is done")
    what.add_argument("farm", metavar="DIR", help="the folder that bake.py prepare wrote")
    what.add_argument("tasks", metavar="TASK", nargs="*", help="tasks by name, as in DIR/tasks.json")
    add_progress(parser.add_argument_group("output"))
    add_parent(parser.add_argument_group("for a program that runs this one"))
    add_help(parser.add_argument_group("help"))
    return parser
