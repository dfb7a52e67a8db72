# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of what surrounds the object it leaves free itself, for each texel and direction.

Kept is a picture of that, blurred as wide as its cells: see `lookup.visibility`.
"""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.light_samples import LobeSamples
from ....bake.pooling import Neighbours, Taps
from ....core.arrays import Bools, Floats

_OWN = 3.0  # how much a texel's own rays count for, against those of its neighbourhood
_PRIOR = 0.05  # of a cell's rays: the wider neighbourhood's count for that many


def free_share(rays: LobeSamples, missed: Bools, neighbours: Neighbours, cells: int) -> Floats:
    """The share of mirror rays that miss the object, by direction: (1, K, cells * cells).

    `missed` (K, S): which of the `rays` do.
    """
    table = np.empty((2, len(missed), cells * cells), dtype=np.float32)

    def sum_up(some: slice) -> None:
        _, place = rays.along(some)
        columns = [missed[some].astype(np.float32), np.ones(missed[some].shape, np.float32)]
        table[:, some] = Taps.of(place, cells).scatter(columns)

    in_blocks(sum_up, *missed.shape)
    near, wide = neighbours.pool(table), neighbours.pool(table, True)
    share = (wide[0] + 1e-3) / (wide[1] + 1e-3)
    prior = np.float32(_PRIOR * float(table[1].mean()))
    free: Floats = (_OWN * table[0] + near[0] + prior * share) / (_OWN * table[1] + near[1] + prior)
    return free[None]
