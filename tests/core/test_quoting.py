# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names as strings of other languages: each reads back what it was, from one line."""

from __future__ import annotations

import ast
import json
import re

import pytest

from radtex_addon.core.quoting import (
    csharp_string,
    godot_string,
    in_comment,
    python_string,
    shaderlab_string,
    yaml_string,
)

NAMES = [
    "Vase",
    'A "vase"',
    "C:\\new\\vase\\",
    "one\ntwo\r\nthree",
    "one\u2028two\u2029three\u0085four\x0bfive",
    "a\0b\x1b[31m",
    "\u202egnp.exe",
    "*/ // ''' \"\"\" @NAME@ {{x}} ${x} #{x} %x",
    "Väse 花瓶 👩‍🚀",
]


def yaml_read(quoted: str) -> str:
    """A string of YAML that has no other escapes than these."""

    def meant(found: re.Match[str]) -> str:
        return chr(int(found[2], 16)) if found[2] else found[1]

    return re.sub(r'\\(["\\]|U([0-9a-f]{8}))', meant, quoted[1:-1])


@pytest.mark.parametrize("name", NAMES)
def test_strings_read_back_from_one_line(name: str) -> None:
    for quoted, read in (
        (csharp_string(name), json.loads),  # whose escapes C# and Godot have, too
        (godot_string(name), json.loads),
        (python_string(name), ast.literal_eval),
        (yaml_string(name), yaml_read),
    ):
        assert read(quoted) == name
        assert in_comment(quoted).rstrip(".") == quoted.rstrip(".")  # nothing is left to escape


@pytest.mark.parametrize("name", NAMES)
def test_comments_and_titles_are_one_line(name: str) -> None:
    comment, title = in_comment(name), shaderlab_string(name)
    assert len(comment.splitlines()) == len(title.splitlines()) == 1
    assert not comment.endswith("\\")
    assert title[0] == title[-1] == '"'
    assert '"' not in title[1:-1]
    assert "\\" not in title
