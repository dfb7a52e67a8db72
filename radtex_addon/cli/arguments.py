# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of a bake from the command line."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, fields, replace
from pathlib import Path

from ..core.errors import InputError
from ..core.messages import Setting, do
from ..job import OpenLayout
from ..job.bake_request import BakeRequest
from ..scene.demo import OBJECT
from ..settings.cost import check_memory
from ..settings.spec import BakeSpec, Layout
from ..settings.targets import check_target
from ..store.ownership import own_folder
from ..textures.export_spec import Target
from .bake_arguments import add_bake_options
from .default_folders import blend_of, former_folders
from .light_options import lit, parse_lights
from .options import (
    ASSEMBLE,
    COMPARE,
    DEMO,
    EXPORT,
    PREPARE,
    REPORT,
    Parser,
    ProgressStyle,
    check_named,
)

AUTO = "auto"  # in place of an atlas's name: objects that touch share one
_LAST_PORT = 65535

_DESCRIPTION = """\
Bake radiance textures with Cycles: every texel of an object gets a bucket, a
small picture of the light that leaves it, with a cell for each direction.

Radiance is kept in the layered layout where that goes: DIR/NAME.KIND.LAYER.exr.
Layout buckets writes DIR/NAME.KIND.exr, the atlas of all buckets.
DIR/NAME.KIND.json describes either. The .blend file is never changed."""

_EPILOG = """\
examples:
  python bake.py room.blend --object Vase --out baked --save-preview
  python bake.py room.blend --all --out baked --save-preview
  blender -b room.blend -P bake.py -- --object Vase --object Lamp --samples 64
  python bake.py demo
  python bake.py report radtex --scene demo
  python bake.py export radtex --to web
  python bake.py compare room.blend --object Vase --bake baked
  python bake.py prepare room.blend --object Vase --out baked
  python bake.py assemble baked/Vase.radiance.radtex-farm

exit codes:
  0  done
  1  the bake failed
  2  the request, or a file that it names, is wrong
  130  interrupted (Ctrl-C, or SIGTERM)"""


@dataclass(frozen=True)
class Request:
    """One bake run. `scene` is the .blend to open; None bakes the file that Blender has open.

    `passes` fold samples into one atlas; `serve` is the port at which the web page is served meanwhile. With
    a `thumbnail` a bake also draws its UV map, in the file `map_picture`, if that is given. The meshes of
    `collections` are baked, too, or `everything` that renders. With `export_again`, exports follow that the
    .blend keeps of these bakes. A farm that is prepared has `stock_frames` for machines without RadTex.
    """

    scene: Path | None
    demo: bool
    bakes: BakeRequest
    progress: ProgressStyle
    verbose: bool
    thumbnail: Path | None = None
    map_picture: Path | None = None
    in_scene: str | None = None
    unsaved_images: Path | None = None
    parent_pipe: bool = False
    passes: int = 1
    serve: int | None = None
    collections: tuple[str, ...] = ()
    everything: bool = False
    export_again: bool = False
    stock_frames: bool = False


def parse(arguments: list[str], inside_blender: bool) -> Request:
    """Parse a command line. Raises InputError; `--help` and `--version` print and raise SystemExit(0)."""
    return read_request(build_parser(inside_blender).parse_args(arguments), inside_blender)


