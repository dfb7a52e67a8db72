# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An atlas that comes in bands is the one that is filled whole, and only some of it is ever read."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from radtex_addon.bake import bands as module
from radtex_addon.bake.bands import find_bands
from radtex_addon.bake.cells import Cells
from radtex_addon.bake.hidden_cells import HiddenCells, fill_missing
from radtex_addon.bake.piece_store import MemoryStore, PieceStore
from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.store.checkpoint import Checkpoint
from tests.bake.test_plan import texel_map

WIDTH, HEIGHT, N = 23, 31, 3


@pytest.fixture(params=["memory", "disk"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> PieceStore:
    if request.param == "memory":
        return MemoryStore()
    kept = Checkpoint(tmp_path / "Vase.radtex-unfinished", resume=False)
    kept.set_facts({"object": "Vase"})
    return kept


def some_plan(share: float = 0.4) -> CapturePlan:
    covered = np.random.default_rng(1).random((HEIGHT, WIDTH)) < share
    return plan_capture(texel_map(covered), N)


def some_cells(plan: CapturePlan, store: PieceStore, heights: int = 3) -> tuple[Cells, Floats]:
    """Random cells in tiles that come in no order, and the same whole: (K, n, n, 4)."""
    rng = np.random.default_rng(2)
    whole = rng.normal(size=(len(plan.texel), N, N, 4)).astype(np.float32)
    cells = Cells(plan, store, 4)
    rows = list(range(0, plan.rows, heights))
    rng.shuffle(rows)
    for row in rows:
        tile = Tile(row, min(heights, plan.rows - row))
        first = row * plan.columns
        cells.put(tile, whole[first : first + len(plan.texels_of(tile))])
    return cells, whole


def some_hidden(plan: CapturePlan) -> Bools:
    """Random marks: one direction that all have, one that none has, one that but one has."""
    marks: Bools = np.random.default_rng(3).random((len(plan.texel), N, N)) < 0.3
    marks[:, 0, 0], marks[:, 0, 1], marks[1:, 0, 2], marks[0, 0, 2] = True, False, True, False
    return marks


@pytest.mark.parametrize("hides", [False, True])
@pytest.mark.parametrize("bytes_", [1, 5000, 1 << 30])
def test_bands_are_the_atlas_that_is_filled_whole(
    store: PieceStore, hides: bool, bytes_: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_BAND_BYTES", bytes_)
    monkeypatch.setattr(module, "_HELD_BYTES", 0)
    plan = some_plan()
    cells, whole = some_cells(plan, store)
    marks = some_hidden(plan) if hides else None
    expected = plan.placed(whole)
    finished(fill_missing(expected, plan.covered, None if marks is None else plan.placed(marks)))
    hidden = None if marks is None else HiddenCells.of(marks)
    bands = finished(find_bands(plan, cells, store, hidden))
    found = np.empty_like(expected)
    rows = HEIGHT
    for band in bands.downwards():
        assert band.end == rows
        found[band.first : band.end] = band.buckets
        rows = band.first
    assert rows == 0
    assert len(bands) == {1: HEIGHT, 5000: HEIGHT, 1 << 30: 1}[bytes_]
    np.testing.assert_array_equal(found, expected)


def test_what_was_kept_is_taken_up_again_wherever_its_tiles_lie(store: PieceStore) -> None:
    plan = some_plan()
    cells, whole = some_cells(plan, store, heights=2)
    before = store.names()
    finished(find_bands(plan, cells, store, HiddenCells.of(some_hidden(plan))))
    assert store.names() == before, "little is not kept"
    again = Cells(plan, store, 4)
    found = list(again.restore())
    assert again.missing(1) is None
    assert again.texels == len(plan.texel) == sum(len(values) for _, values in found)
    for index in ([0], [len(plan.texel) - 1], [0, 1, 90, 91, 150, len(plan.texel) - 1], range(len(whole))):
        np.testing.assert_array_equal(again.take(np.array(index)), whole[list(index)])
    assert list(Cells(plan, store, 7).restore()) == []  # tiles of other channels


def test_hidden_cells_are_a_bit_each() -> None:
    marks: npt.NDArray[np.bool_] = np.random.default_rng(5).random((50, 5, 5)) < 0.4
    marks[7], marks[:, 2, 3], marks[:, 1, 1], marks[7, 1, 1] = True, True, False, True
    hidden = HiddenCells.of(marks)
    assert hidden.bits.shape == (50, 4)
    np.testing.assert_array_equal(hidden.cells, marks)
    np.testing.assert_array_equal(hidden.buried, marks.all(axis=(1, 2)))
    for q in range(5):
        for p in range(5):
            np.testing.assert_array_equal(hidden.of_direction(q, p), marks[:, q, p])
    expected = [(q, p) for q in range(5) for p in range(5) if (q, p) != (2, 3)]
    assert list(hidden.directions()) == expected
    np.testing.assert_array_equal(hidden.of_texels(hidden.buried).cells, marks[[7]])


def test_a_band_takes_little_memory(tmp_path: Path) -> None:
    """Of an atlas of 32 MB, in bands of a 64th, no more than a tenth is ever there."""
    plan = plan_capture(texel_map(np.ones((256, 128), dtype=bool)), 8)
    kept = Checkpoint(tmp_path / "Vase.radtex-unfinished", resume=False)
    cells = Cells(plan, kept, 4)
    while (tile := cells.missing(4)) is not None:
        cells.put(tile, np.ones((len(plan.texels_of(tile)), 8, 8, 4), dtype=np.float32))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_BAND_BYTES", 1 << 19)
        bands = finished(find_bands(plan, cells, kept, None))
        tracemalloc.start()
        for band in bands.downwards():
            assert band.buckets.min() == 1
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 3.3e6
