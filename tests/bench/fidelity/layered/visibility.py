# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of what surrounds the object it leaves free itself, for each texel and direction.

Kept is a picture of that, blurred as wide as its cells. A sharp lobe needs a sharper edge: where the edge is
straight, blurring a half-space by a lobe of another width (see lobes.py) changes F(d / s) into F(d / t),
where F(x) = 1/2 + x / (2 sqrt(2 + x²)).
"""

from __future__ import annotations

from typing import cast

import numpy as np

from radtex_addon.bake.blocks import in_blocks
from radtex_addon.bake.gloss import LobeSamples
from radtex_addon.bake.pooling import Neighbours, Taps
from radtex_addon.core.arrays import Bools, Floats

_KEPT = 2.56  # the kept mask's own blur, times the number of its cells along a side, radians
_EDGE = 0.04  # the sharpest edge that is shown, radians: cells do not tell where it is any better
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


def seen_free(kept: Floats, variance: Floats, cells: int) -> Floats:
    """The kept mask (N,) as a lobe of widths² (N,) sees it: (N,)."""
    sharper = np.maximum(_KEPT / cells / np.sqrt(variance + _EDGE**2), 1)
    place = np.clip(2 * kept - 1, -1, 1) * sharper
    return cast(
        Floats, (0.5 + 0.5 * place / np.sqrt(1 - (place / sharper) ** 2 + place**2)).astype(np.float32)
    )
