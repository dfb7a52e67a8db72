# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shaders' reference, from the comments of the GLSL includes."""

from __future__ import annotations

import re
from pathlib import Path

_SHADERS = Path(__file__).resolve().parents[2] / "shaders"
_FUNCTION = re.compile(
    r"(?P<comment>(?:^//.*\n)+)"
    r"(?P<signature>^(?:float|i?vec[234]|mat[34]|bool|int|void|Radtex\w+) \w+\([^{;]*\)) ?\{",
    re.MULTILINE,
)


def shader(name: str) -> str:
    """An include: the comment at its top, and every function that has one, with its signature."""
    text = (_SHADERS / name).read_text(encoding="utf-8")
    parts = [f"```text\n{_head(text)}\n```\n"]
    for found in _FUNCTION.finditer(text):
        told = " ".join(line.removeprefix("//").strip() for line in found["comment"].splitlines())
        parts.append(f"```glsl\n// {told}\n{found['signature']}\n```\n")
    return "\n".join(parts)


def _head(text: str) -> str:
    """The comment at the top, without its slashes and the licence."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        lines.append(line.removeprefix("//").removeprefix(" "))
    return "\n".join(line for line in lines if not line.startswith("SPDX-")).strip()
