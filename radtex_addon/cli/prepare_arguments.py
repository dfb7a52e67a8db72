# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py prepare`: a bake's options, except those that apply while it renders."""

from __future__ import annotations

from ..core.errors import InputError
from .arguments import AUTO, Request, read_request
from .bake_arguments import add_bake_options
from .options import PREPARE, Parser, command_parser

_DESCRIPTION = """\
Prepare a bake for a render farm: do all of it up to the first ray, and write
the folder DIR/NAME.KIND.radtex-farm. Frame 1, 2, ... of the farm.blend in it
render one sheet of the atlas each, by any Blender of the same version,
without RadTex, into frames/. Beside it lie templates for OpenJD and Flamenco,
and a runner for the bpy module. The .blend file is never changed."""

_EPILOG = """\
examples:
  python bake.py prepare room.blend --object Vase --out baked
  blender -b baked/Vase.radiance.radtex-farm/farm.blend -a
  python bake.py assemble baked/Vase.radiance.radtex-farm

exit codes: as of a bake"""


def parse_prepare(arguments: list[str], inside_blender: bool) -> Request:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    request = read_request(build_parser(inside_blender).parse_args(arguments), inside_blender)
    bakes = request.bakes
    if bakes.as_scene:
        raise InputError(
            "--all makes several atlases, and a farm one: name objects, and an atlas by --together"
        )
    if bakes.assets:
        raise InputError(f"--together {AUTO}: a farm makes one atlas: name it, such as --together Furniture")
    for count, what in ((len(bakes.names), "object"), (len(bakes.frames), "frame")):
        if count > 1:
            raise InputError(f"a farm makes one atlas: prepare {count} of them, one for each {what}")
    return request


def build_parser(inside_blender: bool) -> Parser:
    """The options of `prepare`, in the groups of `--help`."""
    scene = "" if inside_blender else "SCENE "
    parser = command_parser(
        PREPARE, f"{scene}--object NAME", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=True
    )
    add_bake_options(parser, inside_blender, course=False)
    return parser
