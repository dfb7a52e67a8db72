# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex's presets: what they are called, what they set, and which of them a bake's settings are."""

from __future__ import annotations

import ast
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .spec import BakeSpec

SUBDIR = "radtex"
STOCK_FOLDER = (
    Path(__file__).parents[1] / "ui" / "settings" / "stock"
)  # with presets/radtex/*.py, for Blender
CUSTOM = "custom"  # the quality of settings that are no preset's

# File name, label and tooltip: first by increasing cost, then by material.
STOCK = (
    ("draft", "Draft", "A first look in seconds: coarse, and noisy"),
    ("preview", "Preview", "Good enough to judge the light"),
    ("final", "Final", "Fine texels and little noise, for what ships"),
    ("mirror_like", "Glossy", "Polished, coated and glassy things: sharp reflections"),
    (
        "diffuse_like",
        "Matte",
        "Plaster, cloth, raw wood: light that hardly changes with the view; small files",
    ),
)
QUALITIES = (*(label.lower() for _, label, _ in STOCK), CUSTOM)


def preset_values(path: Path) -> dict[str, Any]:
    """Settings and values in a preset's file: of its lines `radtex.NAME = VALUE`, as Blender writes them."""
    module = ast.parse(path.read_text(encoding="utf-8"))
    lines = (line for line in module.body if isinstance(line, ast.Assign))
    return {
        line.targets[0].attr: ast.literal_eval(line.value)
        for line in lines
        if isinstance(line.targets[0], ast.Attribute) and ast.unparse(line.targets[0].value) == "radtex"
    }


@lru_cache
def stock_values(name: str) -> dict[str, Any]:
    """What RadTex's preset `name` sets."""
    return preset_values(STOCK_FOLDER / "presets" / SUBDIR / f"{name}.py")


def quality_of(spec: BakeSpec, *, automatic: bool, cells: int | None = None) -> str:
    """One of `QUALITIES`: the preset that a specification is by, in small letters, or "custom".

    `automatic`: its layout is yet to be chosen, with so many `cells` a side if they were named.
    """
    for name, label, _ in STOCK:
        if _is_by(spec, stock_values(name), automatic, cells):
            return label.lower()
    return CUSTOM


def _is_by(spec: BakeSpec, values: dict[str, Any], automatic: bool, cells: int | None) -> bool:
    if spec.density is not None or any(
        getattr(spec, name) != values[name] for name in ("kind", "texels", "samples")
    ):
        return False
    if values["atlas_layout"] == "auto":  # its number of cells is the automatic layout's own
        return automatic and cells is None
    same_cells = not spec.form.any_cells or spec.bucket == values["bucket"]
    return not automatic and spec.layout == values["atlas_layout"] and same_cells
