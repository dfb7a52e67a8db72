# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells, their sums, the tables made of them, and the page that takes these."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from radtex_addon.core.errors import InputError
from tests.bench.results import sentences, tables
from tests.bench.results.cells import Cell, Cells, Key
from tests.bench.results.document import PAGE, filled
from tests.bench.results.matrix import MAIN, METHODS, TITLES
from tests.bench.results.summary import Spread, rows_of

_SCENES = ["draw-1-0", "draw-1-1"]


def _cell(scene: int, method: str, seed: int, psnr: float) -> Cell:
    key = Key(MAIN.texels, MAIN.samples, _SCENES[scene], method, seed)
    views = {
        "a": {"psnr": psnr - 1, "flip": 0.1, "energy": 1.0},
        "b": {"psnr": psnr + 1, "flip": 0.3, "energy": 1.0},
    }
    size, paths = (2_000_000, 5_000_000) if method == "layered" else (500_000, 2_000_000)
    return Cell(key, size, paths, 10.0, 12.0, views)


_CELLS = [
    *(_cell(0, "layered", seed, 30.0 + seed) for seed in (1, 2, 3)),
    *(_cell(1, "layered", seed, 20.0 + seed) for seed in (1, 2, 3)),
    *(_cell(scene, "probe", seed, 24.0) for scene in (0, 1) for seed in (1, 2, 3)),
    _cell(0, "sg", 1, 40.0),  # of one scene alone
]


def test_cells_come_back_from_their_file_and_are_not_measured_again(tmp_path: Path) -> None:
    path = tmp_path / "cells.json"
    for cell in _CELLS:
        Cells(path).add(cell)
    again = Cells(path)
    assert list(again) == sorted(_CELLS, key=lambda cell: cell.key)
    assert _CELLS[0].key in again
    assert len(path.read_text().splitlines()) == len(_CELLS) + 2


def test_rows_are_means_of_scenes_and_spread_over_seeds() -> None:
    first, second = rows_of(_CELLS, MAIN, _SCENES)
    assert (first.method, second.method) == ("layered", "probe")  # SG lacks a scene
    assert first.psnr == Spread(27.0, 1.0)
    assert (first.worst_scene, first.worst_view) == (22.0, 21.0)
    assert (first.seeds, first.flip) == (3, Spread(0.2, 0.0))
    assert (first.megabytes, first.million_paths) == (2.0, 5.0)


def test_tables_say_what_the_figures_say() -> None:
    rows = tables.method_rows(_CELLS, [MAIN], _SCENES)
    quality = tables.quality_table(rows).splitlines()
    assert (
        quality[2]
        == f"| {TITLES['layered']} | 27.00 ± 1.00 | 22.0 | 21.0 | 0.200 ± 0.000 | 1.00 | 2.00 | 5.0 |"
    )
    by_scene = tables.scene_rows(_CELLS, MAIN, _SCENES)
    scenes = tables.scenes_table(by_scene).splitlines()
    assert scenes[2:] == ["| 1 | 22.0 ± 1.0 | **24.0 ± 0.0** |", "| 0 | **32.0 ± 1.0** | 24.0 ± 0.0 |"]
    told = sentences.who_wins(by_scene, rows)
    assert f"{TITLES['probe']} beats the default in scene 1 (by 2.0 dB)" in told
    assert sentences.worst_first(by_scene, rows).startswith(
        "The worst single view of the default has 21.0 dB"
    )


def test_a_page_takes_blocks_and_keeps_what_is_written_by_hand() -> None:
    text = "By hand.\n<!-- a: written by tests.bench.results -->\nold\n<!-- end of a -->\nMore.\n"
    new = filled(text, {"a": "new"})
    assert new == text.replace("old\n", "\nnew\n\n")
    assert filled(new, {"a": "new"}) == new
    with pytest.raises(InputError, match="no place for b"):
        filled(text, {"b": "new"})


def test_the_page_has_a_place_for_every_table() -> None:
    blocks = (
        "worst",
        "quality",
        "scenes",
        "winners",
        "hours",
        "bytes",
        "paths",
        "lookup",
        "stereo",
        "assets",
        "close_ups",
        "rooms",
    )
    text = PAGE.read_text(encoding="utf-8")
    assert filled(text, {}) == text
    filled(text, dict.fromkeys(blocks, ""))


def test_assets_stand_beside_other_ways_and_close_ups_count_in_no_mean() -> None:
    figures = {"psnr": 25.0, "flip": 0.1, "energy": 1.0, "glints": 0.9}
    other = figures | {"psnr": 19.0}
    shown = {"all": other, "Eevee": figures, "Head": figures}
    facts = {"mean": {"all": other, "Eevee": figures}, "views": {"view0": shown, "close0": shown}}
    table = tables.assets_table({"helmet": facts}).splitlines()
    assert table[2:] == [
        "| Eevee, nothing baked | 25.0 | 25.0 | 0.100 | 1.00 | 0.90 |",
        "| RadTex, the reference lookup | 19.0 | 19.0 | 0.100 | 1.00 | 0.90 |",
    ]
    near = tables.close_ups_table({"helmet": facts}).splitlines()
    assert near[2:] == ["| RadTex, the reference lookup | 19.0 |", "| Eevee, nothing baked | 25.0 |"]


def test_rooms_stand_worst_first_with_what_they_cost() -> None:
    def room(worst: float, **more: Any) -> dict[str, Any]:
        shown = {"psnr": 40.0, "flip": 0.1}
        first: dict[str, Any] = {"all": shown, "Eevee": shown | {"psnr": 20.0}}
        views = {"view0": first, "view1": {"all": shown | {"psnr": worst}}}
        size = {"draw_calls": 9, "megabytes": 8.4, "atlases": 2}
        return {"views": views, "objects": 7, "written": size, "costs": None} | more

    costs = {"wall": 60.0, "processor": 120.0, "memory": 1500.0}
    table = tables.rooms_table({"fair": room(30.0), "bad": room(20.0, costs=costs)}).splitlines()
    assert table[2:] == [
        "| bad | 20.0, 30.0 | 0.100 |  | 20.0, 20.0 | 7 | 9 | 8 | 2 | 1.5 |",
        "| fair | 30.0, 35.0 | 0.100 |  | 20.0, 20.0 | 7 | 9 | 8 |  |  |",
    ]


def test_every_method_has_a_title() -> None:
    assert {method for methods in METHODS.values() for method in methods} == set(TITLES)
