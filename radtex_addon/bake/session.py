# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The session: asks a capture for tile after tile, and puts the cells where they belong."""

from __future__ import annotations

from collections.abc import Generator
from time import perf_counter

import numpy as np

from ..core.arrays import Bools, Floats
from ..core.errors import BakeError
from .capture import Capture
from .filling import fill_missing
from .plan import CapturePlan, Tile
from .progress import Progress, Stage

BYTES_PER_PIXEL = 112  # of a tile: Cycles's buffers, the render result, the file, our copy (measured peak)
SECONDS_PER_TILE = 2.0  # a tile this long reports often and still hides the cost of a render call


def fill_atlas(
    plan: CapturePlan, capture: Capture, memory_mb: int, hidden: Bools | None = None
) -> Generator[Progress, None, Floats]:
    """Capture the plan's texels, fill gutters and `hidden` cells, and yield progress in texels.

    `hidden` (K, n, n) marks cells, in the order of `plan.texel`, whose captured value is not to be used.
    Returns the atlas image (H*n, W*n, 4) float32, row 0 at the bottom. Tiles stay below `memory_mb` and near
    SECONDS_PER_TILE; their heights do not change the bits. Raises BakeError for cells that are not numbers.
    """
    layout = plan.layout
    n, count = layout.bucket, len(plan.texel)
    flat = np.zeros((layout.height * layout.width, n, n, 4), dtype=np.float32)
    most = max(1, memory_mb * 2**20 // (plan.columns * n * n * BYTES_PER_PIXEL))
    yield Progress(Stage.CAPTURE, 0, count)
    row, height = 0, 1  # the first tile also loads the scene, and tells the pace
    while row < plan.rows:
        tile = Tile(row, min(height, plan.rows - row))
        started = perf_counter()
        cells = capture.render(tile)
        seconds = perf_counter() - started
        texel = plan.texels_of(tile)
        flat[texel] = _checked(cells, (len(texel), n, n, 4))
        row += tile.rows
        yield Progress(Stage.CAPTURE, min(row * plan.columns, count), count)
        height = max(1, min(most, 4 * height, int(tile.rows * SECONDS_PER_TILE / max(seconds, 1e-3))))
    yield Progress(Stage.FILL, 0, 1)
    buckets = flat.reshape(layout.height, layout.width, n, n, 4)
    marks = plan.placed(hidden) if hidden is not None and hidden.any() else None
    yield from fill_missing(buckets, plan.covered, marks)
    yield Progress(Stage.FILL, 1, 1)
    return layout.from_buckets(buckets)


def _checked(cells: Floats, shape: tuple[int, ...]) -> Floats:
    if cells.shape != shape:
        raise BakeError(f"the capture returned cells of shape {cells.shape}, expected {shape}")
    wrong = int(np.count_nonzero(np.isnan(cells)))
    if wrong:
        raise BakeError(
            f"Cycles returned {wrong} values that are not numbers: look for a material that divides by 0"
        )
    return cells
