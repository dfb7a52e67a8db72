# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names from scenes and files as text: in terminals, in commands for shells, and in generated files.

A name may have quotes, line ends, what some languages take for line ends, as C# does U+2028, and terminal
control characters. Whatever is in it, no line, string or comment ends by it.
"""

from __future__ import annotations

import json
import re
import shlex
import sys
import unicodedata
from collections.abc import Sequence

_PLAIN = re.compile(r"[\w@%+=:,./-]+", re.ASCII)  # safe unquoted in POSIX shells, as in shlex
_WINDOWS_PLAIN = re.compile(r"[\w@+:./\\-]+", re.ASCII)  # safe unquoted in PowerShell and cmd
# Control characters, lone surrogates, line and paragraph separators, and invisible format characters (which
# can reverse the direction of text, so that a name looks like another).
_UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}
_JOINERS = "\u200c\u200d"  # invisible too, but some scripts and emojis need them


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


def printable(text: str) -> str:
    r"""The text as one line: line breaks, control and direction characters are escaped, such as \x1b."""
    if text.isprintable():
        return text
    return "".join(map(_shown, text))


def _shown(character: str) -> str:
    if character.isprintable() or character in _JOINERS or unicodedata.category(character) not in _UNSEEN:
        return character
    return character.encode("unicode_escape").decode()


def printable_json(text: str) -> str:
    r"""JSON text as one line: the same characters as JSON escapes such as \u001b; its value stays."""
    if text.isprintable():
        return text
    return "".join(
        one if _shown(one) == one else "".join(f"\\u{unit:04x}" for unit in _units(one)) for one in text
    )


def _units(character: str) -> list[int]:
    data = character.encode("utf-16-be", "surrogatepass")
    return [int.from_bytes(data[place : place + 2], "big") for place in range(0, len(data), 2)]


def in_comment(text: str) -> str:
    """One line of a comment or a README. No backslash ends it: in HLSL the next line would belong to it."""
    line = printable(text)
    return f"{line}." if line.endswith("\\") else line


def csharp_string(text: str) -> str:
    """A string of C#, with its quotes. JSON's are, too, but for characters that C# takes for line ends."""
    return printable_json(json.dumps(text, ensure_ascii=False))


def godot_string(text: str) -> str:
    """A string in GDScript and in Godot's files (.tscn, .tres, project.godot), with its quotes."""
    return printable_json(json.dumps(text, ensure_ascii=False))


def python_string(text: str) -> str:
    """A string of Python, with its quotes."""
    return repr(text)


def yaml_string(text: str) -> str:
    """A string of YAML, with its quotes. Unlike JSON it has no pairs of surrogates."""
    return '"' + "".join(map(_in_yaml, text)) + '"'


def _in_yaml(character: str) -> str:
    if character in '"\\':
        return f"\\{character}"
    return character if printable(character) == character else f"\\U{ord(character):08x}"


def shaderlab_string(text: str) -> str:
    """A string of Unity's ShaderLab, with its quotes: it has no escapes, so quotes become single ones."""
    return '"' + printable(text).replace('"', "'").replace("\\", "/") + '"'
