# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Splitting a surface into parts with an atlas each, and the numbers of UDIM tiles."""

from __future__ import annotations

from enum import StrEnum


class Split(StrEnum):
    """How to split a surface into parts, each with an atlas of its own."""

    MATERIAL = "material"
    UDIM = "udim"


FIRST_TILE = 1001  # UDIM's number for u and v from 0 to 1
_TILES_A_ROW = 10
_ROWS = 100


def tile_name(column: int, row: int) -> str:
    """A UDIM tile's number as text: 1001 + column + 10 row. Raises ValueError where there is no such tile."""
    if not (0 <= column < _TILES_A_ROW and 0 <= row < _ROWS):
        raise ValueError(f"UDIM has no tile in column {column}, row {row}")
    return str(FIRST_TILE + column + _TILES_A_ROW * row)


def tile_place(name: str) -> tuple[int, int]:
    """The column and row of a UDIM tile: the whole numbers at which its u and v begin."""
    row, column = divmod(int(name) - FIRST_TILE, _TILES_A_ROW)
    return column, row
