# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench's results: a table, JSON, and a strip of pictures for each scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from radtex_addon.report.metrics import Picture, display
from tests.bench.fidelity.report import markdown, tile

LOOKUP = "reference lookup"
SHOWN_BY = ("Chromium", "Godot", "Eevee", "Cycles")
_FIGURES = (LOOKUP, *SHOWN_BY)
_HEAD = ("scene", *_FIGURES, "web, MB", "Godot, MB", "bake, s")


@dataclass(frozen=True)
class Row:
    """A scene's figures: mean `decibels` by what shows the bake, and what bake and exports took."""

    decibels: Mapping[str, float]
    layout: str
    web_bytes: int
    godot_bytes: int
    seconds: float

    @property
    def worst(self) -> float:
        return min(self.decibels.values())


def table(rows: Mapping[str, Row]) -> str:
    """The scenes in Markdown, the worst first, and the mean of all."""
    lines = [list(_HEAD), ["---"] * len(_HEAD)]
    for name, row in sorted(rows.items(), key=lambda item: item[1].worst):
        decibels = (f"{row.decibels[each]:.1f}" if each in row.decibels else "" for each in _FIGURES)
        sizes = (f"{size / 1e6:.2f}" for size in (row.web_bytes, row.godot_bytes))
        lines.append([name, *decibels, *sizes, f"{row.seconds:.0f}"])
    lines.append([f"mean of {len(rows)}", *_means(list(rows.values()))])
    return markdown(lines) + "\n"


def save_strip(
    path: Path, views: Sequence[Mapping[str, Picture]], labels: Sequence[Mapping[str, str]]
) -> None:
    """Save a row of linear pictures (P, P, 3) for each view, under labels; all views have the same names."""
    rows = [
        np.concatenate([tile(display(picture), texts[name]) for name, picture in pictures.items()], axis=1)
        for pictures, texts in zip(views, labels, strict=True)
    ]
    Image.fromarray(np.concatenate(rows, axis=0)).save(path, optimize=True)


def _means(rows: Sequence[Row]) -> list[str]:
    every = [[row.decibels[each] for row in rows if each in row.decibels] for each in _FIGURES]
    decibels = [f"{np.mean(found):.1f}" if found else "" for found in every]
    sizes = np.mean([[row.web_bytes / 1e6, row.godot_bytes / 1e6] for row in rows], axis=0)
    return [*decibels, *(f"{size:.2f}" for size in sizes), f"{np.mean([row.seconds for row in rows]):.0f}"]
