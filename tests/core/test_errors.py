# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A message is one line of bounded length, whatever names it quotes; letters of any script stay."""

from __future__ import annotations

import pytest

from radtex_addon.core.errors import BakeError, FormatError, InputError, ShapeError


@pytest.mark.parametrize("kind", [BakeError, FormatError, InputError, ShapeError])
@pytest.mark.parametrize(
    ("quoted", "said"),
    [
        ("a\nb\r", r"a\nb\r"),
        ("\x1b[31mred", r"\x1b[31mred"),
        ("\0\x85\u2028\u2029", r"\x00\x85\u2028\u2029"),
        ("\ud800", r"\ud800"),
        ("Väse 花瓶 👩‍🚀 \u00a0 C:\\new", "Väse 花瓶 👩‍🚀 \u00a0 C:\\new"),
    ],
)
def test_what_ends_a_line_or_drives_a_terminal_is_escaped(
    kind: type[InputError], quoted: str, said: str
) -> None:
    assert str(kind(f"object '{quoted}': name another")) == f"object '{said}': name another"


def test_of_an_endless_message_the_beginning_and_the_end_stay() -> None:
    said = str(InputError(f"--seed {'9' * 100_000}: give a whole number"))
    assert said.startswith("--seed 999")
    assert said.endswith("9: give a whole number")
    assert len(said) == 5001
