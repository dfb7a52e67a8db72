# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that drive terminals or turn text around are shown, not obeyed; letters of any script stay."""

from __future__ import annotations

import json
import sys

import pytest

from radtex_addon.core.printable import printable, printable_json

_HOSTILE = [
    "\x1b[2J",
    "\x9b31m",
    "\r",
    "\n",
    "\a",
    "\x7f",
    "\u202egnp.exe",
    "\u2066",
    "\u200f",
    "\u2028",
    "\ud800",
]
_HARMLESS = ["Väse 花瓶", "👩‍🚀", "می‌خواهم", "a\u00a0b", "C:\\new"]


@pytest.mark.parametrize("name", _HOSTILE)
def test_what_drives_a_terminal_is_escaped(name: str) -> None:
    said = printable(f"object '{name}'")
    assert name[0] not in said
    assert said.isprintable()
    spelt = printable_json(json.dumps({"object": name}, ensure_ascii=False))
    assert spelt.isprintable()
    assert json.loads(spelt) == {"object": name}


@pytest.mark.parametrize("name", _HARMLESS)
def test_letters_of_all_scripts_stay(name: str) -> None:
    assert printable(name) == name
    assert printable_json(json.dumps(name, ensure_ascii=False)) == json.dumps(name, ensure_ascii=False)


def test_every_character_is_told_in_json_as_it_is() -> None:
    everything = "".join(map(chr, range(sys.maxunicode + 1)))
    spelt = printable_json(json.dumps(everything, ensure_ascii=False))
    assert spelt.encode("utf-8").decode() == spelt
    assert json.loads(spelt) == everything.encode("utf-16", "surrogatepass").decode("utf-16", "surrogatepass")
