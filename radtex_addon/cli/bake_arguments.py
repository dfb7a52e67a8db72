# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of a bake's command line, with their help."""

from __future__ import annotations

import argparse
from functools import partial

from ..bake.frame_numbers import parse_frames
from ..bake.spec import BakeSpec, CaptureMethod, Compression, Kind, Layer, Layout, Split, Unwrap, View
from ..bake.spec_checks import LEAST_MEMORY
from ..bake.texel_density import MOST_TEXELS, parse_density
from ..core.errors import InputError
from ..core.sampler import Filter
from ..textures.export_spec import Target
from .options import DEMO, add_choice, add_device, add_memory, add_number, add_progress

_DEFAULT = BakeSpec()


def add_what(group: argparse._ArgumentGroup, inside_blender: bool) -> None:
    """Add options for the light and the objects to bake, and the surface to bake onto."""
    _add_objects(group, inside_blender)
    _add_light(group)
    _add_variants(group)
    _add_surface(group)


def _add_objects(group: argparse._ArgumentGroup, inside_blender: bool) -> None:
    file = "left out: the file that Blender has open is baked" if inside_blender else "a .blend file"
    group.add_argument(
        "scene",
        nargs="?",
        metavar="SCENE",
        help=f"{file}; or the word {DEMO}, for a small scene of our own: it saves a preview, "
        "renders a picture of it, and replaces what an earlier demo left",
    )
    group.add_argument(
        "--object",
        action="append",
        metavar="NAME",
        help="the mesh object to bake; may be given several times",
    )
    group.add_argument(
        "--collection",
        action="append",
        metavar="NAME",
        help="bake all meshes of the collection and of those in it, by name; what cannot be baked, such as "
        "what is hidden from render, is left out with a line that says why; may be given several times, and "
        "beside --object",
    )
    group.add_argument(
        "--together",
        metavar="NAME",
        help="bake all objects into one atlas, which is called NAME: DIR/NAME.KIND.exr "
        "(default: each has its own)",
    )
    add_choice(
        group,
        "--split",
        Split,
        None,
        "material: an atlas for each material, DIR/NAME.MATERIAL.KIND.exr; udim: one for each tile of the UV "
        "layer --uv, DIR/NAME.1001.KIND.exr and so on (default: one for the whole surface)",
    )
    group.add_argument(
        "--part",
        metavar="PART",
        default=_DEFAULT.part,
        help="of --split, bake this material or tile alone (default: all of them)",
    )
    group.add_argument(
        "--in-scene",
        metavar="NAME",
        help="the scene of the file (default: the one that it opens with)",
    )


def _add_light(group: argparse._ArgumentGroup) -> None:
    add_choice(
        group,
        "--kind",
        Kind,
        _DEFAULT.kind,
        "radiance: the object as a viewer sees it; incident: the light that arrives; "
        "reflection: the same, along the mirror direction; proxy: what a hull has inside, or shows in its "
        "place; shadow: which directions are blocked; ao: how much of the sky is; "
        "transfer: how the object answers to light from each direction",
    )
    add_choice(
        group,
        "--view",
        View,
        _DEFAULT.view,
        "from where a transfer is seen: normal: each texel along its normal, which suits matt things; "
        "camera: from the scene's camera, gloss and all; "
        "around: from nine directions, for nine times the paths",
    )
    group.add_argument(
        "--content",
        metavar="NAME",
        help="what a proxy shows: the collection of that name, or * for all that is behind it, as through a "
        "window (default: what lies inside it)",
    )
    group.add_argument(
        "--ao-distance",
        type=partial(_distance, flag="--ao-distance", such_as="0.5"),
        metavar="D",
        default=_DEFAULT.ao_distance,
        help="of ao, what is farther than D, in scene units, counts as open (default: nothing does)",
    )
    group.add_argument(
        "--alone",
        action="store_true",
        help="bake each object as if it stood alone: no other object is seen, or casts shadows; lamps and "
        "the world stay",
    )
    group.add_argument(
        "--from",
        dest="source",
        metavar="NAME",
        default=_DEFAULT.source,
        help="bake what the detailed object of that name shows: it is found along the normals of --object, "
        "which is simple, stands around the same place and is not seen itself",
    )
    group.add_argument(
        "--extrusion",
        type=partial(_distance, flag="--extrusion", such_as="0.05"),
        metavar="D",
        default=_DEFAULT.extrusion,
        help="how far from --object, outwards and inwards, --from is looked for, in scene units "
        "(default: 3 %% of the size)",
    )
    group.add_argument(
        "--cage",
        metavar="NAME",
        default=_DEFAULT.cage,
        help="look for --from from this object on, through --object and as far beyond, instead of along "
        "normals: a copy of --object whose vertices were moved out; it is never seen",
    )


