# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured cells: one method's bake of one scene with one seed, kept in a file so that a run can go on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from radtex_addon.formats.disk.atomic import replacing


@dataclass(frozen=True, order=True)
class Key:
    """What was measured. What is not baked, and a reference of another seed, has no texels and no samples."""

    texels: int
    samples: int
    scene: str
    method: str
    seed: int


@dataclass(frozen=True)
class Cell:
    """The figures of a key: `bytes` on a GPU, `paths` and `seconds` of the bake, and of each view.

    `views` has PSNR in dB, FLIP and energy by the view's name, inside the object's eroded mask; `spent` is
    the wall time in seconds of baking, looking and comparing.
    """

    key: Key
    bytes: int
    paths: int
    seconds: float
    spent: float
    views: dict[str, dict[str, float]]

    def mean(self, figure: str) -> float:
        """The mean of a figure over the views."""
        return sum(view[figure] for view in self.views.values()) / len(self.views)

    def worst(self) -> float:
        """The PSNR of the worst view."""
        return min(view["psnr"] for view in self.views.values())


class Cells:
    """The cells in a JSON file, one a line, sorted."""

    def __init__(self, path: Path) -> None:
        self.path = path
        found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
        self._cells = {cell.key: cell for cell in map(_read, found)}

    def __contains__(self, key: Key) -> bool:
        return key in self._cells

    def __iter__(self) -> Iterator[Cell]:
        return iter([self._cells[key] for key in sorted(self._cells)])

    def add(self, *cells: Cell) -> None:
        """Keep cells, in the file, too, at once."""
        self._cells |= {cell.key: cell for cell in cells}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        lines = ",\n".join(json.dumps(_written(cell)) for cell in self)
        with replacing(self.path) as beside:
            beside.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def _written(cell: Cell) -> dict[str, Any]:
    facts = asdict(cell)
    key: dict[str, Any] = facts.pop("key")
    return key | facts


def _read(facts: dict[str, Any]) -> Cell:
    key = Key(**{name: facts.pop(name) for name in ("texels", "samples", "scene", "method", "seed")})
    return Cell(key, **facts)
