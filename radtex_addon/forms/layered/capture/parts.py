# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a layered bake's captures, which machines of a farm can make by themselves."""

from __future__ import annotations

from enum import StrEnum


class Part(StrEnum):
    """A part; the names of its pieces begin with it, but those of MAPS, which comes before all others.

    LIGHT, ENDS and MORE_LIGHT are many pieces, and can be shared out.
    """

    MAPS = "maps"
    ENDS = "ends"
    LIGHT = "light"
    MORE_LIGHT = "more-light"
    OWN = "own"
    AROUND = "around"
    EXITS = "exits"
    MISLED = "misled"

    @property
    def is_shared(self) -> bool:
        """Whether several tasks can make a share of its pieces each."""
        return self in (Part.ENDS, Part.LIGHT, Part.MORE_LIGHT)


def part_of(piece: str) -> Part:
    """The part that a piece of this name is of."""
    named = [part for part in Part if piece == part or piece.startswith(f"{part}-")]
    return max(named, key=len, default=Part.MAPS)
