# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A capture whose light is a formula, to test everything except the renderer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radtex_addon.bake.plan import CapturePlan, Tile
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import cell_centres, square_to_direction


@dataclass(frozen=True)
class AnalyticCapture:
    """`light(position, direction)` maps world positions and directions (…, 3) to RGBA (…, 4).

    A cell is the mean over a grid of `side` x `side` directions, uniform in B.
    """

    plan: CapturePlan
    light: Callable[[Floats, Floats], Floats]
    side: int = 4

    def render(self, tile: Tile) -> Floats:
        plan, n = self.plan, self.plan.layout.bucket
        local = square_to_direction(cell_centres(n * self.side))
        rows = slice(tile.first_row, tile.first_row + tile.rows)
        frame = np.stack([field[rows] for field in (plan.tangent, plan.bitangent, plan.normal)], axis=-2)
        count = len(plan.texels_of(tile))
        frame = frame.reshape(-1, 3, 3)[:count]
        position = plan.position[rows].reshape(-1, 1, 1, 3)[:count]
        direction = np.einsum("qpa,kab->kqpb", local, frame)
        light = self.light(np.broadcast_to(position, direction.shape), direction)
        cells = light.reshape(count, n, self.side, n, self.side, 4).mean(axis=(2, 4))
        return cells.astype(np.float32)
