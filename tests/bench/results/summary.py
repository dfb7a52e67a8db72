# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells summed up: means over scenes and views, and how far bake seeds spread them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from statistics import mean, stdev

from .cells import Cell
from .matrix import NOTHING, TITLES, Setting


@dataclass(frozen=True)
class Spread:
    """A mean over seeds, and the sample standard deviation, None of a single seed."""

    mean: float
    deviation: float | None

    @classmethod
    def of(cls, values: Iterable[float]) -> Spread:
        """Of one value for each seed."""
        found = list(values)
        return cls(round(mean(found), 4), round(stdev(found), 4) if len(found) > 1 else None)

    def text(self, digits: int) -> str:
        """The mean ± the deviation."""
        told = f"{self.mean:.{digits}f}"
        return told if self.deviation is None else f"{told} ± {self.deviation:.{digits}f}"


@dataclass(frozen=True)
class Row:
    """A method at a setting: of each seed the mean over all scenes and views, and its spread over seeds.

    `worst_scene` is the PSNR of the scene that it shows worst, `worst_view` that of the worst view, both
    means over seeds. `megabytes`, `million_paths` and `seconds` are means over scenes and seeds.
    """

    method: str
    texels: int
    samples: int
    scenes: int
    seeds: int
    psnr: Spread
    flip: Spread
    energy: Spread
    worst_scene: float
    worst_view: float
    megabytes: float
    million_paths: float
    seconds: float


def rows_of(cells: Iterable[Cell], setting: Setting, scenes: list[str]) -> list[Row]:
    """A row for each method, best first; of the seeds that all `scenes` have."""
    every = list(cells)
    rows = []
    for method in TITLES:
        own = [cell for cell in every if cell.key.method == method and _at(cell, setting)]
        by_seed = {
            seed: [cell for cell in own if cell.key.seed == seed and cell.key.scene in scenes]
            for seed in sorted({cell.key.seed for cell in own})
        }
        whole = [found for found in by_seed.values() if len(found) == len(scenes)]
        if whole:
            rows.append(_row(method, setting, whole))
    return sorted(rows, key=lambda row: -row.psnr.mean)


def scene_spread(cells: Iterable[Cell], setting: Setting, scene: str, method: str) -> Spread | None:
    """A scene's PSNR by a method, over all seeds that were measured; None without any."""
    wanted = scene, method
    found = [c.mean("psnr") for c in cells if (c.key.scene, c.key.method) == wanted and _at(c, setting)]
    return Spread.of(found) if found else None


def seeds_of(cells: Iterable[Cell], setting: Setting, scene: str) -> int:
    """With how many seeds the default was baked in a scene."""
    wanted = scene, "layered"
    return sum((c.key.scene, c.key.method) == wanted and _at(c, setting) for c in cells)


def _at(cell: Cell, setting: Setting) -> bool:
    return Setting(cell.key.texels, cell.key.samples) in {setting, NOTHING}


def _row(method: str, setting: Setting, whole: list[list[Cell]]) -> Row:
    every = [cell for cells in whole for cell in cells]

    def spread(figure: str) -> Spread:
        return Spread.of(mean(cell.mean(figure) for cell in cells) for cells in whole)

    return Row(
        method=method,
        texels=setting.texels,
        samples=setting.samples,
        scenes=len(whole[0]),
        seeds=len(whole),
        psnr=spread("psnr"),
        flip=spread("flip"),
        energy=spread("energy"),
        worst_scene=round(mean(min(cell.mean("psnr") for cell in cells) for cells in whole), 3),
        worst_view=round(mean(min(cell.worst() for cell in cells) for cells in whole), 3),
        megabytes=round(mean(cell.bytes for cell in every) / 1e6, 4),
        million_paths=round(mean(cell.paths for cell in every) / 1e6, 4),
        seconds=round(mean(cell.seconds for cell in every), 1),
    )
