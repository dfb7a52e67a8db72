# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session, with light that is a formula: every cell's mean lands on its pixel, whatever the tiles."""

from __future__ import annotations

from collections.abc import Callable, Generator

import numpy as np
import pytest

from radtex_addon.bake import session
from radtex_addon.bake.hidden_cells import HiddenCells
from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.bake.progress import Progress, Stage, finished
from radtex_addon.bake.session import BYTES_PER_PIXEL, Capture, fill_atlas
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.errors import BakeError
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import TexelMap, rasterise
from tests.reference.analytic import AnalyticCapture

AXES = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]  # a frame that lies askew


def card(sign: float = 1.0, width: int = 6, height: int = 4, part: float = 1.0) -> TexelMap:
    """A flat card on the lower left `part` of the UV square; its world position is AXES @ (u, v, 0)."""
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * part
    position = square @ AXES[:, :2].T
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    normal = AXES[:, 2] * np.sign(np.linalg.det(AXES))
    return rasterise(
        SurfaceMesh(
            position=position,
            triangles=triangles,
            normal=np.broadcast_to(normal, (2, 3, 3)),
            tangent=np.broadcast_to(AXES[:, 0], (2, 3, 3)),
            sign=np.full((2, 3), sign),
            uv=square[triangles],
        ),
        width,
        height,
    )


def telltale(plan: CapturePlan) -> Callable[[Floats, Floats], Floats]:
    """Light that is (u, v, B.x, B.y) of the card: its mean over a cell is known without any sum."""
    frame = np.stack([plan.tangent[0, 0], plan.bitangent[0, 0], plan.normal[0, 0]]).astype(np.float64)

    def light(position: Floats, direction: Floats) -> Floats:
        local = np.einsum("...b,ab->...a", direction, frame)
        return np.concatenate([position @ AXES[:, :2], direction_to_square(local)], axis=-1)

    return light


def bake(
    plan: CapturePlan, capture: Capture, memory_mb: int = 64, hidden: Bools | None = None
) -> tuple[Floats, list[Progress]]:
    """The atlas image and every step on its way."""
    marks = None if hidden is None else HiddenCells.of(hidden)
    steps = fill_atlas(plan, capture, memory_mb, marks)
    seen = []
    while True:
        try:
            seen.append(next(steps))
        except StopIteration as stop:
            return stop.value, seen


class Recorder:
    """A capture that remembers its tiles, and takes `seconds` for each by the session's clock."""

    def __init__(self, capture: Capture, seconds: float, monkeypatch: pytest.MonkeyPatch) -> None:
        self._capture, self._seconds, self._now = capture, seconds, 0.0
        self.tiles: list[Tile] = []
        monkeypatch.setattr(session, "perf_counter", lambda: self._now)

    def render(self, tile: Tile) -> Floats:
        self.tiles.append(tile)
        self._now += self._seconds
        return self._capture.render(tile)


@pytest.mark.parametrize("sign", [1, -1])
def test_every_pixel_holds_its_own_cells_mean(sign: int) -> None:
    width, height, n = 6, 4, 5
    plan = plan_capture(card(sign, width, height), n)
    image, _ = bake(plan, AnalyticCapture(plan, telltale(plan)))
    assert image.shape == (height * n, width * n, 4)
    assert image.dtype == np.float32
    for y in range(height * n):  # docs/format.md: x = i n + p, y = j n + q, both upwards
        for x in range(width * n):
            (i, p), (j, q) = divmod(x, n), divmod(y, n)
            texel = [(i + 0.5) / width, (j + 0.5) / height]
            cell = [(2 * p + 1) / n - 1, (2 * q + 1) / n - 1]
            np.testing.assert_allclose(image[y, x], [*texel, *cell], atol=2e-6)


def test_a_cell_is_the_mean_over_the_square_and_not_its_centres_value() -> None:
    n, side = 2, 16
    plan = plan_capture(card(), n)

    def squared(position: Floats, direction: Floats) -> Floats:
        return telltale(plan)(position, direction) ** 2

    image, _ = bake(plan, AnalyticCapture(plan, squared, side))
    # the mean of B.x^2 over [0, 1] is 1/3; `side` samples miss it by 1 / (12 side^2)
    np.testing.assert_allclose(image[:, 1::2, 2], 1 / 3, atol=1 / (12 * side**2) + 1e-6)
    assert abs(0.5**2 - 1 / 3) > 0.08


def test_hidden_cells_are_filled_from_the_nearest_texel_that_shows_them() -> None:
    plan = plan_capture(card(width=5, height=1), 2)
    hidden = np.zeros((5, 2, 2), dtype=bool)
    hidden[1, 0, 1] = hidden[2, 0, 1] = True  # cell p = 1, q = 0 of texels 1 and 2: 0 and 3 are next
    image, _ = bake(plan, AnalyticCapture(plan, telltale(plan)), hidden=hidden)
    plain, _ = bake(plan, AnalyticCapture(plan, telltale(plan)))
    expected = plan.layout.to_buckets(plain.copy()).copy()
    expected[0, 1, 0, 1], expected[0, 2, 0, 1] = expected[0, 0, 0, 1], expected[0, 3, 0, 1]
    np.testing.assert_array_equal(plan.layout.to_buckets(image), expected)


def test_marks_follow_their_texels_where_only_some_are_covered() -> None:
    texels = card(width=8, height=8, part=0.5)
    plan = plan_capture(texels, 2)
    hidden = np.zeros((len(plan.texel), 2, 2), dtype=bool)
    hidden[0] = True
    image, _ = bake(plan, AnalyticCapture(plan, telltale(plan)), hidden=hidden)
    plain, _ = bake(plan, AnalyticCapture(plan, telltale(plan)))
    changed = (plan.layout.to_buckets(image) != plan.layout.to_buckets(plain)).any(axis=(2, 3, 4))
    assert changed.ravel()[plan.texel[0]]
    assert not changed.ravel()[plan.texel[1:]].any()


