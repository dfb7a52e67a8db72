# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py compare`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import InputError
from ..report.side_by_side import ComparisonSpec
from ..report.viewpoint import Viewpoint
from ..store.ownership import own_folder
from .default_folders import blend_of, default_bakes
from .options import (
    COMPARE,
    DEMO,
    Parser,
    ProgressStyle,
    add_device,
    add_help,
    add_least_psnr,
    add_memory,
    add_number,
    add_parent,
    add_progress,
    check_named,
    command_parser,
)

_DEFAULT = ComparisonSpec()

_DESCRIPTION = """\
Render one view by Cycles twice, with the objects and with their bakes in
their places, and say how they differ: two pictures of light, one of the
difference, and figures. The bakes must have been made with --save-preview.
The .blend file is never changed."""

_EPILOG = """\
examples:
  python bake.py compare room.blend --object Vase --bake baked
  blender -b room.blend -P bake.py -- compare --object Vase --bake baked
  python bake.py compare demo

exit codes: as of a bake, and
  3  done, but the bake is below --min-psnr"""


@dataclass(frozen=True)
class CompareRequest:
    """One comparison. `scene` is the .blend to open; None uses the file that Blender has open.

    `bake` is a folder or a sidecar; `eye` is None for the scene's camera. `sidecars`, if there are any, are
    those of each object's bake, None if its preview is on.
    """

    scene: Path | None
    demo: bool
    objects: tuple[str, ...]
    bake: Path
    eye: Viewpoint | None
    spec: ComparisonSpec
    out: Path
    progress: ProgressStyle
    verbose: bool
    in_scene: str | None = None
    min_psnr: float | None = None
    unsaved_images: Path | None = None
    parent_pipe: bool = False
    sidecars: tuple[Path | None, ...] = ()


def parse_compare(arguments: list[str], inside_blender: bool) -> CompareRequest:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    found = build_parser(inside_blender).parse_args(arguments)
    demo = found.scene == DEMO
    check_named(found, inside_blender, "looked at")
    blend, objects = blend_of(found, demo), tuple(dict.fromkeys(found.object or ()))
    return CompareRequest(
        scene=None if demo or found.scene is None else Path(found.scene),
        demo=demo,
        objects=objects,
        bake=default_bakes(blend, objects) if found.bake is None else Path(found.bake),
        eye=_eye(found.view, found.window),
        spec=ComparisonSpec(found.pixels, found.samples, found.device, found.memory_mb),
        out=own_folder(blend) if found.out is None else Path(found.out),
        progress=found.progress,
        verbose=found.verbose,
        in_scene=found.in_scene,
        min_psnr=found.min_psnr,
        parent_pipe=found.parent_pipe,
    )


def _eye(view: list[float] | None, window: list[float] | None) -> Viewpoint | None:
    if view is None and window is None:
        return None
    if view is None or window is None:
        raise InputError("a view is two matrices: give --view and --window, or leave both out")
    return Viewpoint.of_view(_rows(view), _rows(window))


def _rows(numbers: list[float]) -> list[list[float]]:
    return [numbers[first : first + 4] for first in range(0, 16, 4)]


def _matrix(word: str) -> list[float]:
    try:
        numbers = [float(number) for number in word.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 16:
        raise InputError(f"{word}: give a matrix as 16 numbers, row by row, with commas between them")
    return numbers


def build_parser(inside_blender: bool) -> Parser:
    """The options of `compare`, in the groups of `--help`."""
    scene = "" if inside_blender else "SCENE "
    parser = command_parser(
        COMPARE, f"{scene}--object NAME", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=True
    )
    _add_what(parser.add_argument_group("what is compared"), inside_blender)
    _add_how(parser.add_argument_group("how"))
    _add_output(parser.add_argument_group("output"))
    add_parent(parser.add_argument_group("for a program that runs this one"))
    add_help(parser.add_argument_group("help"))
    return parser


def _add_what(group: argparse._ArgumentGroup, inside_blender: bool) -> None:
    file = "left out: the file that Blender has open is" if inside_blender else "the .blend that was baked"
    group.add_argument(
        "scene", nargs="?", metavar="SCENE", help=f"{file}; or the word {DEMO}, for the demo's"
    )
    group.add_argument(
        "--object", action="append", metavar="NAME", help="a baked object; may be given several times"
    )
    group.add_argument(
        "--in-scene", metavar="NAME", help="the scene of the file (default: the one that it opens with)"
    )
    group.add_argument(
        "--bake",
        metavar="DIR",
        help="the folder of the bakes, or a sidecar's .json; not needed for objects whose preview is shown "
        "in the file (default: radtex/NAME beside NAME.blend, or radtex, whichever has them)",
    )


def _add_how(group: argparse._ArgumentGroup) -> None:
    for flag, text in (
        ("--view", "from world space to the viewer's, who looks along -z (default: the scene's camera's)"),
        ("--window", "the projection that belongs to it, as OpenGL has it"),
    ):
        group.add_argument(
            flag, type=_matrix, metavar="MATRIX", help=f"{text}: 16 numbers, row by row, as {flag}=1,0,..."
        )
    for field, text in (
        ("pixels", "along the pictures' longer side"),
        ("samples", "of a picture's pixel, before it is denoised"),
    ):
        known = getattr(_DEFAULT, field)
        add_number(group, f"--{field}", field, "N", f"{text} (default: {known})", known)
    add_device(group)
    add_memory(group, "memory that bakes may take to be shown: those that need more are refused", None)


def _add_output(group: argparse._ArgumentGroup) -> None:
    add_least_psnr(group)
    group.add_argument(
        "--out",
        metavar="DIR",
        help="folder for NAME.traced.exr, NAME.baked.exr and NAME.difference.png, which are replaced "
        "(default: radtex/NAME beside NAME.blend; without a file, radtex)",
    )
    add_progress(group)
