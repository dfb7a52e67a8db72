# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality per byte: the mean PSNR of what was measured, over the bytes that a GPU holds of it, as a plot.

    uv run --group test --group plots python -m tests.bench.fidelity.quality_per_byte \\
        64=DIR/figures.json 128=OTHER/figures.json --out plot.png

Each file is one that `python -m tests.bench.fidelity --out DIR` left, after the number of texels along a side
of its atlases. Points of a method are joined. Only scenes that all files have count, and untuned views;
methods without bytes, such as Eevee's, are horizontal lines. Prints the points as a table, too.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.ticker import NullFormatter, StrMethodFormatter

from .report import markdown

_SIZE = (7.0, 4.5)  # inches
_DPI = 110

Points = dict[str, list[tuple[int, float, float]]]  # of each method: texels, MB, dB


def main() -> None:
    """Read, print, draw."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.quality_per_byte",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("figures", nargs="+", metavar="TEXELS=FILE", help="figures.json of a run")
    parser.add_argument("--out", type=Path, default=Path("quality-per-byte.png"), help="the plot")
    options = parser.parse_args()
    runs = []
    for given in options.figures:
        texels, _, path = given.partition("=")
        if not texels.isdigit() or not path:
            parser.error(f"{given}: expected TEXELS=FILE, such as 128=figures.json")
        found = json.loads(Path(path).read_text())
        runs.append((int(texels), {name: scene for name, scene in found.items() if isinstance(scene, dict)}))
    scenes = set.intersection(*(set(run) for _, run in runs))
    if not scenes:
        parser.error("no scene is in all of the files")
    points = _points(runs, scenes)
    rows = [["method", "texels", "MB", "PSNR, dB"], ["---"] * 4]
    for method, places in points.items():
        rows += [[method, str(texels), f"{size:.2f}", f"{psnr:.2f}"] for texels, size, psnr in places]
    print(f"{len(scenes)} scenes: {', '.join(sorted(scenes))}\n\n{markdown(rows)}")
    _draw(points, len(scenes), options.out)


def _points(runs: list[tuple[int, dict[str, Any]]], scenes: set[str]) -> Points:
    points: Points = {}
    for texels, run in sorted(runs, key=lambda pair: pair[0]):
        methods = set.intersection(*(set(run[name]["methods"]) for name in scenes))
        for method in sorted(methods):
            found = [run[name]["methods"][method] for name in scenes]
            size = float(np.mean([one["bytes"] for one in found])) / 1e6
            psnr = [view["psnr"] for one in found for view in one["views"].values() if view["held_out"]]
            points.setdefault(method, []).append((texels, size, float(np.mean(psnr))))
    return points


def _draw(points: Points, scenes: int, path: Path) -> None:
    mpl.use("Agg")
    figure, axes = plt.subplots(figsize=_SIZE, layout="constrained")
    for method, places in points.items():
        texels, size, psnr = zip(*places, strict=True)
        if not any(size):
            axes.axhline(psnr[0], linestyle=":", color="grey")
            axes.annotate(method, (1, psnr[0]), xycoords=("axes fraction", "data"), ha="right", va="bottom")
            continue
        axes.plot(size, psnr, marker="o", label=method)
        for side, x, y in zip(texels, size, psnr, strict=True):
            axes.annotate(str(side), (x, y), xytext=(4, 4), textcoords="offset points", fontsize=8)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("MB on the GPU (numbers: texels along a side)")
    axes.set_ylabel(f"PSNR, dB, mean of {scenes} scenes")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(loc="upper right")
    figure.savefig(path, dpi=_DPI)


if __name__ == "__main__":
    main()
