# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the batch understands."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, fields, replace
from pathlib import Path

from ..bake.spec import BakeSpec
from ..core.errors import InputError
from ..core.sampler import Filter
from ..export.kinds import check_target
from ..export.spec import Target
from .bake_arguments import add_how, add_output, add_quality, add_what
from .options import (
    COMPARE,
    DEMO,
    EXPORT,
    REPORT,
    Parser,
    ProgressStyle,
    add_help,
    add_parent,
)

_DESCRIPTION = """\
Bake radiance textures with Cycles: every texel of an object gets a bucket, a
small picture of the light that leaves it, with a cell for each direction.

For each object, writes DIR/NAME.KIND.exr, the atlas of all buckets, and
DIR/NAME.KIND.json, which describes it; in the shared layout several images,
DIR/NAME.KIND.LAYER.exr. The .blend file is never changed."""

_EPILOG = """\
examples:
  python bake.py room.blend --object Vase --out baked --save-preview
  blender -b room.blend -P bake.py -- --object Vase --object Lamp --samples 64
  python bake.py demo
  python bake.py report radtex --scene demo
  python bake.py export radtex --to web
  python bake.py compare room.blend --object Vase --bake baked

exit codes:
  0  done
  1  the bake failed
  2  the request, or a file that it names, is wrong
  130  interrupted (Ctrl-C, or SIGTERM)"""


@dataclass(frozen=True)
class Request:
    """One run of the batch. `scene` is the .blend to open; None bakes the file that Blender has open."""

    scene: Path | None
    demo: bool
    objects: tuple[str, ...]
    spec: BakeSpec
    out: Path
    preview: Filter | None
    overwrite: bool
    progress: ProgressStyle
    verbose: bool
    resume: bool = False
    thumbnail: Path | None = None
    exports: tuple[Target, ...] = ()
    in_scene: str | None = None
    unsaved_images: Path | None = None
    parent_pipe: bool = False
    frames: tuple[int, ...] = ()

    @property
    def specs(self) -> tuple[BakeSpec, ...]:
        """What is baked of each object: each of the frames, or the one that the file opens with."""
        return tuple(replace(self.spec, frame=frame) for frame in self.frames) or (self.spec,)


def parse(arguments: list[str], inside_blender: bool) -> Request:
    """Read a command line. Raises InputError; `--help` and `--version` print and raise SystemExit(0)."""
    found = _parser(inside_blender).parse_args(arguments)
    demo = found.scene == DEMO
    if not inside_blender and found.scene is None:
        raise InputError(f"which file? give a .blend, or the word {DEMO} (--help lists everything)")
    if not demo and not found.object:
        raise InputError("which object? name it: --object NAME (--help lists everything)")
    if inside_blender and found.scene not in (None, DEMO):
        raise InputError(
            f"inside Blender the open file is baked: open {found.scene} by blender -b {found.scene}, "
            f"and leave it out after the --"
        )
    chosen = {
        field.name: getattr(found, field.name) for field in fields(BakeSpec) if hasattr(found, field.name)
    }
    chosen["layers"] = tuple(found.layers or ())
    if found.frames:
        chosen["frame"] = found.frames[0]
        if len(found.frames) > 1 and found.unwrap_at is None and found.uv_layer is None:
            chosen["unwrap_at"] = found.frames[0]
    if found.exports and not (found.save_preview or demo):
        raise InputError("--export is made from the preview: give --save-preview too")
    spec = BakeSpec(**chosen)
    for target in found.exports or ():
        check_target("the bake", spec.kind, target)
    return Request(
        scene=None if demo or found.scene is None else Path(found.scene),
        demo=demo,
        objects=tuple(dict.fromkeys(found.object or ())),
        spec=spec,
        out=Path(found.out),
        preview=found.filter if found.save_preview or demo else None,
        overwrite=found.overwrite or demo,
        progress=found.progress,
        verbose=found.verbose,
        resume=found.resume,
        thumbnail=None if found.thumbnail is None else Path(found.thumbnail),
        exports=tuple(dict.fromkeys(found.exports or ())),
        in_scene=found.in_scene,
        unsaved_images=None if found.unsaved_images is None else Path(found.unsaved_images),
        parent_pipe=found.parent_pipe,
        frames=found.frames,
    )


def _parser(inside_blender: bool) -> Parser:
    program = "blender -b SCENE -P bake.py --" if inside_blender else "bake.py"
    scene = "" if inside_blender else "SCENE "
    parser = Parser(
        prog=program,
        usage=f"{program} {scene}--object NAME [options]\n       {program} {DEMO} [options]\n       "
        f"{program} {REPORT} DIR [options]\n       {program} {EXPORT} DIR --to TARGET [options]\n       "
        f"{program} {COMPARE} {scene}--object NAME [options]",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    add_what(parser.add_argument_group("what is baked"), inside_blender)
    add_quality(parser.add_argument_group("quality"))
    add_how(parser.add_argument_group("how"))
    add_output(parser.add_argument_group("output"))
    add_parent(parser.add_argument_group("for a program that runs this one"), of_scene=True)
    add_help(parser.add_argument_group("help"))
    return parser
