# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench's results as tables and as sheets of pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from radtex_addon.report.metrics import Mask, Picture, display

from .metrics import Figures
from .references import View
from .scenes import PIXELS

_LABEL = 14  # pixels of a line of text
_GAIN = 4  # of an error map
_COLUMNS = ["method", "PSNR", "PSNR, uneroded", "FLIP", "HDR FLIP", "energy", "M paths", "s", "MB"]
_DIGITS = {"psnr": 2, "psnr_uneroded": 2, "flip": 3, "hdr_flip": 3, "energy": 3}


@dataclass(frozen=True, eq=False)
class Seen:
    """A method's picture of one view, and how far it is from the reference inside the masks."""

    view: View
    picture: Picture
    inside: Mask
    eroded: Mask
    figures: Figures


@dataclass(frozen=True, eq=False)
class Result:
    """One method on one scene."""

    method: str
    paths: int
    seconds: float
    bytes: int
    seen: tuple[Seen, ...]

    def mean(self, figure: str, held_out: bool) -> float:
        """The mean of a figure over the views of a sort."""
        return float(np.mean([getattr(s.figures, figure) for s in self.seen if s.view.held_out is held_out]))


def scene_table(name: str, results: Sequence[Result], floor: Figures) -> str:
    """A scene's table in Markdown; with views to tune on, "a / b" are tuned and untuned views."""
    rows = [_COLUMNS, ["---"] * len(_COLUMNS)]
    sorts = sorted({seen.view.held_out for seen in results[0].seen})
    for result in results:
        pairs = [
            " / ".join(f"{result.mean(figure, held_out):.{digits}f}" for held_out in sorts)
            for figure, digits in _DIGITS.items()
        ]
        spent = f"{result.paths / 1e6:.2f}", f"{result.seconds:.0f}", f"{result.bytes / 1e6:.2f}"
        rows.append([result.method, *pairs, *spent])
    figures = (f"{getattr(floor, figure):.{digits}f}" for figure, digits in _DIGITS.items())
    rows.append(["reference's noise", *figures, "", "", ""])
    words = "tuned / untuned" if len(sorts) > 1 else "untuned"
    return f"{name}, means over {words} views\n\n{markdown(rows)}\n"


def summary_table(scenes: Mapping[str, Sequence[Result]]) -> str:
    """Every scene's decibels and FLIP on its untuned views and their mean, by method, in Markdown."""
    rows = [["method", *scenes, "mean"], ["---"] * (len(scenes) + 2)]
    for index, first in enumerate(next(iter(scenes.values()))):
        columns = [
            [results[index].mean(figure, True) for figure in ("psnr", "psnr_uneroded", "flip")]
            for results in scenes.values()
        ]
        means = [float(np.mean(figures)) for figures in zip(*columns, strict=True)]
        cells = (f"{inner:.2f} / {outer:.2f} / {flip:.3f}" for inner, outer, flip in [*columns, means])
        rows.append([first.method, *cells])
    return f"Untuned views: PSNR eroded / uneroded / FLIP\n\n{markdown(rows)}\n"


def distribution_table(scenes: Mapping[str, Sequence[Result]]) -> str:
    """Every scene's decibels and FLIP on its untuned views, worst of the last method first, and quantiles."""
    first = next(iter(scenes.values()))
    head = ["scene", *(result.method for result in first)]
    figures = {
        name: np.array([[result.mean(figure, True) for figure in ("psnr", "flip")] for result in results])
        for name, results in scenes.items()
    }
    worst_first = sorted(figures.items(), key=lambda entry: float(entry[1][-1, 0]))
    every = np.array([found for _, found in worst_first])  # (scenes, methods, 2)
    shares = {"worst": 0.0, "tenth": 0.1, "quarter": 0.25, "median": 0.5, "best": 1.0}
    falling = np.array([1.0, -1.0])  # a low PSNR is bad, a low FLIP is good
    rows = [
        (f"**{word}**", np.quantile(every * falling, at, axis=0) * falling) for word, at in shares.items()
    ]
    rows.append(("**mean**", every.mean(axis=0)))
    lines = [[name, *(f"{psnr:.2f} / {flip:.3f}" for psnr, flip in found)] for name, found in rows]
    lines += [[name, *(f"{psnr:.2f} / {flip:.3f}" for psnr, flip in found)] for name, found in worst_first]
    return f"Untuned views: PSNR / FLIP\n\n{markdown([head, ['---'] * len(head), *lines])}\n"


def save_sheet(path: Path, results: Sequence[Result]) -> None:
    """Save a sheet: a row a view; the reference, each method's picture, each method's error times 4."""
    rows = []
    for number, first in enumerate(results[0].seen):
        reference = display(first.view.reference)
        tiles = [tile(reference, f"{first.view.name}: reference")]
        for result in results:
            seen = result.seen[number]
            shown = np.where(seen.inside[..., None], display(seen.picture), reference)
            tiles.append(tile(shown, f"{result.method}: {seen.figures.psnr:.1f} dB"))
        for result in results:
            seen = result.seen[number]
            error = np.abs(display(seen.picture) - reference) * seen.inside[..., None]
            tiles.append(tile(np.clip(_GAIN * error, 0, 1), f"{result.method}: error x{_GAIN}"))
        rows.append(np.concatenate(tiles, axis=1))
    Image.fromarray(np.concatenate(rows, axis=0)).save(path, optimize=True)


def tile(picture: Picture, label: str) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """A display picture with a label above, as bytes."""
    tile = Image.new("RGB", (PIXELS, PIXELS + _LABEL))
    tile.paste(Image.fromarray((picture * 255 + 0.5).astype(np.uint8)), (0, _LABEL))
    ImageDraw.Draw(tile).text((3, 1), label, fill=(255, 255, 255))
    return np.asarray(tile)


def markdown(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)
