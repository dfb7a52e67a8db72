# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make text with foreign names safe to print: a name may contain terminal control characters."""

from __future__ import annotations

import unicodedata

# Control characters, lone surrogates, line and paragraph separators, and invisible format characters (which
# can reverse the direction of text, so that a name looks like another).
_UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}
_JOINERS = "\u200c\u200d"  # invisible too, but some scripts and emojis need them


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
