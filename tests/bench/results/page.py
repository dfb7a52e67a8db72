# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""JSON, plots and docs/results.md anew, from the cells and from what was measured beside them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import bpy

from . import document, kept_json, sentences, tables
from .cells import Cells
from .matrix import BY_BYTES, BY_PATHS, MAIN
from .plots import over, over_cost
from .scenes import DRAWN_WITH, REFERENCE_SAMPLES, SCENES, SUBSAMPLES

_STEPS = (
    ("bytes", BY_BYTES, "texels", "megabytes", "MB on the GPU (numbers: texels along a side)"),
    ("paths", BY_PATHS, "samples", "million_paths", "million paths of the bake (numbers: samples)"),
)


def write_page(cells: Cells) -> None:
    """Write all of it; nothing where no method has been measured on all scenes."""
    scenes = list(SCENES)
    quality = tables.method_rows(cells, [MAIN], scenes)
    if not any(row["method"] == "layered" for row in quality):
        return
    by_scene = tables.scene_rows(cells, MAIN, scenes)
    kept_json.write("quality", _facts(**asdict(MAIN), rows=quality))
    kept_json.write("scenes", _facts(**asdict(MAIN), rows=by_scene))
    blocks = {
        "worst": sentences.worst_first(by_scene, quality),
        "quality": tables.quality_table(quality),
        "scenes": tables.scenes_table(by_scene),
        "winners": sentences.who_wins(by_scene, quality),
        "hours": sentences.what_it_took(cells, by_scene, quality),
    }
    for name, settings, what, amount, label in _STEPS:
        rows = tables.method_rows(cells, settings, scenes)
        kept_json.write(name, _facts(rows=rows))
        over(kept_json.FOLDER / f"{name}.svg", rows, amount, label, what)
        blocks[name] = tables.settings_table(rows, what)
    assets = kept_json.read("assets")
    if assets:
        blocks["assets"] = tables.assets_table(assets)
        blocks["close_ups"] = tables.close_ups_table(assets)
    rooms = kept_json.read("rooms")
    if rooms:
        blocks["rooms"] = tables.rooms_table(rooms)
    lookup, stereo = kept_json.read("lookup"), kept_json.read("stereo")
    if lookup:
        over_cost(kept_json.FOLDER / "lookup.svg", quality, lookup["methods"])
        blocks["lookup"] = tables.lookup_table(lookup)
    if stereo:
        blocks["stereo"] = tables.stereo_table(stereo)
    document.write(blocks)


def _facts(**more: Any) -> dict[str, Any]:
    """What all tables are of, and more."""
    return {
        "blender": bpy.app.version_string,
        "lottery_seed": DRAWN_WITH,
        "reference_samples": REFERENCE_SAMPLES,
        "subsamples": SUBSAMPLES,
        **more,
    }
