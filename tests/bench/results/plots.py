# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Results' plots: quality over bytes, paths and lookup cost, with error bars, on white."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter
from matplotlib.transforms import Bbox

from .matrix import BAKED, TITLES

_SIZE = (11.0, 4.6)  # inches
_FIGURES = {"psnr": "PSNR, dB (higher is better)", "flip": "FLIP (lower is better)"}
_LOOKS = {  # colours of Okabe and Ito's palette, which the colour-blind can tell apart
    "layered": ("#D55E00", "o"),
    "probe": ("#0072B2", "s"),
    "sg": ("#009E73", "^"),
    "sh3": ("#CC79A7", "v"),
    "sh": ("#E69F00", "<"),
    "lightmap": ("#56B4E9", "D"),
    "buckets denoised": ("#000000", "P"),
    "buckets": ("#555555", "X"),
    "buckets nearest": ("#999999", "x"),
}
Rows = Sequence[dict[str, Any]]


def over(path: Path, rows: Rows, amount: str, label: str, step: str) -> None:
    """PSNR and FLIP over what a bake takes; points of a method are joined, `step` tells them apart."""

    def draw(axes: Axes, figure: str) -> None:
        for method in BAKED:
            own = sorted((r for r in rows if r["method"] == method), key=lambda r: float(r[amount]))
            points = [(row[amount], row[figure], str(row[step])) for row in own]
            _points(axes, method, points)

    _two_panels(path, draw, rows, label)


def over_cost(path: Path, rows: Rows, costs: dict[str, Any]) -> None:
    """PSNR and FLIP over the cost of a lookup."""

    def draw(axes: Axes, figure: str) -> None:
        for row in rows:
            cost = costs.get(row["method"] if row["method"] != "buckets denoised" else "buckets")
            if cost is not None and row["method"] in BAKED:
                _points(axes, row["method"], [(cost["over_diffuse"], row[figure], "")])

    _two_panels(path, draw, rows, "frame time over that of a diffuse texture (llvmpipe, no GPU)")


def _points(axes: Axes, method: str, points: Sequence[tuple[float, dict[str, Any], str]]) -> None:
    if not points:
        return
    colour, marker = _LOOKS[method]
    x = [place for place, _, _ in points]
    y = [spread["mean"] for _, spread, _ in points]
    error = [spread["deviation"] or 0.0 for _, spread, _ in points]
    axes.errorbar(x, y, yerr=error, color=colour, marker=marker, capsize=3, label=TITLES[method])
    for place, height, (_, _, word) in zip(x, y, points, strict=True):
        axes.annotate(
            word, (place, height), xytext=(4, 4), textcoords="offset points", fontsize=7, color=colour
        )


def _hide_covered_words(axes: Axes) -> None:
    """Hide each point's word that would lie over an earlier one."""
    shown: list[Bbox] = []
    for text in axes.texts:
        place = text.get_window_extent()
        text.set_visible(not any(place.overlaps(other) for other in shown))
        if text.get_visible():
            shown.append(place)


def _two_panels(path: Path, draw: Callable[[Axes, str], None], rows: Rows, label: str) -> None:
    mpl.use("Agg")
    figure, panels = plt.subplots(1, 2, figsize=_SIZE, layout="constrained", facecolor="white")
    for axes, (name, title) in zip(panels, _FIGURES.items(), strict=True):
        draw(axes, name)
        unbaked = next((row[name]["mean"] for row in rows if row["method"] == "eevee"), None)
        if unbaked is not None:
            axes.axhline(unbaked, linestyle=":", color="grey")
            place = (1, unbaked)
            axes.annotate(
                "Eevee", place, xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=8
            )
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlabel(label)
        axes.set_ylabel(title)
        axes.grid(visible=True, which="both", alpha=0.3)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncol=3, fontsize=8, frameon=False)
    figure.draw_without_rendering()
    for axes in panels:
        _hide_covered_words(axes)
    path.parent.mkdir(parents=True, exist_ok=True)
    mpl.rcParams["svg.hashsalt"] = "radtex"  # the same file for the same figures
    figure.savefig(path, facecolor="white", metadata={"Date": None})
    plt.close(figure)
