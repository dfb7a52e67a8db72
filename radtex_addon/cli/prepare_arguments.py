# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py prepare`: a bake's options, except those that apply while it renders."""

from __future__ import annotations

from dataclasses import replace

from .arguments import Request, read_request
from .bake_arguments import add_bake_options
from .options import PREPARE, Parser, command_parser

_DESCRIPTION = """\
Prepare bakes for a render farm: write the folder DIR/NAME.radtex-farm with a
copy of the scene, and with tasks of about a minute. Any machine that has
RadTex does any of them: bake.py work. Beside them lie templates for OpenJD,
Flamenco, Slurm and make.

With --stock-frames most of the paths of layered bakes become frames, which
machines with nothing but Blender render: frames/KEY.light.blend and
frames/KEY.ends.blend of each bake. Machines with RadTex do the rest.

With --layout buckets one atlas goes to machines without RadTex: frame 1, 2,
... of the farm.blend render one sheet of the atlas each, by any Blender of
the same version, into frames/, or by the bpy module with the runner beside
it. The .blend file is never changed."""

_EPILOG = """\
examples:
  python bake.py prepare room.blend --all --out baked
  python bake.py work baked/room.radtex-farm
  python bake.py assemble baked/room.radtex-farm
  python bake.py prepare room.blend --object Vase --stock-frames --out baked
  blender -b baked/Vase.radiance.radtex-farm/frames/Vase.light.blend -a
  blender -b baked/Vase.radiance.radtex-farm/frames/Vase.ends.blend -a
  python bake.py work baked/Vase.radiance.radtex-farm
  python bake.py prepare room.blend --object Vase --layout buckets --out baked
  blender -b baked/Vase.radiance.radtex-farm/farm.blend -a
  python bake.py assemble baked/Vase.radiance.radtex-farm

exit codes: as of a bake"""


def parse_prepare(arguments: list[str], inside_blender: bool) -> Request:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    found = build_parser(inside_blender).parse_args(arguments)
    return replace(read_request(found, inside_blender), stock_frames=found.stock_frames)


def build_parser(inside_blender: bool) -> Parser:
    """The options of `prepare`, in the groups of `--help`."""
    scene = "" if inside_blender else "SCENE "
    parser = command_parser(
        PREPARE, f"{scene}--object NAME", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=True
    )
    farm = parser.add_argument_group("what machines of the farm need")
    farm.add_argument(
        "--stock-frames",
        action="store_true",
        help="also write .blends for machines with nothing but Blender, whose frames are most of the paths "
        "of bakes in the layered layout; maps are made at once, which takes a while",
    )
    add_bake_options(parser, inside_blender, course=False)
    return parser
