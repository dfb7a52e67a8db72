# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and options shared by the subcommands of `bake.py`."""

from __future__ import annotations

import argparse
import re
import sys
from enum import StrEnum
from math import isfinite, nan
from pathlib import Path
from typing import Any, NoReturn

from ..core.errors import BakeError, InputError, QualityError
from ..core.messages import do
from ..core.quoting import quoted
from ..cycles.device import GPU_TYPES
from ..formats.disk.path_checks import check_unicode, one_root
from ..settings.options import MOST_MEMORY, BakeOptions
from ..version import VERSION

DEMO = "demo"
REPORT = "report"
EXPORT = "export"
COMPARE = "compare"
PREPARE = "prepare"
ASSEMBLE = "assemble"

MIB = 2**20
_DIGITS = 12  # longest number accepted: no machine has that much memory

_PLACES = (
    "scene",
    "bake",
    "bakes",
    "farm",
    "out",
    "thumbnail",
)  # options that name a file or a folder


class ProgressStyle(StrEnum):
    """How a run reports its progress."""

    BAR = "bar"
    JSON = "json"
    NONE = "none"


class Parser(argparse.ArgumentParser):
    """Argument parser that raises InputError, and refuses empty paths and invalid Unicode."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        for word in args or ():
            check_unicode(Path(word))
        found = super().parse_args(args, namespace)
        for action in self._actions:
            place = getattr(found, action.dest, None) if action.dest in _PLACES else None
            if place == "" or (isinstance(place, list) and "" in place):
                raise InputError(f"{'/'.join(action.option_strings) or action.metavar} is empty: give a name")
            if isinstance(place, list):
                setattr(found, action.dest, [one_root(each) for each in place])
            elif place is not None:
                setattr(found, action.dest, one_root(place))
        return found

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print the help. Raises BakeError if that fails, where argparse would ignore the error."""
        try:
            print(message, end="", file=sys.stdout if file is None else file, flush=True)
        except OSError as error:
            raise BakeError(f"the standard output cannot be written ({error.strerror or error})") from error

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message} (--help lists everything)")


def command_parser(
    command: str, words: str, description: str, epilog: str, inside_blender: bool, *, opens_scene: bool
) -> Parser:
    """The parser of a command without options yet; `words` are what its usage says behind the command.

    A command that `opens_scene` bakes or looks at Blender's open file when it runs inside Blender.
    """
    file = "SCENE " if opens_scene else ""
    program = f"blender -b {file}-P bake.py -- {command}" if inside_blender else f"bake.py {command}"
    return Parser(
        prog=program,
        usage=f"{program} {words} [options]",
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )


def check_named(found: argparse.Namespace, inside_blender: bool, done: str) -> None:
    """Check that a scene and objects are named, or the demo. `done` is what happens to Blender's open file.

    Raises InputError.
    """
    if not inside_blender and found.scene is None:
        raise InputError(f"which file? give a .blend, or the word {DEMO} (--help lists everything)")
    collections = getattr(found, "collection", None)
    if found.scene == DEMO and collections:
        raise InputError(f"the {DEMO} has one object: leave --collection out")
    everything = getattr(found, "all", None)
    if found.scene == DEMO and everything:
        raise InputError(f"the {DEMO} has one object: leave --all out")
    if found.scene != DEMO and not (found.object or collections or everything):
        scene = "" if everything is None else ", or bake the whole scene: --all"
        raise InputError(f"which object? name it: --object NAME{scene} (--help lists everything)")
    if inside_blender and found.scene not in (None, DEMO):
        raise InputError(
            f"inside Blender the open file is {done}: open {found.scene} by "
            f"{quoted(['blender', '-b', found.scene])}, and leave it out after the --"
        )


def add_progress(group: argparse._ArgumentGroup) -> None:
    """Add the options of progress and messages."""
    add_choice(
        group,
        "--progress",
        ProgressStyle,
        ProgressStyle.BAR,
        "bar: on standard error, with the time left; json: one JSON object a line on standard output, "
        "where a line that does not begin with a brace is Blender's own",
    )
    group.add_argument("--verbose", action="store_true", help="let Blender's own messages through")


def add_parent(group: argparse._ArgumentGroup) -> None:
    """Add the option for a parent process that cancels by a pipe."""
    group.add_argument(
        "--parent-pipe",
        action="store_true",
        help="end as by Ctrl-C when standard input ends, and at the latest three seconds later: the program "
        "closes the pipe to cancel, and its death closes it too",
    )


