# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences with figures for docs/results.md: the worst first, who wins where, and what it took."""

from __future__ import annotations

from collections.abc import Iterable
from textwrap import fill
from typing import Any

from .cells import Cell
from .matrix import BAKED, TITLES

Rows = list[dict[str, Any]]
_WIDTH = 125  # of a line of the page
_OWN = {"layered", "buckets denoised", "buckets", "buckets nearest"}  # RadTex's


def worst_first(scenes: Rows, methods: Rows) -> str:
    """What the default shows worst, before any mean."""
    default = next(row for row in methods if row["method"] == "layered")
    worst, best = (scenes[place]["psnr"]["layered"]["mean"] for place in (0, -1))
    return _wrapped(
        f"The worst single view of the default has {default['worst_view']:.1f} dB; its worst scene is "
        f"number {_number(scenes[0])}, with {worst:.1f} dB, its best number {_number(scenes[-1])}, "
        f"with {best:.1f} dB. "
        f"The mean of all scenes and views is {default['psnr']['mean']:.1f} dB."
    )


def who_wins(scenes: Rows, methods: Rows) -> str:
    """In which scenes which method is best, what beats the default where, and the best of what takes less."""
    won: dict[str, list[str]] = {}
    beaten: dict[str, list[str]] = {}
    for row in scenes:
        told = {m: spread["mean"] for m, spread in row["psnr"].items() if m != "reference again"}
        best = max(told, key=lambda method: told[method])
        won.setdefault(best, []).append(f"{_number(row)} ({_ahead(told, best)})")
        for method, value in told.items():
            if method != "layered" and value > told["layered"]:
                more = f"{_number(row)} (by {value - told['layered']:.1f} dB)"
                beaten.setdefault(method, []).append(more)
    lines = [f"* {TITLES[method]} is best in scene {', '.join(places)}." for method, places in won.items()]
    for method, places in beaten.items():
        lines.append(f"* {TITLES[method]} beats the default in scene {', '.join(places)}.")
    if not beaten:
        lines.append("* Nothing beats the default in any of these scenes, by PSNR.")
    return "\n".join(_wrapped(line, "  ") for line in lines + _cheaper(methods))


def what_it_took(cells: Iterable[Cell], scenes: Rows, methods: Rows) -> str:
    """Bakes that were looked at, with how many seeds, and hours."""
    every = list(cells)
    hours = sum(cell.spent for cell in every) / 3600
    default = next(row for row in methods if row["method"] == "layered")
    by_scene = ", ".join(f"{row['seeds']} in scene {_number(row)}" for row in scenes)
    return _wrapped(
        f"Measured so far: {default['seeds']} seeds in all scenes, of which the means over scenes are; "
        f"by scene {by_scene}. That is {len(every)} rows of `cells.json`; baking, looking and comparing "
        f"took {hours:.1f} hours by the clock, on two cores that had other work as well."
    )


def _cheaper(methods: Rows) -> list[str]:
    """Which method is the best of those that take less than the default."""
    default = next(row for row in methods if row["method"] == "layered")
    lines = []
    for amount, words, unit in (
        ("megabytes", "fewer bytes", "MB"),
        ("million_paths", "fewer paths", "M paths"),
    ):
        less = [row for row in methods if row["method"] in BAKED and row[amount] < default[amount]]
        if less:
            best = max(less, key=lambda row: float(row["psnr"]["mean"]))
            lines.append(
                f"* With {words} than the default's {default[amount]:.2f} {unit}, the best is: "
                f"{TITLES[best['method']]}, {best[amount]:.2f} {unit}, {best['psnr']['mean']:.1f} dB in the "
                f"mean against {default['psnr']['mean']:.1f}."
            )
    return lines


def _ahead(told: dict[str, float], best: str) -> str:
    """How far the best is ahead of the next that is not RadTex's, or is, if the best is not."""
    others = {m: value for m, value in told.items() if (m in _OWN) != (best in _OWN)}
    second = max(others, key=lambda method: others[method])
    return f"{told[best] - others[second]:.1f} dB ahead of: {TITLES[second]}"


def _wrapped(text: str, indent: str = "") -> str:
    return fill(text, _WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _number(row: dict[str, Any]) -> str:
    return str(row["scene"]).rpartition("-")[2]
