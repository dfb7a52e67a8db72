# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which surfaces an atlas is of: several objects' together, or a part of one's."""

from __future__ import annotations

from enum import StrEnum


class Split(StrEnum):
    """What gives a part of the surface an atlas of its own."""

    MATERIAL = "material"
    UDIM = "udim"


FIRST_TILE = 1001  # of UDIM: u and v from 0 to 1
_TILES_A_ROW = 10
_ROWS = 100


def tile_name(column: int, row: int) -> str:
    """A UDIM tile's number, as a word: 1001 + column + 10 row. Raises ValueError where there is none."""
    if not (0 <= column < _TILES_A_ROW and 0 <= row < _ROWS):
        raise ValueError(f"UDIM has no tile in column {column}, row {row}")
    return str(FIRST_TILE + column + _TILES_A_ROW * row)


def tile_place(name: str) -> tuple[int, int]:
    """The column and row of a UDIM tile: whole numbers that its u and v begin at."""
    row, column = divmod(int(name) - FIRST_TILE, _TILES_A_ROW)
    return column, row
