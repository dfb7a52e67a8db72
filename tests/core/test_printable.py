# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names are shown in one line, not obeyed, and quoted so that each reads back what it was; letters stay."""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys

import pytest

from radtex_addon.core.errors import BakeError, FormatError, InputError, ShapeError
from radtex_addon.core.quoting import (
    csharp_string,
    godot_string,
    in_comment,
    printable,
    printable_json,
    python_string,
    quoted,
    shaderlab_string,
    yaml_string,
)

_HOSTILE = (
    *("\x1b[2J", "\x9b31m", "\r", "\n", "\a", "\x7f", "\0", "\x85"),
    *("\u202egnp.exe", "\u2066", "\u200f", "\u2028", "\u2029", "\ud800"),
)

_HARMLESS = ["Väse 花瓶", "👩‍🚀", "می‌خواهم", "a\u00a0b", "C:\\new"]


@pytest.mark.parametrize("name", _HOSTILE)
def test_what_drives_a_terminal_is_escaped(name: str) -> None:
    said = printable(f"object '{name}'")
    assert name[0] not in said
    assert said.isprintable()
    assert {str(kind(f"object '{name}'")) for kind in (BakeError, FormatError, InputError, ShapeError)} == {
        said
    }
    spelt = printable_json(json.dumps({"object": name}, ensure_ascii=False))
    assert spelt.isprintable()
    assert json.loads(spelt) == {"object": name}


@pytest.mark.parametrize("name", _HARMLESS)
def test_letters_of_all_scripts_stay(name: str) -> None:
    assert printable(name) == str(InputError(name)) == name
    assert printable_json(json.dumps(name, ensure_ascii=False)) == json.dumps(name, ensure_ascii=False)


def test_every_character_is_told_in_json_as_it_is() -> None:
    everything = "".join(map(chr, range(sys.maxunicode + 1)))
    spelt = printable_json(json.dumps(everything, ensure_ascii=False))
    assert spelt.encode("utf-8").decode() == spelt
    assert json.loads(spelt) == everything.encode("utf-16", "surrogatepass").decode("utf-16", "surrogatepass")


def test_of_an_endless_message_the_beginning_and_the_end_stay() -> None:
    said = str(InputError(f"--seed {'9' * 100_000}: give a whole number"))
    assert said.startswith("--seed 999")
    assert said.endswith("9: give a whole number")
    assert len(said) == 5001
    assert str(InputError("a\nb\r \x1b[31m \0\u2028 \ud800")) == r"a\nb\r \x1b[31m \x00\u2028 \ud800"


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
    for string, read in (
        (csharp_string(name), json.loads),  # whose escapes C# and Godot have, too
        (godot_string(name), json.loads),
        (python_string(name), ast.literal_eval),
        (yaml_string(name), yaml_read),
    ):
        assert read(string) == name
        assert in_comment(string).rstrip(".") == string.rstrip(".")  # nothing is left to escape


@pytest.mark.parametrize("name", NAMES)
def test_comments_and_titles_are_one_line(name: str) -> None:
    comment, title = in_comment(name), shaderlab_string(name)
    assert len(comment.splitlines()) == len(title.splitlines()) == 1
    assert not comment.endswith("\\")
    assert title[0] == title[-1] == '"'
    assert '"' not in title[1:-1]
    assert "\\" not in title


_ODD = [
    *(
        "plain-1.2/x",
        "a b",
        "",
        "$(touch /tmp/x)",
        "`id`",
        "'; rm -rf ~ #",
        'say "it"',
        "a\\b",
        "*",
        "~",
        "!!",
    ),
    *("-f", "3,7..9", "Väse 花", "a\nb", "\x1b[31m", "it's\r\n\\", "\u202ex", "&& :", "\udcff"),
]


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no shell of POSIX")
@pytest.mark.parametrize("word", _ODD)
def test_a_shell_reads_the_word_that_was_meant(word: str) -> None:
    line = quoted(["printf", "%s", word], windows=False)
    assert line.isprintable()
    assert str(InputError(line)) == line
    ended = subprocess.run(["bash", "-c", line], capture_output=True, check=True)
    if word != "-f":  # to printf, too, an option
        assert ended.stdout == word.encode("utf-8", "surrogateescape")


@pytest.mark.parametrize(
    ("word", "said"),
    [
        (r"C:\farm\x.blend", r"C:\farm\x.blend"),
        (r"C:\my farm\x.blend", r"'C:\my farm\x.blend'"),
        ("it's", "'it''s'"),
        ("$(calc)", "'$(calc)'"),
        ("3,7..9", "'3,7..9'"),
        ("@file", "'@file'"),
        ("a & b", "'a & b'"),
        ("%PATH%", "'%PATH%'"),
        ("", "''"),
    ],
)
def test_powershell_is_given_single_quotes(word: str, said: str) -> None:
    assert quoted(["blender", word], windows=True) == f"blender {said}"
