# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Text that quotes names which others chose, made safe to show: names may hold what drives a terminal."""

from __future__ import annotations

import unicodedata

# Control characters, lone surrogates, ends of lines and paragraphs, and what formats without being seen: that
# lets text run from right to left, so that a name reads as another.
_UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}
_JOINERS = "\u200c\u200d"  # which scripts and emojis are written with


def printable(text: str) -> str:
    r"""The text as one line: what would end it, drive a terminal or turn it around is written as \x1b is."""
    if text.isprintable():
        return text
    return "".join(map(_shown, text))


def _shown(character: str) -> str:
    if character.isprintable() or character in _JOINERS or unicodedata.category(character) not in _UNSEEN:
        return character
    return character.encode("unicode_escape").decode()


def printable_json(text: str) -> str:
    r"""JSON in one line, whose strings hold such characters as \u001b: it says the same."""
    if text.isprintable():
        return text
    return "".join(
        one if _shown(one) == one else "".join(f"\\u{unit:04x}" for unit in _units(one)) for one in text
    )


def _units(character: str) -> list[int]:
    data = character.encode("utf-16-be", "surrogatepass")
    return [int.from_bytes(data[place : place + 2], "big") for place in range(0, len(data), 2)]
