# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of what surrounds the object it leaves free itself, for each bucket and direction.

Kept is a picture of that, blurred as wide as its cells: see `lookup.visibility`.
"""

from __future__ import annotations

import numpy as np

from ....bake.light_samples import LobeSamples
from ....core.arrays import Bools, Floats
from .bucket_grid import Block, BucketGrid

_PRIOR = 0.0125  # of a cell's rays: the wider neighbourhood's count for that many


def free_share(rays: LobeSamples, hit: Bools, grid: BucketGrid, cells: int) -> Floats:
    """The share of mirror rays that miss the object, by direction: (1, B, cells * cells).

    `hit` (K, S): which of the `rays` do not.
    """
    if not hit.any():
        return np.ones((1, len(grid), cells * cells), dtype=np.float32)
    table = np.empty((2, len(grid), cells * cells), dtype=np.float32)

    def sum_up(block: Block) -> None:
        _, place = rays.along(block.texels)
        missed = (~hit[block.texels]).astype(np.float32)
        table[:, block.buckets] = block.scatter(place, cells, [missed, np.ones_like(missed)])

    grid.in_blocks(sum_up, hit.shape[1])
    prior = np.float32(_PRIOR * float(table[1].mean()))

    def share(own: Floats, wide: Floats) -> Floats:
        usual = (wide[0] + 1e-3) / (wide[1] + 1e-3)
        free: Floats = (own[0] + prior * usual) / (own[1] + prior)
        return free[None]

    return grid.pool(table, grid.neighbours.pool_further, share).copy()
