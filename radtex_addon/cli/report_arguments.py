# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py report`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, fields
from pathlib import Path

from ..core.errors import InputError
from ..report.report_bake import ReportSpec
from .options import (
    DEMO,
    REPORT,
    Parser,
    ProgressStyle,
    add_device,
    add_help,
    add_least_psnr,
    add_memory,
    add_number,
    add_progress,
    command_parser,
)

_DEFAULT = ReportSpec()

_DESCRIPTION = """\
Judge a finished bake: render its object path traced, from views around it,
look the baked light up from the same places, and write one page with pictures,
figures and sizes. With --variants also say what the error comes from."""

_EPILOG = """\
examples:
  python bake.py report baked --scene room.blend
  blender -b room.blend -P bake.py -- report baked --object Vase --variants
  python bake.py report radtex --scene demo

exit codes: as of a bake, and
  3  done, but the bake is below --min-psnr"""


@dataclass(frozen=True)
class ReportRequest:
    """One report. `bake` is a folder or a sidecar; `out` is the page, None for a page beside the bake.

    `scene` is the .blend to open; None uses the file that Blender has open.
    """

    bake: Path
    object: str | None
    scene: Path | None
    demo: bool
    spec: ReportSpec
    out: Path | None
    progress: ProgressStyle
    verbose: bool
    in_scene: str | None = None
    min_psnr: float | None = None


def parse_report(arguments: list[str], inside_blender: bool) -> ReportRequest:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    found = build_parser(inside_blender).parse_args(arguments)
    if found.bake is None:
        raise InputError("which bake? name its folder, or its sidecar (--help lists everything)")
    demo = found.scene == DEMO
    if inside_blender and found.scene is not None and not demo:
        raise InputError(
            f"inside Blender the open file is looked at: open {found.scene} by blender -b {found.scene}, "
            "and leave --scene out"
        )
    if not inside_blender and found.scene is None:
        raise InputError(
            "which scene? the object is rendered again, and a bake does not know its file: "
            f"--scene FILE.blend, or --scene {DEMO} for what {DEMO} left"
        )
    out = None if found.out is None else Path(found.out)
    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out {out}: the page is an .html file")
    return ReportRequest(
        bake=Path(found.bake),
        object=found.object,
        scene=None if demo or found.scene is None else Path(found.scene),
        demo=demo,
        spec=ReportSpec(**{field.name: getattr(found, field.name) for field in fields(ReportSpec)}),
        out=out,
        progress=found.progress,
        verbose=found.verbose,
        in_scene=found.in_scene,
        min_psnr=found.min_psnr,
    )


def build_parser(inside_blender: bool) -> Parser:
    """The options of `report`, in the groups of `--help`."""
    scene = "" if inside_blender else " --scene SCENE"
    parser = command_parser(REPORT, f"DIR{scene}", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=True)
    _add_what(parser.add_argument_group("what is judged"), inside_blender)
    _add_how(parser.add_argument_group("how"))
    _add_output(parser.add_argument_group("output"))
    add_help(parser.add_argument_group("help"))
    return parser


def _add_what(group: argparse._ArgumentGroup, inside_blender: bool) -> None:
    group.add_argument("bake", nargs="?", metavar="DIR", help="the folder of a bake, or its sidecar's .json")
    group.add_argument(
        "--object",
        metavar="NAME",
        help="whose bake, if there are several in the folder: the object, or what --name has called the bake",
    )
    file = "left out: the file that Blender has open is" if inside_blender else "the .blend that was baked"
    group.add_argument("--scene", metavar="SCENE", help=f"{file}; or the word {DEMO}, for the demo's")
    group.add_argument(
        "--in-scene", metavar="NAME", help="the scene of the file (default: the one that it opens with)"
    )


def _add_how(group: argparse._ArgumentGroup) -> None:
    for field, text in (
        ("views", "path-traced pictures, from around the object"),
        ("pixels", "of a picture's side"),
        ("samples", "of a picture's pixel, before it is denoised"),
    ):
        known = getattr(_DEFAULT, field)
        add_number(group, f"--{field}", field, "N", f"{text} (default: {known})", known)
    group.add_argument(
        "--variants",
        action="store_true",
        help="bake the object again, into a temporary folder, with half of each setting, "
        "and say what that costs; takes about as long as the bake itself took",
    )
    add_device(group)
    add_memory(group, "memory that the bake may take to be read: one that needs more is refused", None)


def _add_output(group: argparse._ArgumentGroup) -> None:
    add_least_psnr(group)
    group.add_argument(
        "--out",
        metavar="FILE",
        help="the page, replaced if it is there (default: DIR/NAME.report.html)",
    )
    add_progress(group)
