# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands in messages, so that a shell into which they are copied calls what is meant, and nothing else."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Sequence

_PLAIN = re.compile(r"[\w@%+=:,./-]+", re.ASCII)  # what no shell of POSIX looks at, as shlex has it
_WINDOWS_PLAIN = re.compile(r"[\w@+:./\\-]+", re.ASCII)  # of what neither PowerShell nor cmd looks at


def quoted(words: Sequence[str], windows: bool = sys.platform == "win32") -> str:
    r"""A line for a shell: POSIX's, or `windows`'s PowerShell, where the program's name stays bare.

    What would end a line, or drive a terminal, is $'\012' and the like on POSIX; Windows has no such file
    names. cmd, the older shell there, knows no single quotes: in it, names with spaces want double ones.
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
    """A character as bash's, zsh's and POSIX 2024's $'…' has it, byte by byte if it is not printable."""
    if character.isprintable():
        return character
    how = "surrogateescape" if "\udc80" <= character <= "\udcff" else "surrogatepass"
    return "".join(f"\\{byte:03o}" for byte in character.encode("utf-8", how))


def _windows_word(word: str) -> str:
    if _WINDOWS_PLAIN.fullmatch(word) and not word.startswith("@"):
        return word
    return "'" + word.replace("'", "''") + "'"
