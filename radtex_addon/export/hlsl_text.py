# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lookups in HLSL as text, and templates whose @WORDS@ are filled in."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from ..core.errors import BakeError
from ..formats.containers.glb import Glb
from ..forms.hlsl_lookup import Number

_LEFT = re.compile(r"@[A-Z_]+@")


def filled(template: Path, words: Mapping[str, str]) -> str:
    """The text of a template with each @WORD@ replaced by its value in `words`.

    Raises BakeError if a word is left.
    """
    text = template.read_text(encoding="utf-8")
    if unknown := {word[1:-1] for word in _LEFT.findall(text)} - set(words):
        raise BakeError(f"{template} asks for {', '.join(sorted(unknown))}: install RadTex again")
    return _LEFT.sub(lambda word: words[word[0][1:-1]], text)


def write_text_file(path: Path, text: str) -> None:
    """Write a file of the folder that is being made, in UTF-8, its lines ended as on Linux."""
    path.write_text(text, encoding="utf-8", newline="\n")


def define_lines(defines: Mapping[str, int | str]) -> str:
    """The #defines, one a line."""
    return "\n".join(f"#define {name} {value}" for name, value in defines.items())


def constant_lines(constants: Iterable[Number]) -> str:
    """Constants of a file, outside functions."""
    lines = []
    for each in constants:
        if each.count:
            rows = ",\n    ".join(each.rows)
            lines.append(f"static const {each.kind} {each.name}[{each.count}] = {{\n    {rows}\n}};")
        else:
            lines.append(f"static const {each.kind} {each.name} = {each.rows[0]};")
    return "\n".join(lines)


def material_numbers(glb: Glb) -> dict[str, int]:
    """The mesh's materials by name, in order, and the number of each among the shader's."""
    return {
        each["name"]: each.get("extras", {}).get("radtex_material", 0) for each in glb.document["materials"]
    }


def is_clear(glb: Glb) -> bool:
    """Whether something of the surface lets what is behind it be seen."""
    return any(each.get("alphaMode") == "BLEND" for each in glb.document["materials"])


def indented(text: str, depth: int = 4) -> str:
    """Lines that begin so many spaces farther in."""
    return "\n".join(f"{' ' * depth}{line}" if line else line for line in text.splitlines())