def add_device(group: argparse._ArgumentGroup) -> None:
    """Add the choice of the rendering device."""
    group.add_argument(
        "--device",
        metavar="NAME",
        default=BakeOptions.device,
        help="auto: as Blender's preferences say; cpu; gpu: any; or one of "
        f"{', '.join(kind.lower() for kind in GPU_TYPES)} (default: %(default)s)",
    )


def add_help(group: argparse._ArgumentGroup) -> None:
    """Add `--help` and `--version`."""
    group.add_argument("-h", "--help", action="help", help="show this text")
    group.add_argument(
        "--version", action="version", version=f"RadTex {VERSION}", help="show RadTex's version"
    )


def add_choice(
    group: argparse._ArgumentGroup,
    flag: str,
    options: type[StrEnum],
    default: StrEnum | None,
    text: str,
    dest: str | None = None,
    action: str = "store",
    metavar: str | None = None,
) -> None:
    """Add an option whose value is one of an enum's words.

    If `default` is None, the option may be omitted; `text` may say what happens then. The help shows the
    words, or `metavar` if there are too many.
    """

    def chosen(word: str) -> StrEnum:
        try:
            return options(word)
        except ValueError:
            raise InputError(f"{flag} {word}: choose from {', '.join(options)}") from None

    known = "" if default is None else " (default: %(default)s)"
    group.add_argument(
        flag,
        action=action,
        dest=dest,
        type=chosen,
        default=default,
        metavar=metavar or "|".join(options),
        help=f"{text}{known}",
    )


def add_memory(group: argparse._ArgumentGroup, text: str, known: int | None, least: int = 1) -> None:
    """Add `--memory`: how much memory may be used, in whole MiB, at least `least`; `known` is the default."""

    def memory(word: str) -> int:
        found = _memory(word)
        if not least <= found <= MOST_MEMORY:
            raise InputError(
                f"--memory {word}: give {least}MiB at least, and {MOST_MEMORY // MIB}TiB at most"
            )
        return found

    default = "" if known is None else f" (default: {known})"
    group.add_argument(
        "--memory",
        dest="memory_mb",
        type=memory,
        metavar="SIZE",
        default=known,
        help=f"{text}, such as 2GB or 1.5GiB; a number alone counts MiB{default}",
    )


def parse_size(flag: str, word: str, examples: str) -> int:
    """Parse a size such as 800KB or 1.5 GiB to bytes, at least one; KB is 1000 bytes, KiB 1024.

    Raises InputError, which names the option `flag` and shows the `examples`.
    """
    found = re.fullmatch(r"(\d{1,12}(?:\.\d{1,12})?)\s*([KMGT]?)(i?)B?", word.strip(), re.IGNORECASE)
    unit = 1024 if found and found[3] else 1000
    size = round(float(found[1]) * float(unit ** " KMGT".index(found[2].upper() or " "))) if found else 0
    if size < 1:
        raise InputError(f"{flag} {word}: give a size, such as {examples}")
    return size


def _memory(word: str) -> int:
    if word.strip().isdecimal() and len(word) <= _DIGITS:
        return int(word)
    return parse_size("--memory", word, "2GB or 800MB") // MIB


def add_least_psnr(group: argparse._ArgumentGroup) -> None:
    """Add the PSNR below which the command fails, as `min_psnr`, in decibels or None."""

    def decibels(word: str) -> float:
        try:
            found = float(word)
        except ValueError:
            found = nan
        if not isfinite(found):
            raise InputError(f"--min-psnr {word}: give a number of decibels, as 25 or 27.5")
        return found

    group.add_argument(
        "--min-psnr",
        type=decibels,
        metavar="DB",
        help="end with exit code 3 if the bake comes out below; all files are written nevertheless",
    )


def check_psnr(name: str, psnr: float, least: float | None) -> None:
    """Raise QualityError if an object's bake came out below `least` decibels, as of `--min-psnr`."""
    if least is not None and psnr < least:
        raise QualityError(
            f"{name}: {psnr:.2f} dB, less than the {least:g} dB of --min-psnr",
            do("bake with more texels or samples"),
        )


def add_number(
    group: argparse._ArgumentGroup, flag: str, field: str, metavar: str, text: str, known: int | None
) -> None:
    """Add an option for a whole number; `known` is its default."""

    def number(word: str) -> int:
        try:
            return int(word)
        except ValueError:
            raise InputError(f"{flag} {word}: give a whole number") from None

    group.add_argument(flag, dest=field, type=number, metavar=metavar, default=known, help=text)
