# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py assemble`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from ..settings.options import OPTIONS
from ..textures.export_spec import Target
from .bake_arguments import add_options
from .options import (
    ASSEMBLE,
    Parser,
    ProgressStyle,
    add_help,
    add_parent,
    add_progress,
    command_parser,
)

_DESCRIPTION = """\
Join what a farm's machines have made of what bake.py prepare wrote. All of it
is checked first: tasks that are not done, and frames that are missing, damaged
or foreign, are named, with the command that does just those, and nothing is
written then. Nothing is rendered here."""

_EPILOG = """\
examples:
  python bake.py assemble baked/Vase.radiance.radtex-farm
  python bake.py assemble baked/Vase.radiance.radtex-farm --out final --export web

exit codes: as of a bake; 1 where tasks are left or frames are not as they should be"""


@dataclass(frozen=True)
class AssembleRequest:
    """Parsed arguments: `farm` is the folder; `out` is None for the folder that contains it."""

    farm: Path
    out: Path | None
    overwrite: bool
    exports: tuple[Target, ...]
    progress: ProgressStyle
    verbose: bool
    parent_pipe: bool = False
    overwrite_any: bool = False
    done: bool = False


def parse_assemble(arguments: list[str], inside_blender: bool) -> AssembleRequest:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    found = build_parser(inside_blender).parse_args(arguments)
    return AssembleRequest(
        farm=Path(found.farm),
        out=None if found.out is None else Path(found.out),
        overwrite=found.overwrite or found.overwrite_any,
        overwrite_any=found.overwrite_any,
        exports=tuple(dict.fromkeys(found.exports or ())),
        progress=found.progress,
        verbose=found.verbose,
        parent_pipe=found.parent_pipe,
        done=found.done,
    )


def build_parser(inside_blender: bool) -> Parser:
    """The options of `assemble`, in the groups of `--help`."""
    parser = command_parser(ASSEMBLE, "DIR", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=False)
    what = parser.add_argument_group("what is joined")
    what.add_argument("farm", metavar="DIR", help="the folder that bake.py prepare wrote")
    what.add_argument(
        "--done",
        action="store_true",
        help="of a farm of tasks join the bakes whose tasks are all done, and name what is left of the "
        "others, instead of joining none",
    )
    output = parser.add_argument_group("output")
    output.add_argument(
        "--out", metavar="DIR", help="folder for the files, made if need be (default: where the farm's lies)"
    )
    exports = "also make DIR/NAME.TARGET, as bake.py export --to TARGET does; may be given several times; "
    exports += "needs --save-preview where the farm was prepared"
    rows = (OPTIONS["overwrite"], OPTIONS["overwrite_any"], replace(OPTIONS["exports"], help=exports))
    add_options(output, rows)
    add_progress(output)
    add_parent(parser.add_argument_group("for a program that runs this one"))
    add_help(parser.add_argument_group("help"))
    return parser
