# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts tables and sentences with figures into docs/results.md, between marks that name them.

A block is what lies between `<!-- NAME: written by tests.bench.results -->` and `<!-- end of NAME -->`. All
other text of the page's first part is written by hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from radtex_addon.core.errors import InputError
from radtex_addon.formats.disk.atomic import replacing

PAGE = Path(__file__).parents[3] / "docs" / "results.md"
_BEGIN = r"(?P<begin><!-- (?P<name>[\w-]+): written by tests\.bench\.results -->\n)"
_BLOCK = re.compile(_BEGIN + r".*?(?P<end><!-- end of (?P=name) -->)", re.DOTALL)


def filled(text: str, blocks: Mapping[str, str]) -> str:
    """The text with new blocks; those that are not given stay.

    Raises InputError for blocks that the text has no place for.
    """
    lost = sorted(set(blocks) - {found["name"] for found in _BLOCK.finditer(text)})
    if lost:
        raise InputError(f"the page has no place for {', '.join(lost)}")

    def new(found: re.Match[str]) -> str:
        block = blocks.get(found["name"])
        return found[0] if block is None else f"{found['begin']}\n{block.strip()}\n\n{found['end']}"

    return _BLOCK.sub(new, text)


def write(blocks: Mapping[str, str]) -> None:
    """Write the blocks into the page."""
    text = filled(PAGE.read_text(encoding="utf-8"), blocks)
    with replacing(PAGE) as beside:
        beside.write_text(text, encoding="utf-8")