def read_request(found: argparse.Namespace, inside_blender: bool) -> Request:
    """Make a request from a namespace that has all options of a bake. Raises InputError."""
    demo = found.scene == DEMO
    check_named(found, inside_blender, "baked")
    chosen = {
        field.name: getattr(found, field.name) for field in fields(BakeSpec) if hasattr(found, field.name)
    }
    if found.texels is None:
        del chosen["texels"]
    elif found.density is not None:
        raise InputError("--texels and --density contradict each other: give one of them")
    passes = 1 if found.passes is None else found.passes
    open_layout = OpenLayout(found.bucket) if found.layout is None and passes < 2 else None
    chosen["layout"] = found.layout or Layout.BUCKETS
    chosen["layers"] = tuple(found.layers or ())
    chosen["denoise"] = found.denoise and passes < 2  # what is added to stays raw
    if found.frames:
        chosen["frame"] = found.frames[0]
    if found.exports and not (found.save_preview or demo):
        raise InputError("--export is made from the preview: give --save-preview too")
    if found.export_again and not found.save_preview:
        raise InputError("--export-again makes exports from the preview: give --save-preview too")
    objects = tuple(dict.fromkeys(found.object or ()))
    collections = tuple(dict.fromkeys(found.collection or ()))
    assets, as_scene = found.together == AUTO, found.all and found.together is None
    sharing = _sharing(found.together, objects, demo)
    chosen["objects"] = () if collections or assets or found.all else sharing  # the file has the others
    lights = tuple(map(parse_lights, found.lit or ()))
    spec = lit(BakeSpec(**chosen), lights)
    check_memory(spec)
    _check_passes(found, spec, passes)
    _check_changed(found, demo, passes)
    for target in found.exports or ():
        check_target("the bake", spec.kind, target)
    blend = blend_of(found, demo)
    return Request(
        scene=None if demo or found.scene is None else Path(found.scene),
        demo=demo,
        bakes=BakeRequest(
            objects=objects or ((OBJECT,) if demo else ()),
            spec=spec,
            folder=own_folder(blend) if found.out is None else Path(found.out),
            former=former_folders(blend) if found.out is None else (),
            shared=None if assets else found.together,
            assets=assets,
            as_scene=as_scene,
            open_texels=found.texels is None,
            preview=found.filter if found.save_preview or demo else None,
            overwrite=found.overwrite or found.overwrite_any or demo,
            overwrite_any=found.overwrite_any or demo,
            resume=found.resume,
            exports=tuple(dict.fromkeys(found.exports or ())),
            frames=found.frames,
            lights=lights,
            open_layout=open_layout,
            only_changed=found.only_changed,
            surroundings=found.surroundings,
            passes=passes,
        ),
        progress=found.progress,
        verbose=found.verbose,
        thumbnail=None if found.thumbnail is None else Path(found.thumbnail),
        in_scene=found.in_scene,
        parent_pipe=found.parent_pipe,
        passes=passes,
        serve=found.serve,
        export_again=found.export_again,
        collections=collections,
        everything=found.all and not (objects or collections),
    )


def _check_passes(found: argparse.Namespace, spec: BakeSpec, passes: int) -> None:
    if passes < 1:
        raise InputError(f"--passes {passes}: give a number of 1 or more")
    if passes > 1:
        replace(spec, accumulate=True)  # raises InputError for what cannot be accumulated
    if found.serve is None:
        return
    if Target.WEB not in (found.exports or ()):
        raise InputError("--serve shows the web page: give --export web and --save-preview too")
    if passes > 1 and spec.form.by_paths:
        raise InputError(
            f"--serve: a page of {spec.form.title} does not take in passes",
            do("choose layout buckets", Setting.LAYOUT, value="buckets"),
            do("leave --serve or --passes out"),
        )
    if not 0 <= found.serve <= _LAST_PORT:
        raise InputError(f"--serve {found.serve}: give a port from 0 to {_LAST_PORT}")


def _check_changed(found: argparse.Namespace, demo: bool, passes: int) -> None:
    """Refuse what does not go with --changed. Raises InputError."""
    if not found.only_changed:
        if not found.surroundings:
            raise InputError("--ignore-surroundings says what --changed looks at: give --changed too")
        return
    if demo:
        raise InputError(f"the {DEMO} is always baked anew: leave --changed out")
    if found.overwrite:
        raise InputError("--changed replaces what has changed, --overwrite everything: give one of them")
    if found.resume:
        raise InputError(
            "--changed begins unfinished bakes anew: go on with them by --resume first, then give --changed"
        )
    adds = {"--accumulate": found.accumulate, "--refresh": found.refresh, "--passes": passes > 1}
    for flag, given in adds.items():
        if given:
            raise InputError(f"--changed bakes anew, {flag} adds to what is there: give one of them")


def _sharing(together: str | None, objects: tuple[str, ...], demo: bool) -> tuple[str, ...]:
    """The objects that share the atlas `together`; empty if that is None. Raises InputError."""
    if together is None:
        return ()
    if not together.strip():
        raise InputError("--together wants a name for the atlas, such as --together Furniture")
    if demo:
        raise InputError(f"the {DEMO} has one object: leave --together out")
    return objects


def build_parser(inside_blender: bool) -> Parser:
    """The options of a bake, in the groups of `--help`."""
    program = "blender -b SCENE -P bake.py --" if inside_blender else "bake.py"
    scene = "" if inside_blender else "SCENE "
    parser = Parser(
        prog=program,
        usage=f"{program} {scene}--object NAME [options]\n       {program} {scene}--all [options]\n       "
        f"{program} {DEMO} [options]\n       "
        f"{program} {REPORT} DIR [options]\n       {program} {EXPORT} DIR --to TARGET [options]\n       "
        f"{program} {COMPARE} {scene}--object NAME [options]\n       "
        f"{program} {PREPARE} {scene}--object NAME [options]\n       {program} {ASSEMBLE} DIR [options]",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    add_bake_options(parser, inside_blender, course=True)
    return parser
