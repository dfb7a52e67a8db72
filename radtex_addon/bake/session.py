# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session: capture tile after tile by what renders them, and store each."""

from __future__ import annotations

from collections.abc import Generator
from time import perf_counter
from typing import Protocol

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.errors import BakeError
from .bands import Bands, find_bands
from .cells import Cells
from .denoising import Denoiser, denoise_cells
from .hidden_cells import HiddenCells
from .layers import WHOLE, Layer
from .piece_store import NO_STORE, MemoryStore, PieceStore
from .plan import CapturePlan, Tile
from .progress import Progress, Stage
from .thumbnail import Thumbnail

BYTES_PER_PIXEL = 112  # of a tile: Cycles's buffers, the render result, the file, our copy (measured peak)
SECONDS_PER_TILE = 2.0  # short enough for frequent progress, long against the cost of a render call


class Capture(Protocol):
    """A renderer, set up for one plan."""

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels: (k, n, n, C) float32, indexed [texel, q, p], scene-linear Rec.709.

        Channels are RGBA, then three for each layer that the renderer was set up for. Alpha is associated.
        Each value is the mean over its cell, uniform in B. Raises BakeError on failure.
        """
        ...


def fill_atlas(
    plan: CapturePlan,
    capture: Capture,
    memory_mb: int,
    hidden: HiddenCells | None = None,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
    channels: int = WHOLE,
    uncut: bool = False,
) -> Generator[Progress, None, Floats]:
    """As `capture_bands`, but returns one image (H*n, W*n, `channels`) float32, row 0 at the bottom."""
    steps = capture_bands(plan, capture, memory_mb, hidden, store, thumbnail, channels, uncut)
    bands = yield from steps
    layout, n = plan.layout, plan.layout.bucket
    image = np.empty((layout.height, n, layout.width, n, channels), dtype=np.float32)
    for band in bands.downwards():
        image[band.first : band.end] = band.buckets.transpose(0, 2, 1, 3, 4)
    return image.reshape(layout.pixel_height, layout.pixel_width, channels)


def capture_bands(
    plan: CapturePlan,
    capture: Capture,
    memory_mb: int,
    hidden: HiddenCells | None = None,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
    channels: int = WHOLE,
    uncut: bool = False,
    denoiser: Denoiser | None = None,
    layers: tuple[Layer, ...] = (),
) -> Generator[Progress, None, Bands]:
    """Capture the plan's texels, find what fills gutters and `hidden` cells, and yield progress in texels.

    The captured values of `hidden` cells are not used. The `store` stores each tile; rows that it already
    has are not captured again. The `thumbnail` gets all light. Tiles take less than `memory_mb` and about
    SECONDS_PER_TILE, as their height does not change the result; where it would, set `uncut` to render whole
    sheets. A `denoiser` gets all light, also of the captured `layers`. Raises BakeError for cells that are
    not numbers, and where a tile cannot be stored.
    """
    store = store if store.keeps else MemoryStore()
    cells = Cells(plan, store, channels)
    for restored, kept in cells.restore():
        _show(thumbnail, plan, plan.texels_of(restored), kept)
    count, of_pixel = len(plan.texel), BYTES_PER_PIXEL * channels // WHOLE
    most = max(1, memory_mb * 2**20 // (plan.columns * plan.layout.bucket**2 * of_pixel))
    yield Progress(Stage.CAPTURE, cells.texels, count)
    height = plan.sheet_rows if uncut else 1  # the first tile loads the scene, and measures the speed
    while (tile := cells.missing(height)) is not None:
        started = perf_counter()
        found = _captured(capture, plan, tile, channels)
        seconds = perf_counter() - started
        cells.put(tile, found)
        _show(thumbnail, plan, plan.texels_of(tile), found)
        yield Progress(Stage.CAPTURE, cells.texels, count)
        if not uncut:
            height = max(1, min(most, 4 * height, int(tile.rows * SECONDS_PER_TILE / max(seconds, 1e-3))))
    if denoiser is not None:
        cells = yield from denoise_cells(plan, cells, store, hidden, denoiser, layers)
    yield Progress(Stage.FILL, 0, 1)
    bands = yield from find_bands(plan, cells, store, hidden)
    yield Progress(Stage.FILL, 1, 1)
    return bands


def _captured(capture: Capture, plan: CapturePlan, tile: Tile, channels: int) -> Floats:
    """Capture a tile's cells. Raises BakeError for a wrong shape, and values that are not numbers."""
    cells, n = capture.render(tile), plan.layout.bucket
    shape = (len(plan.texels_of(tile)), n, n, channels)
    if cells.shape != shape:
        raise BakeError(f"the capture returned cells of shape {cells.shape}, expected {shape}")
    wrong = int(np.count_nonzero(np.isnan(cells)))
    if wrong:
        raise BakeError(
            f"Cycles returned {wrong} values that are not numbers: look for a material that divides by 0"
        )
    return cells


def _show(thumbnail: Thumbnail | None, plan: CapturePlan, texel: Ints, cells: Floats) -> None:
    if thumbnail is not None:
        thumbnail.add(plan.layout, texel, cells[..., :3].mean(axis=(1, 2)))