def _add_variants(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--frames",
        type=parse_frames,
        metavar="LIST",
        default=(),
        help="bake the scene at each of these frames, such as 1,5,10-20, into DIR/NAME-FRAME.KIND.exr, the "
        "frame in four digits (default: the frame that the file opens with)",
    )
    group.add_argument(
        "--unwrap-at",
        type=_frame,
        metavar="FRAME",
        default=_DEFAULT.unwrap_at,
        help="unwrap the object as it is at that frame, so that atlases of all frames fit one mesh "
        "(default: the first of --frames)",
    )
    group.add_argument(
        "--lights",
        action="append",
        dest="lit",
        metavar="LIST",
        help="bake with these lamps, or collections of lamps, alone lit, such as Key,Fill, into "
        "DIR/NAME-Key+Fill.KIND.exr; the name world is the light of no lamp. each: an atlas for every lamp "
        "and one for world, which add up to the whole; all: the whole; may be given several times",
    )
    add_choice(
        group,
        "--layer",
        Layer,
        None,
        "also write this part of the radiance as an atlas, DIR/NAME.KIND.LAYER.exr: "
        f"{', '.join(Layer)}; base and rest add up to the whole; may be given several times",
        dest="layers",
        action="append",
        metavar="LAYER",
    )


def _add_surface(group: argparse._ArgumentGroup) -> None:
    add_choice(
        group,
        "--layout",
        Layout,
        None,
        "layered: what surrounds the object, in layers that are met from each place, what it shows of "
        "itself, and what is left: the best picture in the fewest bytes; radiance by the portal only; "
        "buckets: every texel keeps a picture of its own (default: layered; buckets for other kinds, for an "
        "object with hair or a volume, and for what layered refuses: a line says why; what is resumed, "
        "accumulated or refreshed keeps its layout)",
    )
    group.add_argument(
        "--uv",
        dest="uv_layer",
        metavar="NAME",
        default=_DEFAULT.uv_layer,
        help="bake on this UV layer of the object (default: as --unwrap says)",
    )
    add_choice(
        group,
        "--unwrap",
        Unwrap,
        _DEFAULT.unwrap,
        "auto: bake on the object's active UV layer if it is fit (it covers half of the square, overlaps "
        "nowhere, and its islands are --padding apart), else as uvunwrap; uvunwrap: unwrap a copy into few, "
        "large islands; xatlas, blender: by these",
    )
    _number(group, "--padding", "padding", "N", "texels that the unwrap leaves free between islands")


def add_quality(group: argparse._ArgumentGroup) -> None:
    """Add options for texels, cells and samples."""
    text = f"texels along the atlas's longer side (default: {_DEFAULT.texels})"
    add_number(group, "--texels", "texels", "N", text, None)
    group.add_argument(
        "--density",
        type=partial(parse_density, called="--density"),
        metavar="D",
        default=_DEFAULT.density,
        help="texels per metre of surface, such as 64/m, 64/cm or 1.5/mm, in place of --texels: the atlas is "
        f"as large as that needs, up to {MOST_TEXELS} texels a side. A scene unit has as many metres as the "
        "scene's unit scale says",
    )
    _number(
        group,
        "--bucket",
        "bucket",
        "N",
        "cells along a bucket's side: each texel tells N x N directions apart",
        f"{Layout.BUCKETS.cells} in layout buckets; layered chooses them itself",
    )
    _number(
        group,
        "--samples",
        "samples",
        "N",
        "light paths for each cell: more paths, less noise; in the layered layout about 64 N "
        "for each texel, however many cells it has",
    )


def _frame(word: str) -> int:
    if not word.isdecimal():
        raise InputError(f"--unwrap-at {word}: give a frame's number, such as 1")
    return int(word)


