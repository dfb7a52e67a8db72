# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of a bake's command line, from the table of options."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from ..bake import options
from ..bake.frame_numbers import parse_frames
from ..bake.option import Option, Section
from ..bake.options import OPTIONS
from ..bake.texel_density import parse_density
from ..core.errors import InputError
from ..textures.export_spec import Target
from .options import DEMO, add_choice, add_device, add_memory, add_number, add_progress


def add_what(group: argparse._ArgumentGroup, inside_blender: bool) -> None:
    """Add options for the light and the objects to bake, and the surface to bake onto."""
    file = "left out: the file that Blender has open is baked" if inside_blender else "a .blend file"
    group.add_argument(
        "scene",
        nargs="?",
        metavar="SCENE",
        help=f"{file}; or the word {DEMO}, for a small scene of our own: it saves a preview, "
        "renders a picture of it, and replaces what an earlier demo left",
    )
    what = (options.OBJECTS, options.LIGHT, options.SOURCE, options.VARIANTS_OF_LIGHT)
    _add_sections(group, *what, options.LAYOUT, options.SURFACE)


def add_quality(group: argparse._ArgumentGroup) -> None:
    """Add options for texels, cells and samples."""
    _add_sections(group, options.QUALITY)


def add_how(group: argparse._ArgumentGroup) -> None:
    """Add options for how Cycles renders."""
    _add_sections(group, options.HOW)


def add_files(group: argparse._ArgumentGroup) -> None:
    """Add options for the output files and their contents."""
    _add_sections(group, options.FOLDER, options.FILES)
    add_progress(group)


def add_overwrite(group: argparse._ArgumentGroup) -> None:
    """Add the options for what a bake may replace."""
    add_options(group, (OPTIONS["overwrite"], OPTIONS["overwrite_any"]))


COURSE = (options.COURSE, options.EXPORTS)


def add_course(group: argparse._ArgumentGroup) -> None:
    """Add options for partial and resumed bakes, exports and the thumbnail."""
    _add_sections(group, *COURSE)


def _add_sections(group: argparse._ArgumentGroup, *sections: Section) -> None:
    for section in sections:
        add_options(group, section.options)


def add_options(group: argparse._ArgumentGroup, rows: Iterable[Option]) -> None:
    """Add those of the options that the command line has."""
    for row in rows:
        if row.name in _BY_HAND:
            _BY_HAND[row.name](group)
        elif row.flag:
            _add_option(group, row)


def _add_option(group: argparse._ArgumentGroup, row: Option) -> None:
    known = row.flag_default
    told = f"{row.help} (default: {row.otherwise})" if row.otherwise else row.help
    action = "append" if row.many else "store"
    choices = Target if row.name == "exports" else row.choices  # which the table is too far left to know
    if isinstance(known, bool):
        action = "store_false" if known else "store_true"
        group.add_argument(row.flag, dest=row.name, action=action, help=told)
    elif row.takes is int or isinstance(known, int):
        if not row.otherwise and known is not None:
            told += f" (default: {known})"
        add_number(group, row.flag, row.name, row.metavar or "N", told, known)
    elif choices is not None:
        add_choice(group, row.flag, choices, known, told, row.name, action, row.metavar)
    else:
        read = _READ.get(row.name, str)
        group.add_argument(
            row.flag, dest=row.name, action=action, type=read, metavar=row.metavar, default=known, help=told
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


_MEMORY = OPTIONS["memory_mb"]
_BY_HAND: dict[str, Callable[[argparse._ArgumentGroup], None]] = {
    "device": add_device,
    "memory_mb": partial(add_memory, text=_MEMORY.help, known=None, least=options.LEAST_MEMORY),
}
_READ: dict[str, Callable[[str], Any]] = {
    "ao_distance": partial(_distance, flag="--ao-distance", such_as="0.5"),
    "density": partial(parse_density, called="--density"),
    "extrusion": partial(_distance, flag="--extrusion", such_as="0.05"),
    "frames": parse_frames,
    "unwrap_at": _frame,
}
