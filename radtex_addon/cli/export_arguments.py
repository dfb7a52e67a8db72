# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of `bake.py export`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, fields
from itertools import groupby
from pathlib import Path

from ..bake.layers import Layer
from ..core.errors import InputError
from ..settings.targets import MOST_PIXELS, TARGETS
from ..textures.export_spec import IMAGE_LIMIT, Arrangement, ExportSpec, MeshPacking, Target, TextureFormat
from .options import (
    EXPORT,
    Parser,
    ProgressStyle,
    add_choice,
    add_help,
    add_memory,
    add_number,
    add_parent,
    add_progress,
    command_parser,
)

_DESCRIPTION = """\
Make a folder of a finished bake that an engine or a browser takes: the mesh
as glTF, the textures in a format that the target loads, a flat lightmap for
programs that know no radiance textures, and what the target needs beside.
The bake must have been made with --save-preview, which keeps its mesh.
Several bakes are a folder each, or with --scene one scene."""

_EPILOG = """\
examples:
  python bake.py export baked --to web
  python bake.py export baked --object Vase --to godot --out game/vase
  python bake.py export baked --to unity --format exr
  python bake.py export baked --to web --mirror
  python bake.py export baked --to web --scene Room
  python bake.py export A.radiance.json B.radiance.json --to gltf --scene Room

exit codes: as of a bake"""


@dataclass(frozen=True)
class ExportRequest:
    """An export of bakes, each to a folder of its own, or as one scene if that has a name.

    Each of `bakes` is a folder or a sidecar; `out` is None for a folder beside the bake.
    """

    bakes: tuple[Path, ...]
    object: str | None
    spec: ExportSpec
    out: Path | None
    overwrite: bool
    progress: ProgressStyle
    verbose: bool
    scene: str | None = None
    parent_pipe: bool = False


def parse_export(arguments: list[str], inside_blender: bool) -> ExportRequest:
    """Parse what follows the command's name. Raises InputError; `--help` prints and raises SystemExit(0)."""
    found = build_parser(inside_blender).parse_args(arguments)
    if not found.bakes:
        raise InputError("which bake? name its folder, or its sidecar (--help lists everything)")
    if found.target is None:
        raise InputError(f"for whom? --to {', '.join(Target)} (--help lists everything)")
    if found.as_scene is not None and not found.as_scene.strip():
        raise InputError("--scene is empty: give the scene a name")
    return ExportRequest(
        bakes=tuple(map(Path, found.bakes)),
        object=found.object,
        spec=ExportSpec(**{field.name: getattr(found, field.name) for field in fields(ExportSpec)}),
        out=None if found.out is None else Path(found.out),
        overwrite=found.overwrite,
        progress=found.progress,
        verbose=found.verbose,
        scene=found.as_scene,
        parent_pipe=found.parent_pipe,
    )


def build_parser(inside_blender: bool) -> Parser:
    """The options of `export`, in the groups of `--help`."""
    parser = command_parser(
        EXPORT, "DIR [DIR ...] --to TARGET", _DESCRIPTION, _EPILOG, inside_blender, opens_scene=False
    )
    _add_what(parser.add_argument_group("what is exported"))
    _add_scene(parser.add_argument_group("a whole scene"))
    _add_textures(parser.add_argument_group("textures"))
    _add_mirror(parser.add_argument_group("mirror ball"))
    add_memory(
        parser.add_argument_group("how"),
        "memory that the export may take beside Blender: one that needs more is refused",
        None,
    )
    _add_output(parser.add_argument_group("output"))
    add_parent(parser.add_argument_group("for a program that runs this one"))
    add_help(parser.add_argument_group("help"))
    return parser


