# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lines of a GLSL shader its conditions leave, and how often these look a texture up."""

from __future__ import annotations

import re
from collections.abc import Mapping

_CONDITION = re.compile(r"defined\((\w+)\)|(\w+) (==|<|>) (\d+)|(\w+)")
_FUNCTION = re.compile(r"^\w+ (\w+)\([^)]*\) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
_LOOP = re.compile(r"^( *)for \(int \w+ = 0; \w+ < (\w+); \w+\+\+\) \{(.*?)^\1\}", re.MULTILINE | re.DOTALL)
_FETCH = re.compile(r"\b(?:texture|textureLod|texelFetch)\s*\(")


def chosen(source: str, defines: Mapping[str, int]) -> str:
    """The lines of a shader that its #if, #ifdef, #ifndef, #else and #endif leave; it may define more.

    Raises ValueError for other conditions.
    """
    kept, open_now, known = [], [True], dict(defines)
    for line in source.splitlines():
        word, _, condition = line.partition("//")[0].strip().partition(" ")
        if word in ("#ifdef", "#if"):
            open_now.append(any(_holds(part.strip(), known) for part in condition.split("||")))
        elif word == "#ifndef":
            open_now.append(condition.strip() not in known)
        elif word == "#else":
            open_now[-1] = not open_now[-1]
        elif word == "#endif":
            open_now.pop()
        elif word.startswith(("#if", "#el")):
            raise ValueError(f"{word}: not known here")
        elif all(open_now):
            kept.append(line.partition("//")[0])
            if word == "#define":
                name, _, value = condition.partition(" ")
                known[name] = int(value or 1)
    return "\n".join(kept)


def fetches(source: str, defines: Mapping[str, int], function: str) -> int:
    """How many texture lookups a function of a shader makes, those of all functions that it calls included.

    Its loops run from 0 to a number or a definition.
    """
    known = dict(re.findall(r"^#define (\w+) (\d+)$", source, re.MULTILINE))
    known |= {name: str(value) for name, value in defines.items()}
    bodies = dict(_FUNCTION.findall(chosen(source, defines)))

    def counted(text: str) -> int:
        total = 0
        for _, end, body in _LOOP.findall(text):
            if inside := counted(body):
                total += int(known.get(end, end)) * inside
        text = _LOOP.sub("", text)
        calls = sum(counted(bodies[name]) for name in re.findall(r"\b(\w+)\(", text) if name in bodies)
        return total + len(_FETCH.findall(text)) + calls

    return counted(bodies[function])


def _holds(condition: str, defines: Mapping[str, int]) -> bool:
    found = _CONDITION.fullmatch(condition)
    if found is None:
        raise ValueError(f"#if {condition}: not known here")
    defined, name, sign, number, alone = found.groups()
    if name is None:
        return (defined or alone) in defines
    value = defines.get(name, 0)
    return {"==": value == int(number), "<": value < int(number), ">": value > int(number)}[sign]
