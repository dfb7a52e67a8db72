# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session: asks a capture for tile after tile, and puts the cells where they belong."""

from __future__ import annotations

import re
from collections.abc import Generator
from time import perf_counter

import numpy as np

from ..core.arrays import Bools, Floats
from ..core.errors import BakeError
from .capture import Capture
from .checkpoint import KEEPS_NOTHING, Keeper
from .filling import fill_missing
from .layers import WHOLE
from .plan import CapturePlan, Tile
from .progress import Progress, Stage
from .thumbnail import Thumbnail

BYTES_PER_PIXEL = 112  # of a tile: Cycles's buffers, the render result, the file, our copy (measured peak)
SECONDS_PER_TILE = 2.0  # a tile this long reports often and still hides the cost of a render call


def fill_atlas(
    plan: CapturePlan,
    capture: Capture,
    memory_mb: int,
    hidden: Bools | None = None,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
    channels: int = WHOLE,
) -> Generator[Progress, None, Floats]:
    """Capture the plan's texels, fill gutters and `hidden` cells, and yield progress in texels.

    `hidden` (K, n, n) marks cells, in the order of `plan.texel`, whose captured value is not to be used. The
    `keeper` is given each tile; rows that it has kept are not captured again. The `thumbnail` is shown all.
    Returns the atlas image (H*n, W*n, `channels`) float32, row 0 at the bottom. Tiles stay below `memory_mb`
    and near SECONDS_PER_TILE; their heights do not change the bits. Raises BakeError for cells that are not
    numbers, and where a tile cannot be kept.
    """
    filling = _Filling(plan, thumbnail, channels)
    filling.restore(keeper)
    count, of_pixel = len(plan.texel), BYTES_PER_PIXEL * channels // WHOLE
    most = max(1, memory_mb * 2**20 // (plan.columns * plan.layout.bucket**2 * of_pixel))
    yield Progress(Stage.CAPTURE, filling.texels, count)
    height = 1  # the first tile also loads the scene, and tells the pace
    while (tile := filling.missing(height)) is not None:
        started = perf_counter()
        cells = capture.render(tile)
        seconds = perf_counter() - started
        filling.put(tile, cells)
        keeper.keep(_name(tile), {"cells": cells})
        yield Progress(Stage.CAPTURE, filling.texels, count)
        height = max(1, min(most, 4 * height, int(tile.rows * SECONDS_PER_TILE / max(seconds, 1e-3))))
    yield Progress(Stage.FILL, 0, 1)
    layout, n = plan.layout, plan.layout.bucket
    buckets = filling.cells.reshape(layout.height, layout.width, n, n, channels)
    marks = plan.placed(hidden) if hidden is not None and hidden.any() else None
    yield from fill_missing(buckets, plan.covered, marks)
    yield Progress(Stage.FILL, 1, 1)
    return layout.from_buckets(buckets)


class _Filling:
    """The atlas as it fills: `cells` (H*W, n, n, C) of all texels, and the plan's rows that are there."""

    def __init__(self, plan: CapturePlan, thumbnail: Thumbnail | None, channels: int) -> None:
        layout, n = plan.layout, plan.layout.bucket
        self.cells = np.zeros((layout.height * layout.width, n, n, channels), dtype=np.float32)
        self._plan, self._thumbnail = plan, thumbnail
        self._there = np.zeros(plan.rows, dtype=bool)

    @property
    def texels(self) -> int:
        """How many are there."""
        return min(int(self._there.sum()) * self._plan.columns, len(self._plan.texel))

    def restore(self, keeper: Keeper) -> None:
        """Put what was kept of an earlier session."""
        for name in keeper.names():
            tile = _tile(name)
            if tile is None or tile.first_row + tile.rows > len(self._there):
                continue
            kept = keeper.found(name)
            if kept is not None:
                self.put(tile, kept["cells"])

    def put(self, tile: Tile, cells: Floats) -> None:
        """Put a tile's cells in their places. Raises BakeError for what cannot be."""
        texel, n = self._plan.texels_of(tile), self._plan.layout.bucket
        self.cells[texel] = _checked(cells, (len(texel), n, n, self.cells.shape[3]))
        self._there[tile.first_row : tile.first_row + tile.rows] = True
        if self._thumbnail is not None:
            self._thumbnail.add(self._plan.layout, texel, cells[..., :3].mean(axis=(1, 2)))

    def missing(self, most: int) -> Tile | None:
        """The first rows that are not there, `most` at most; None where all are."""
        if self._there.all():
            return None
        first = int(np.argmin(self._there))
        after = self._there[first:]
        free = int(np.argmax(after)) if after.any() else len(after)
        return Tile(first, min(most, free))


def _name(tile: Tile) -> str:
    return f"tile-{tile.first_row:06d}-{tile.rows}"


def _tile(name: str) -> Tile | None:
    """The tile that is kept under `name`, if it is one's."""
    found = re.fullmatch(r"tile-(\d+)-(\d+)", name)
    return Tile(int(found[1]), int(found[2])) if found else None


def _checked(cells: Floats, shape: tuple[int, ...]) -> Floats:
    if cells.shape != shape:
        raise BakeError(f"the capture returned cells of shape {cells.shape}, expected {shape}")
    wrong = int(np.count_nonzero(np.isnan(cells)))
    if wrong:
        raise BakeError(
            f"Cycles returned {wrong} values that are not numbers: look for a material that divides by 0"
        )
    return cells