def _distance(word: str, flag: str, such_as: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{flag} {word}: give a distance in scene units, such as {such_as}") from None


def add_how(group: argparse._ArgumentGroup) -> None:
    """Add options for how Cycles renders."""
    add_choice(
        group,
        "--capture",
        CaptureMethod,
        _DEFAULT.capture,
        "portal: many texels in one render; panoramic: a fisheye camera at each texel, slow, "
        "not for radiance",
    )
    _number(group, "--seed", "seed", "N", "seed of the light paths; the same seed gives the same atlas")
    _number(
        group,
        "--sheet",
        "sheet",
        "N",
        "side, in pixels, of the pictures that Cycles renders of an atlas: a frame of a farm is one, and "
        "pictures of another size have other noise",
    )
    group.add_argument(
        "--no-denoise",
        dest="denoise",
        action="store_false",
        help="keep cells as they were traced, noise and all (default: buckets of light, and transfers, "
        "are denoised by OpenImageDenoise)",
    )
    add_device(group)
    beside = "memory that the bake may take beside the scene: one that needs more is refused"
    add_memory(group, beside, None, LEAST_MEMORY)


def add_files(group: argparse._ArgumentGroup) -> None:
    """Add options for the output files and their contents."""
    group.add_argument(
        "--out",
        metavar="DIR",
        help="folder for the files, made if need be (default: radtex/NAME beside NAME.blend; without a file, "
        "radtex)",
    )
    add_overwrite(group)
    group.add_argument(
        "--save-preview",
        action="store_true",
        help="also write DIR/NAME.preview.blend: the scene with the baked object in it",
    )
    add_choice(
        group,
        "--filter",
        Filter,
        Filter.QUADRILINEAR,
        "how the preview blends cells and texels of layout buckets",
    )
    group.add_argument(
        "--float", dest="half", action="store_false", help="store 32-bit floats (default: half floats)"
    )
    add_choice(
        group,
        "--compression",
        Compression,
        _DEFAULT.compression,
        "how the atlas is packed; dwaa is small and loses a little",
    )
    add_progress(group)


def add_overwrite(group: argparse._ArgumentGroup) -> None:
    """Add the options for what a bake may replace."""
    group.add_argument(
        "--overwrite",
        action="store_true",
        help="replace an earlier bake of the same thing, unless it is better: with more texels, cells or "
        "samples, other layers, or layered where the new one is not",
    )
    group.add_argument(
        "--overwrite-any",
        action="store_true",
        help="as --overwrite, and replace better bakes, and those of other .blend files, too; a bake of "
        "another object, part or frame never is",
    )


def add_course(group: argparse._ArgumentGroup) -> None:
    """Add options for partial and resumed bakes, exports and the thumbnail."""
    group.add_argument(
        "--accumulate",
        action="store_true",
        help="fold the samples into the atlas that is there: 8 and 8 more are 16, if nothing has changed",
    )
    add_number(
        group,
        "--passes",
        "passes",
        "N",
        "bake, then fold in as many samples again, with exports and preview after each pass, until there are "
        "N passes (default: 1)",
        None,
    )
    add_number(
        group,
        "--serve",
        "serve",
        "PORT",
        "with --export web: serve the page on this machine, which takes in each pass, until Ctrl-C; 0 is a "
        "free port",
        None,
    )
    group.add_argument(
        "--refresh",
        action="store_true",
        help="bake again only those texels of the atlas that is there whose light has changed, with as many "
        "samples as it has",
    )
    group.add_argument(
        "--where",
        metavar="NAME",
        default=_DEFAULT.where,
        help="accumulate or refresh only faces of the object's vertex group, boolean face attribute or "
        "material of that name (default: everywhere)",
    )
    group.add_argument(
        "--changed",
        dest="only_changed",
        action="store_true",
        help="bake only what has no finished bake in DIR, or has changed since: mesh, place, materials, "
        "settings or surroundings; replaces what is there, and says in a line what became of each",
    )
    group.add_argument(
        "--ignore-surroundings",
        dest="surroundings",
        action="store_false",
        help="of --changed, what has changed of neighbours, lamps and the world does not count",
    )
    group.add_argument(
        "--resume",
        action="store_true",
        help="go on with a bake that was interrupted, killed or failed, from what is kept of it in "
        "DIR/NAME.KIND.radtex-unfinished; the atlas is what it would have been, bit by bit",
    )
    add_choice(
        group,
        "--export",
        Target,
        None,
        "also make DIR/NAME.TARGET of the bake, as bake.py export --to TARGET does; may be given several "
        "times, and needs --save-preview",
        dest="exports",
        action="append",
    )
    group.add_argument(
        "--thumbnail",
        metavar="FILE",
        help="a small PNG of what is baked so far, written anew every second",
    )


def _number(
    group: argparse._ArgumentGroup, flag: str, field: str, metavar: str, text: str, default: str = ""
) -> None:
    """Add an option for a whole number. `default` is the help's text if BakeSpec computes the default."""
    known = None if default else getattr(_DEFAULT, field)
    add_number(group, flag, field, metavar, f"{text} (default: {default or known})", known)
