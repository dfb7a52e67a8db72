# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shaders' reference, from the comments of the GLSL includes."""

from __future__ import annotations

import re
from pathlib import Path

from .markdown import code, escaped_inline

_SHADERS = Path(__file__).resolve().parents[2] / "shaders"
_FUNCTION = re.compile(
    r"(?P<comment>(?:^//.*\n)+)"
    r"(?P<signature>^(?:float|i?vec[234]|mat[34]|bool|int|void|Radtex\w+) \w+\([^{;]*\)) ?\{",
    re.MULTILINE,
)


def shader(name: str) -> str:
    """An include: the comment at its top, and every function that has one, with its signature."""
    text = (_SHADERS / name).read_text(encoding="utf-8")
    parts = [f"{_head(text)}\n"]
    for found in _FUNCTION.finditer(text):
        told = " ".join(line.removeprefix("//").strip() for line in found["comment"].splitlines())
        parts.append(f"```glsl\n{found['signature']}\n```\n\n{_prose(told)}\n")
    return "\n".join(parts)


def _head(text: str) -> str:
    """The comment at the top as Markdown, without licence and origin; what is indented in it is code."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        told = line.removeprefix("//").removeprefix(" ")
        if not told.startswith(("SPDX-", "Written by ")):
            lines.append(told if told.startswith("    ") else _prose(told))
    return "\n".join(lines).strip()


def _prose(text: str) -> str:
    """A comment's text, in which names stand between backticks, as Markdown."""
    parts = text.split("`")  # every other one is code
    return "".join(code(part) if k % 2 else escaped_inline(part) for k, part in enumerate(parts))
