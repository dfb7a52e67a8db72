# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quote commands in messages, so that they can be pasted safely into a shell."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Sequence

_PLAIN = re.compile(r"[\w@%+=:,./-]+", re.ASCII)  # safe unquoted in POSIX shells, as in shlex
_WINDOWS_PLAIN = re.compile(r"[\w@+:./\\-]+", re.ASCII)  # safe unquoted in PowerShell and cmd


def quoted(words: Sequence[str], windows: bool = sys.platform == "win32") -> str:
    r"""A command line for a POSIX shell, or for PowerShell with `windows`.

    In PowerShell a quoted program name would not run, so the program's name should need no quotes. Line
    breaks and control characters are escaped as in $'\012' on POSIX; Windows has no such file names. In cmd,
    which does not understand single quotes, names with spaces need double quotes instead.
    """
    return " ".join(_windows_word(word) if windows else _word(word) for word in words)


def _word(word: str) -> str:
    if _PLAIN.fullmatch(word):
        return word
    if all(map(str.isprintable, word)):
        return shlex.quote(word)
    escaped = word.replace("\\", "\\\\").replace("'", "\\'")
    return "$'" + "".join(map(_escaped, escaped)) + "'"


def _escaped(character: str) -> str:
    """Escape a character for $'…' (bash, zsh, POSIX 2024): each byte in octal if it is not printable."""
    if character.isprintable():
        return character
    how = "surrogateescape" if "\udc80" <= character <= "\udcff" else "surrogatepass"
    return "".join(f"\\{byte:03o}" for byte in character.encode("utf-8", how))


def _windows_word(word: str) -> str:
    if _WINDOWS_PLAIN.fullmatch(word) and not word.startswith("@"):
        return word
    return "'" + word.replace("'", "''") + "'"
