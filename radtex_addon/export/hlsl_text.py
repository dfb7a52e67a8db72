# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lookups in HLSL as text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..formats.containers.glb import Glb
from ..forms.hlsl_lookup import Number
from ..scene.mesh.copy import MATERIAL


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
    return {each["name"]: each.get("extras", {}).get(MATERIAL, 0) for each in glb.document["materials"]}


def is_clear(glb: Glb) -> bool:
    """Whether something of the surface lets what is behind it be seen."""
    return any(each.get("alphaMode") == "BLEND" for each in glb.document["materials"])


def indented(text: str, depth: int = 4) -> str:
    """Lines that begin so many spaces farther in."""
    return "\n".join(f"{' ' * depth}{line}" if line else line for line in text.removesuffix("\n").split("\n"))
