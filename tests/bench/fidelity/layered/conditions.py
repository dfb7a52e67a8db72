# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lines of a GLSL shader its conditions leave, so that its texture lookups can be counted."""

from __future__ import annotations

import re
from collections.abc import Mapping

_CONDITION = re.compile(r"defined\((\w+)\)|(\w+) (==|<|>) (\d+)|(\w+)")


def chosen(source: str, defines: Mapping[str, int]) -> str:
    """The lines of a shader that its #if, #ifdef, #else and #endif leave. Raises ValueError for others."""
    kept, open_now = [], [True]
    for line in source.splitlines():
        word, _, condition = line.partition("//")[0].strip().partition(" ")
        if word in ("#ifdef", "#if"):
            open_now.append(any(_holds(part.strip(), defines) for part in condition.split("||")))
        elif word == "#else":
            open_now[-1] = not open_now[-1]
        elif word == "#endif":
            open_now.pop()
        elif word.startswith(("#if", "#el")):
            raise ValueError(f"{word}: not known here")
        elif all(open_now):
            kept.append(line.partition("//")[0])
    return "\n".join(kept)


def _holds(condition: str, defines: Mapping[str, int]) -> bool:
    found = _CONDITION.fullmatch(condition)
    if found is None:
        raise ValueError(f"#if {condition}: not known here")
    defined, name, sign, number, alone = found.groups()
    if name is None:
        return (defined or alone) in defines
    value = defines.get(name, 0)
    return {"==": value == int(number), "<": value < int(number), ">": value > int(number)}[sign]
