# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py prepare`: a bake's options, except those that apply while it renders."""

from __future__ import annotations

from .arguments import Request, read_request
from .bake_arguments import add_bake_options
from .options import PREPARE, Parser, command_parser

_DESCRIPTION = """\
Prepare bakes for a render farm: write the folder DIR/NAME.radtex-farm with a
copy of the scene, and with tasks of about a minute. Any machine that has
RadTex does any of them: bake.py work. Beside them lie templates for OpenJD,
Flamenco, Slurm and make.

With --layout buckets one atlas goes to machines without RadTex: frame 1, 2,
... of the farm.blend render one sheet of the atlas each, by any Blender of
the same version, into frames/, or by the bpy module with the runner beside
it. The .blend file is never changed."""

_EPILOG = """\
examples:
  python bake.py prepare room.blend --all --out baked
  python bake.py work baked/room.radtex-farm
  python bake.py assemble baked/room.radtex-farm
  python bake.py prepare room.blend --object Vase --layout buckets --out baked
  blender -b baked/Vase.radiance.radtex-farm/farm.blend -a
  python bake.py assemble baked/Vase.radiance.radtex-farm

exit codes: as of a bake"""


def parse_prepare(arguments: list[str], inside_blender: bool) -> Request:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    return read_request(build_parser(inside_blender).parse_args(arguments), inside_blender)


def build_parser(inside_blender: bool) -> Parser:
    """The options of `prepare`, in the groups of `--help`."""
    scene = "" if inside_blender else "SCENE "
    parser = command_parser(
        PREPARE, f"{scene}--object NAME", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=True
    )
    add_bake_options(parser, inside_blender, course=False)
    return parser
