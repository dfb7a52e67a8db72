# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Command lines: the real parsers' commands and options with real and odd values."""

from __future__ import annotations

import argparse
import pkgutil
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from random import Random

import radtex_addon.cli

HARMLESS = ("demo", "--parent-pipe", "--stock-frames")  # may not run to the end: bake, or wait for a parent
_NUMBERS = (
    *("0", "1", "2", "-1", "8", "16", "64", "128", "256", "16384", "32768", "99999999999999999999"),
    *("1e3", "1.5", "-0", "+4", " 7 ", "1_000", "٣", "½", "0x10", "08"),
    *("NaN", "nan", "inf", "-inf", "Infinity", "1e400", "-1e400", "1e-400", "True"),
    *("1e-300", "1e300", "1e38", "-1e38", "5e-324", "1e-300/m", "1e300/mm", "64/cm", "2147483648"),
    *("9" * 400, "9" * 5000, "-" + "9" * 5000, "0." + "0" * 400 + "1"),
)
_SIZES = ("800KB", "8MB", "2GB", "2 GiB", "1.5g", "9" * 400 + "GB", "1e9", "-8MB", "8XB", "MB", "0KB", "0.1B")
_LISTS = (
    *("1,5,10-20", "5-1", "1-", "-1", "1,,2", "1-99999999999", "0-99999", ",".join("1" * 200)),
    *("Key,Fill", '"Key,Fill', '"a""b",c', "each", "all,world", "world", ",", '"', "a\nb,c", "\r"),
    "x" * 140_000,
)
_MATRICES = (
    *("1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1", "1,0,0,0,0,1,0,0,0,0,-1,-0.2,0,0,-1,0", "1,2,3", "a" * 16),
    *(f"{number}," * 15 + "1" for number in ("nan", "inf", "0", "1e308", "1e-200")),
)
_NAMES = (
    *("", " ", "Vase", "Väse ☃", "a" * 300, "a" * 5000),
    *("../../x", "/", ".", "..", "-", "--", "---", "-x", "="),
)
_ODD = (
    *("a\nb", "a\rb", "\x1b[31m", "\0", "a\0b", "\ud800", "\udcff", "\u2028", "\x85"),
    *("*", "%s", "%(prog)s", "{}", "~"),
)
_WINDOWS = ("CON", "a:b", "C:\\x", "\\\\?\\x", "'; DROP", "$(true)", "`true`", "@file", "nul.json")
_FITTING = {
    "N": ("1", "2", "4", "14", "64"),
    "NAME": ("Vase",),
    "SIZE": ("8MB",),
    "DB": ("40dB",),
}  # by metavar


@dataclass(frozen=True)
class _Command:
    """A command's words before its options, and its options: each with the words that its help offers."""

    word: str
    options: tuple[tuple[str, tuple[str, ...], bool], ...]  # flag, words, whether it wants a value


def command_line(random: Random, folder: Path) -> list[str]:
    """A command line; its paths lead into the `folder` of a corpus, or nowhere. Nothing in it can bake."""
    command = random.choice(_commands())
    words = [command.word] if command.word else []
    if random.random() < 0.8:
        words.append(_path(random, folder))
    sound = random.random() < 0.3  # gets further
    for flag, offered, wants in random.choices(command.options, k=random.choice((0, 1, 2, 3, 4, 6, 12))):
        if sound and flag in ("-h", "--help", "--version"):
            continue
        words += _option(random, folder, flag, offered if sound else (), wants)
    if random.random() < 0.5:
        words += ["--object", random.choice(("Vase", "Nobody", "Light"))]
    if random.random() < 0.1:
        random.shuffle(words)
    if random.random() < 0.05:
        words = words[: random.randrange(len(words) + 1)] * random.choice((1, 2, 50))
    return words


def _option(random: Random, folder: Path, flag: str, offered: tuple[str, ...], wants: bool) -> list[str]:
    """An option in one of the ways in which people and programs write them."""
    if random.random() < 0.05:
        others = (flag[:-1], flag + "s", flag.upper(), flag[1:], flag + "=", flag + " ", "--no-such")
        flag = random.choice(others)
    if not wants:
        return [flag if random.random() < 0.95 else f"{flag}={_value(random, folder)}"]
    value = random.choice(offered) if offered and random.random() < 0.9 else _value(random, folder)
    return random.choice(([flag, value], [f"{flag}={value}"], [flag, value], [flag]))


def _value(random: Random, folder: Path) -> str:
    if random.random() < 0.15:
        return _path(random, folder)
    pools = (_NUMBERS, _NUMBERS, _SIZES, _LISTS, _MATRICES, _NAMES, _ODD, _WINDOWS)
    value = random.choice(random.choice(pools))
    return value if random.random() < 0.9 else value + random.choice(random.choice(pools))


def _path(random: Random, folder: Path) -> str:
    known = ("", "Vase.radiance.json", "Coat.radiance.json", "Vase.radiance.exr", "mesh.glb", "nothing.blend")
    odd = random.choice(_NAMES + _ODD + _WINDOWS)
    places = (folder / random.choice(known), folder / "nowhere" / "x.blend", odd, f"{folder}/{odd}")
    return str(random.choice(places))


@cache
def _commands() -> tuple[_Command, ...]:
    """All that the batch has, from its own parsers."""
    found = []
    for module in pkgutil.iter_modules(radtex_addon.cli.__path__):
        if not module.name.endswith("arguments") or module.name == "bake_arguments":
            continue
        parser: argparse.ArgumentParser = import_module(f"radtex_addon.cli.{module.name}").build_parser(False)
        options = tuple(
            (flag, _offered(action), action.nargs != 0)
            for action in parser._actions
            for flag in action.option_strings
        )
        found.append(_Command(module.name.removesuffix("arguments").rstrip("_"), options))
    return tuple(found)


def _offered(action: argparse.Action) -> tuple[str, ...]:
    """Values that fit an option: the words that its help shows, or small numbers."""
    if isinstance(action.metavar, str) and "|" in action.metavar:
        return tuple(action.metavar.split("|"))
    return _FITTING.get(str(action.metavar), ("1",))
