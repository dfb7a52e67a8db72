# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each table's figures, from the measured cells, and its Markdown, from these figures alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from statistics import mean
from typing import Any

from ..fidelity.report import markdown
from .cells import Cell
from .matrix import BAKED, TITLES, Setting
from .summary import Spread, rows_of, scene_spread, seeds_of

CLOSE = "close"  # begins the names of close-ups in the figures of assets
_ASSET_WAYS = {
    "all": "RadTex, the reference lookup",
    "web page": "RadTex, the web page",
    "Godot": "RadTex, Godot",
    "preview in Eevee": "RadTex, the preview in Eevee",
    "MeshPhysicalMaterial": "three.js's MeshPhysicalMaterial",
    "Eevee": "Eevee, nothing baked",
}
Rows = list[dict[str, Any]]


def method_rows(cells: Iterable[Cell], settings: Iterable[Setting], scenes: Sequence[str]) -> Rows:
    """A row for each method at each setting, as JSON has it."""
    every = list(cells)
    return [asdict(row) for setting in settings for row in rows_of(every, setting, list(scenes))]


def scene_rows(cells: Iterable[Cell], setting: Setting, scenes: Sequence[str]) -> Rows:
    """A row for each scene, the one that the default shows worst first, with each method's PSNR."""
    every = list(cells)
    rows = []
    for scene in scenes:
        found = {method: scene_spread(every, setting, scene, method) for method in TITLES}
        told = {method: asdict(spread) for method, spread in found.items() if spread is not None}
        seeds = seeds_of(every, setting, scene)
        rows.append({"scene": scene, "seeds": seeds, "psnr": told})
    return sorted(rows, key=lambda row: row["psnr"].get("layered", {"mean": 0})["mean"])


def quality_table(rows: Rows) -> str:
    """All methods at one setting, best first."""
    head = ["", "PSNR, dB", "worst scene", "worst view", "FLIP", "energy", "MB", "M paths"]
    lines = [
        [
            TITLES[row["method"]],
            _spread(row["psnr"], 2),
            f"{row['worst_scene']:.1f}",
            f"{row['worst_view']:.1f}",
            _spread(row["flip"], 3),
            f"{row['energy']['mean']:.2f}",
            _amount(row["megabytes"], 2),
            _amount(row["million_paths"], 1),
        ]
        for row in rows
    ]
    return _table(head, lines)


def scenes_table(rows: Rows) -> str:
    """PSNR of all baked methods and Eevee by scene; the best of a scene in bold."""
    methods = [method for method in (*BAKED, "eevee") if all(method in row["psnr"] for row in rows)]
    lines = []
    for row in rows:
        best = max(methods, key=lambda method: row["psnr"][method]["mean"])
        told = [_spread(row["psnr"][method], 1) for method in methods]
        told = [f"**{text}**" if method == best else text for method, text in zip(methods, told, strict=True)]
        lines.append([row["scene"].rpartition("-")[2], *told])
    return _table(["scene", *(TITLES[method] for method in methods)], lines)


def settings_table(rows: Rows, what: str) -> str:
    """PSNR of each method by texels or samples (`what`), with the amount that it takes in brackets."""
    amount, digits = ("megabytes", 2) if what == "texels" else ("million_paths", 1)
    steps = sorted({row[what] for row in rows if row["method"] in BAKED})
    lines = []
    for method in BAKED:
        found = {row[what]: row for row in rows if row["method"] == method}
        if found:
            measured = [found.get(step) for step in steps]
            told = [
                f"{_spread(row['psnr'], 2)} ({row[amount]:.{digits}f})" if row else "not measured"
                for row in measured
            ]
            lines.append([TITLES[method], *told])
    unit = "MB" if what == "texels" else "M paths"
    return _table(["", *(f"{what}: {step}, dB ({unit})" for step in steps)], lines)


def lookup_table(found: dict[str, Any]) -> str:
    """Lookups, the cheapest first."""
    rows = sorted(found["methods"].items(), key=lambda item: item[1]["over_diffuse"])
    lines = [
        [TITLES.get(name, name), str(row["fetches"]), f"{row['ms']:.1f}", f"{row['over_diffuse']:.2f}"]
        for name, row in rows
    ]
    return _table(["lookup", "fetches", "a frame, ms", "over diffuse"], lines)


def stereo_table(found: dict[str, Any]) -> str:
    """What both eyes see."""
    lines = [
        [name, _spread(row["worse_eye"], 1), _spread(row["difference"], 1)]
        for name, row in found["looked_up"].items()
    ]
    return _table(["", "the worse eye, dB", "the difference between the eyes, dB"], lines)


def assets_table(found: dict[str, Any]) -> str:
    """Assets of several parts, each as it is baked and by other ways, best first."""
    lines = []
    for facts in found.values():
        views = [view for name, view in facts["views"].items() if not name.startswith(CLOSE)]
        ways = [way for way in facts["mean"] if all(way in view for view in views)]
        for way in sorted(ways, key=lambda way: -float(facts["mean"][way]["psnr"])):
            mean = facts["mean"][way]
            told = " ".join(f"{view[way]['psnr']:.1f}" for view in views)
            line = [f"{mean['psnr']:.1f}", told, f"{mean['flip']:.3f}", f"{mean['energy']:.2f}"]
            lines.append([_ASSET_WAYS.get(way, way), *line, f"{mean['glints']:.2f}"])
    return _table(["", "PSNR, dB", "views", "FLIP", "energy", "glints kept"], lines)


def close_ups_table(found: dict[str, Any]) -> str:
    """PSNR in each close-up of the ways that show all of them."""
    (facts,) = found.values()
    near = [view for name, view in facts["views"].items() if name.startswith(CLOSE)]
    head = ["PSNR, dB", *(str(number) for number in range(1, len(near) + 1))]
    lines = [
        [_ASSET_WAYS.get(way, way), *(f"{view[way]['psnr']:.1f}" for view in near)]
        for way in facts["mean"]
        if all(way in view for view in near)
    ]
    return _table(head, lines)


def rooms_table(found: dict[str, Any]) -> str:
    """Rooms, the worst view first, each as all of it is baked, beside other ways, and what the bake cost."""

    def of(facts: dict[str, Any], way: str, field: str) -> list[float]:
        return sorted(float(view[way][field]) for view in facts["views"].values() if way in view)

    def told(values: Sequence[float]) -> str:
        return f"{values[0]:.1f}, {mean(values):.1f}" if values else ""

    lines = []
    for name, facts in sorted(found.items(), key=lambda room: of(room[1], "all", "psnr")[0]):
        others = [told(of(facts, way, "psnr")) for way in ("three.js", "Eevee")]
        flip, costs = mean(of(facts, "all", "flip")), facts["costs"]
        spent = [f"{costs['processor'] / 60:.0f}", f"{costs['memory'] / 1000:.1f}"] if costs else ["", ""]
        size = [str(facts["objects"]), str(facts["written"]["draw_calls"])]
        bytes_ = f"{facts['written']['megabytes']:.0f}"
        lines.append([name, told(of(facts, "all", "psnr")), f"{flip:.3f}", *others, *size, bytes_, *spent])
    head = [
        "room",
        "RadTex, dB",
        "FLIP",
        "three.js",
        "Eevee",
        "objects",
        "draw calls",
        "MB",
        "CPU minutes",
        "GB",
    ]
    return _table(head, lines)


def _spread(facts: dict[str, Any], digits: int) -> str:
    return Spread(**facts).text(digits)


def _amount(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if value else ""


def _table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return markdown([head, ["---"] * len(head), *lines]) + "\n"
