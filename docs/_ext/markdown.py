# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain text of the program as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|$~])")
_CODE = re.compile(r"(?<![\w-])(--[a-z][a-z-]*|(?:DIR|OUT)/[\w.+-]*\w|-b -P \S+)")


def escaped(text: str) -> str:
    """Plain text as Markdown that shows just that."""
    return escaped_inline(text.strip())


def escaped_inline(text: str) -> str:
    """A part of a line, the same; spaces at its ends stay."""
    return _SPECIAL.sub(r"\\\1", text)


def worded(text: str) -> str:
    """Plain text in which options and file names are set as code."""
    parts = _CODE.split(text.strip())  # every other one is code
    return "".join(code(part) if k % 2 else escaped_inline(part) for k, part in enumerate(parts))


def code(text: str) -> str:
    """Text as code."""
    return f"`` {text} ``" if "`" in text else f"`{text}`"


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A table; cells are Markdown, without line breaks."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"
