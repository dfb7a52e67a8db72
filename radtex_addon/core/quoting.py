# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
r"""Names from scenes and files as text of generated files: one function for each language.

A name may have quotes, line ends, and what some languages take for line ends, as C# does U+2028. Whatever is
in it, no string, comment or line of a generated file ends by it.
"""

from __future__ import annotations

import json

from .printable import printable, printable_json


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