@pytest.mark.parametrize(("memory_mb", "seconds"), [(16, 0.0), (16, 100.0), (1, 0.0), (10_000, 1.0)])
def test_the_bits_do_not_depend_on_the_tiles(
    memory_mb: int, seconds: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = plan_capture(card(width=40, height=40), 4)
    whole = AnalyticCapture(plan, telltale(plan), side=1)
    capture = Recorder(whole, seconds, monkeypatch)
    image, _ = bake(plan, capture, memory_mb)
    cells = whole.render(Tile(0, plan.rows))
    flat = np.zeros((1600, 4, 4, 4), dtype=np.float32)
    flat[plan.texel] = cells
    np.testing.assert_array_equal(image, plan.layout.from_buckets(flat.reshape(40, 40, 4, 4, 4)))
    rows = [row for tile in capture.tiles for row in range(tile.first_row, tile.first_row + tile.rows)]
    assert rows == list(range(plan.rows)), "every row once, in order"


def test_tiles_stay_below_the_memory_they_may_take_or_are_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_capture(card(width=40, height=40), 8)
    capture = AnalyticCapture(plan, telltale(plan), side=1)
    some, fewest = Recorder(capture, 0.0, monkeypatch), Recorder(capture, 0.0, monkeypatch)
    bake(plan, some, memory_mb=1)
    largest = max(tile.rows for tile in some.tiles)
    bytes_a_row = plan.columns * 8 * 8 * BYTES_PER_PIXEL
    assert largest * bytes_a_row <= 2**20 < (largest + 1) * bytes_a_row
    bake(plan, fewest, memory_mb=0)
    assert [tile.rows for tile in fewest.tiles] == [1] * plan.rows


def test_no_tile_crosses_a_sheets_edge_and_what_may_not_be_cut_is_a_whole_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = plan_capture(card(width=40, height=40), 4, sheet=64)
    capture, height = AnalyticCapture(plan, telltale(plan)), plan.sheet_rows
    uncut = Recorder(capture, 100.0, monkeypatch)
    finished(fill_atlas(plan, uncut, 1, uncut=True))
    assert plan.sheets > 2
    assert uncut.tiles == [Tile(row, min(height, plan.rows - row)) for row in range(0, plan.rows, height)]
    cut = Recorder(capture, 0.0, monkeypatch)
    finished(fill_atlas(plan, cut, 1000))
    assert len(cut.tiles) > plan.sheets
    assert all(tile.first_row // height == (tile.end - 1) // height for tile in cut.tiles)


def test_slow_tiles_shrink_and_quick_ones_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_capture(card(width=100, height=100), 2)
    capture = AnalyticCapture(plan, telltale(plan), side=1)
    slow = Recorder(capture, 100.0, monkeypatch)
    bake(plan, slow)
    assert [tile.rows for tile in slow.tiles[1:]] == [1] * (len(slow.tiles) - 1)
    quick = Recorder(capture, 1e-4, monkeypatch)
    bake(plan, quick)
    heights = [tile.rows for tile in quick.tiles]
    assert heights[1] == 4 * heights[0]
    assert len(quick.tiles) < 8


def test_progress_counts_texels_and_adds_up() -> None:
    plan = plan_capture(card(width=23, height=17, part=0.8), 2)
    _, steps = bake(plan, AnalyticCapture(plan, telltale(plan)))
    captured = [step for step in steps if step.stage is Stage.CAPTURE]
    count = len(plan.texel)
    assert {step.total for step in captured} == {count}
    done = [step.done for step in captured]
    assert done[0] == 0
    assert done[-1] == count
    assert done == sorted(set(done)), "always onwards"
    assert steps[len(captured) :] == [Progress(Stage.FILL, 0, 1), Progress(Stage.FILL, 1, 1)]


class Spoilt:
    """A capture that spoils what another returns."""

    def __init__(self, capture: Capture, spoil: Callable[[Floats], Floats]) -> None:
        self._capture, self._spoil = capture, spoil

    def render(self, tile: Tile) -> Floats:
        return self._spoil(self._capture.render(tile))


def test_a_capture_that_breaks_its_promise_is_found_out_and_the_file_clamps_infinite_light() -> None:
    plan = plan_capture(card(), 2)

    def baked(value: float, count: int | None = None) -> Floats:
        def spoil(cells: Floats) -> Floats:
            cells[0, 1, 0, 2] = cells[0, 0, 0, 0] = value
            return cells[:count]

        return bake(plan, Spoilt(AnalyticCapture(plan, telltale(plan)), spoil))[0]

    with pytest.raises(BakeError, match="2 values that are not numbers") as raised:
        baked(np.nan)
    assert raised.value.exit_code == 1
    with pytest.raises(BakeError, match=r"cells of shape .* expected"):
        baked(1, -1)
    assert np.isinf(baked(np.inf)).any()


def test_nothing_is_rendered_before_the_first_step_nor_after_closing(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_capture(card(width=40, height=40), 2)
    capture = Recorder(AnalyticCapture(plan, telltale(plan)), 1.0, monkeypatch)
    steps: Generator[Progress, None, Floats] = fill_atlas(plan, capture, 64)
    assert next(steps) == Progress(Stage.CAPTURE, 0, len(plan.texel))
    assert not capture.tiles
    for _ in range(2):
        next(steps)
    rendered = len(capture.tiles)
    steps.close()
    assert 0 < rendered < plan.rows
    assert len(capture.tiles) == rendered
    with pytest.raises(StopIteration):
        next(steps)
