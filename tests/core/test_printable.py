# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that drive terminals or turn text around are shown, not obeyed; letters of any script stay.

A message is one line of bounded length, whatever names it quotes.
"""

from __future__ import annotations

import json
import sys

import pytest

from radtex_addon.core.errors import BakeError, FormatError, InputError, ShapeError
from radtex_addon.core.printable import printable, printable_json

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
