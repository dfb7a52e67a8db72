# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page shows the kinds that the table exports to it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from radtex_addon.bake.kinds import KINDS, Light

pytestmark = pytest.mark.one_blender
SOURCE = Path(__file__).resolve().parents[2] / "shaders/three/src/kinds.ts"


def test_the_page_has_the_tables_kinds() -> None:
    text = SOURCE.read_text(encoding="utf-8")
    (union,) = re.findall(r"export type Kind = ([^;]*);", text)
    assert re.findall(r'"(\w+)"', union) == [kind for kind, row in KINDS.items() if "web" in row.exports]


def test_the_page_lights_what_depends_on_lamps() -> None:
    """Only these kinds have a sun, whose direction is looked up."""
    text = SOURCE.read_text(encoding="utf-8")
    lit = re.findall(r'^  (\w+): {[^}]*way: "L"', text, flags=re.MULTILINE)
    answers = [
        kind for kind, row in KINDS.items() if row.light is Light.RESPONSE or row.include == "radtex_shadow"
    ]
    assert sorted(lit) == sorted(answers)
