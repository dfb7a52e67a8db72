# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of a bake's command line, from the table of options."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from ..core.errors import InputError
from ..settings.frame_numbers import parse_frames
from ..settings.option import Option
from ..settings.options import (
    COURSE,
    EXPORTS,
    FILES,
    FOLDER,
    HOW,
    LAYOUT,
    LEAST_MEMORY,
    LIGHT,
    OBJECTS,
    OPTIONS,
    QUALITY,
    SOURCE,
    SURFACE,
    VARIANTS_OF_LIGHT,
)
from ..settings.texel_density import parse_density
from .options import (
    DEMO,
    Parser,
    add_choice,
    add_device,
    add_help,
    add_memory,
    add_number,
    add_parent,
    add_progress,
)


def add_bake_options(parser: Parser, inside_blender: bool, *, course: bool) -> None:
    """Add the options of a bake, in the groups of `--help`.

    Without the `course`, what applies only while a bake renders, and to its exports, has its default.
    """
    what = parser.add_argument_group("what is baked")
    file = "left out: the file that Blender has open is baked" if inside_blender else "a .blend file"
    what.add_argument(
        "scene",
        nargs="?",
        metavar="SCENE",
        help=f"{file}; or the word {DEMO}, for a small scene of our own: it saves a preview, "
        "renders a picture of it, and replaces what an earlier demo left",
    )
    for section in (OBJECTS, LIGHT, SOURCE, VARIANTS_OF_LIGHT, LAYOUT, SURFACE):
        add_options(what, section.options)
    add_options(parser.add_argument_group("quality"), QUALITY.options)
    add_options(parser.add_argument_group("how"), HOW.options)
    output = parser.add_argument_group("output")
    add_options(output, FOLDER.options + FILES.options)
    add_progress(output)
    if course:
        add_options(output, COURSE.options + EXPORTS.options)
    else:
        parser.set_defaults(**{row.name: row.flag_default for row in COURSE.options + EXPORTS.options})
    add_parent(parser.add_argument_group("for a program that runs this one"))
    add_help(parser.add_argument_group("help"))


def add_options(group: argparse._ArgumentGroup, rows: Iterable[Option]) -> None:
    """Add those of the options that the command line has."""
    for row in rows:
        if row.name in _BY_HAND:
            _BY_HAND[row.name](group)
        elif row.flag:
            _add_option(group, row)


def _add_option(group: argparse._ArgumentGroup, row: Option) -> None:
    known = row.flag_default
    told = f"{row.help} (default: {row.default_words})" if row.default_words else row.help
    action = "append" if row.many else "store"
    if isinstance(known, bool):
        action = "store_false" if known else "store_true"
        group.add_argument(row.flag, dest=row.name, action=action, help=told)
    elif row.takes is int or isinstance(known, int):
        if not row.default_words and known is not None:
            told += f" (default: {known})"
        add_number(group, row.flag, row.name, row.metavar or "N", told, known)
    elif row.choices is not None:
        add_choice(group, row.flag, row.choices, known, told, row.name, action, row.metavar)
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
    "memory_mb": partial(add_memory, text=_MEMORY.help, known=None, least=LEAST_MEMORY),
}
_READ: dict[str, Callable[[str], Any]] = {
    "ao_distance": partial(_distance, flag="--ao-distance", such_as="0.5"),
    "density": partial(parse_density, called="--density"),
    "extrusion": partial(_distance, flag="--extrusion", such_as="0.05"),
    "frames": parse_frames,
    "unwrap_at": _frame,
}