def _add_what(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "bakes", nargs="*", metavar="DIR", help="the folder of a bake, or its sidecar's .json; or several"
    )
    group.add_argument(
        "--object",
        metavar="NAME",
        help="whose bake, if there are several in the folder: the object, or what --name has called the bake",
    )
    ordered = sorted(Target, key=lambda target: bool(target.traits.languages))  # what is ready to run first
    told = groupby(ordered, key=lambda target: target.traits.help)
    text = "; ".join(f"{', '.join(targets)}: {words}" for words, targets in told)
    add_choice(group, "--to", Target, None, text, dest="target")


def _add_scene(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--scene",
        dest="as_scene",
        metavar="NAME",
        help="export all bakes as one scene of this name: one folder, one glTF with a node for each "
        "object, one manifest. Of a folder all objects' bakes. Objects called TREE_LOD0, TREE_LOD1 "
        "and so on become levels of detail",
    )


def _add_textures(group: argparse._ArgumentGroup) -> None:
    add_choice(
        group,
        "--layer",
        Layer,
        None,
        "a layer of the bake that shall lie beside the whole; may be given several times",
        dest="layers",
        action="append",
        metavar="LAYER",
    )
    add_choice(
        group,
        "--format",
        TextureFormat,
        TextureFormat.AUTO,
        "how textures are stored; auto: what the target loads best",
    )
    group.add_argument(
        "--no-zstd", dest="zstd", action="store_false", help="leave KTX2 files uncompressed (default: zstd)"
    )
    add_choice(
        group,
        "--arrangement",
        Arrangement,
        Arrangement.MATRIX,
        "of layout buckets; matrix: as in the bake; slices: a texture array with a layer for each cell, "
        "which hardware filters",
    )
    limits = (row for row in TARGETS.values() if row.most_pixels < MOST_PIXELS)
    smaller = ", ".join(f"{row.most_pixels} for {row.called or row.title}" for row in limits)
    add_number(
        group, "--levels", "levels", "N", "mip levels, for objects far away (default: as many as fit)", None
    )
    add_number(
        group,
        "--limit",
        "limit",
        "PIXELS",
        "the most pixels along a texture's side: a larger matrix is split "
        f"(default: {smaller}, else {MOST_PIXELS})",
        None,
    )

    packed = ", ".join(target for target in Target if target.traits.meshes[0] is MeshPacking.MESHOPT)
    takers = " and ".join(target for target in Target if MeshPacking.MESHOPT in target.traits.meshes)
    add_choice(
        group,
        "--mesh",
        MeshPacking,
        MeshPacking.AUTO,
        "how the .glb stores its mesh; meshopt: by EXT_meshopt_compression, in a third of the bytes, which "
        f"Blender does not read, for {takers}; plain: without; auto: meshopt for {packed}",
    )
    shown = ", ".join(target for target in Target if target.traits.images)
    add_number(
        group,
        "--image-limit",
        "image_limit",
        "PIXELS",
        f"for {shown}, where a material's colour, metal, roughness and normal are images: the most pixels "
        "along a side of these, which the export holds; 0: the bake's own maps instead",
        IMAGE_LIMIT,
    )


def _add_mirror(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--mirror",
        action="store_true",
        help=f"for {' and '.join(target for target in Target if target.traits.mirror)}: a chrome ball that "
        "moves and mirrors the bake, by a ray for each fragment",
    )
    group.add_argument(
        "--mirror-sky",
        dest="sky",
        type=_colour,
        metavar="R,G,B",
        help="linear light that the ball shows where a ray meets nothing; the layered layout has "
        "surroundings of its own (default: 0,0,0)",
    )


def _colour(words: str) -> tuple[float, float, float]:
    try:
        red, green, blue = (float(word) for word in words.split(","))
    except ValueError:
        raise InputError(f"--mirror-sky {words}: give three numbers, such as 0.5,0.6,0.8") from None
    return red, green, blue


def _add_output(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--out", metavar="OUT", help="the folder to make (default: DIR/NAME.TARGET, such as DIR/Vase.web)"
    )
    group.add_argument(
        "--overwrite", action="store_true", help="replace what an earlier export wrote, and nothing else"
    )
    add_progress(group)
