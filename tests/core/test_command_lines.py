# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A command that a message shows calls what is meant, whatever the names in it hold."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from radtex_addon.core.command_lines import quoted
from radtex_addon.core.errors import InputError

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
