# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack flattened islands, by their true outlines, into an atlas of so many texels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...bake.progress import Steps, in_a_thread
from ...core.arrays import Bools, Floats, Ints
from ...core.islands import first_and_index, weld
from ..mesh.flatten import FlatIslands
from .uvunwrap_job import MERGED, Placed, pack, unwrap_progress

_HUGE = 1_000_000  # triangles
_ROUNDING = 1e-3  # texels: a side this close to a texel's edge lies on it


@dataclass(frozen=True, eq=False)
class Packed:
    """`uv` (F, 3, 2) in texels, within `width` x `height`; `density` is in texels per scene unit.

    `island` (F,) numbers the `islands`, -1 for none: those that were too long for the atlas, or overlapped
    themselves, were taken apart. `loose` is how the library placed the triangles that are in islands; None of
    more than a million triangles, where it is large.
    """

    uv: Floats
    island: Ints
    islands: int
    width: int
    height: int
    density: float
    loose: Placed | None


def pack_islands(flat: FlatIslands, texels: int, padding: int) -> Steps[Packed]:
    """Pack islands as large as they fit into an atlas whose longer side is `texels`.

    At least `padding` texels that no island touches lie between two islands, and no bilinear lookup in
    one reads a texel of another, even with a padding of 0. Islands are squeezed by less than a texel, so
    that straight sides go through the centres of texels: what is looked up there is the side's own light.
    Yields progress. Raises InputError if there are too many islands for so few texels, BakeError if
    packing fails.
    """
    real = flat.island >= 0
    points, index, owner = yield from in_a_thread(lambda: _welded(flat, real), unwrap_progress(MERGED))
    around = (padding + 3) // 2 if padding else 1  # two islands lie at least twice as many, less two, apart
    found = yield from pack(points, index, owner, around, texels)
    placed = np.zeros(flat.uv.shape)
    placed[real] = yield from in_a_thread(lambda: _on_centres(found), unwrap_progress(MERGED))
    island = np.full(len(real), -1)
    island[real] = found.owner
    width, height = max(found.width, 1), max(found.height, 1)
    width, height = (texels, height) if width >= height else (width, texels)
    loose = found if len(flat.uv) <= _HUGE else None
    return Packed(placed, island, found.islands, width, height, found.density / flat.unit, loose)


def _welded(flat: FlatIslands, real: Bools) -> tuple[Floats, Ints, Ints]:
    """Points (P, 2) in units of `flat`, the `real` (F,) triangles (T, 3) of them, and their islands (P,)."""
    corners = flat.uv[real].reshape(-1, 2) / flat.unit
    owner = np.repeat(flat.island[real], 3)
    first, index = first_and_index(weld(np.column_stack([corners, owner])))
    return corners[first], index.reshape(-1, 3), owner[first]


def _on_centres(placed: Placed) -> Floats:
    """The packed uv (F, 3, 2), each island's bounding box with its sides through centres of texels.

    Sides move within their texel, so that no island touches another texel than before.
    """
    some = placed.owner >= 0
    owner, uv = placed.owner[some], placed.uv[some]
    low, high = boxes(uv, owner, placed.islands)
    first = np.floor(low + _ROUNDING) + 0.5
    last = np.maximum(np.ceil(high - _ROUNDING) - 0.5, first)
    narrow = last - first < 1  # a texel or less: as it is
    scale = np.where(narrow, 1.0, (last - first) / np.maximum(high - low, 1e-30))
    start = np.where(narrow, low, first)
    moved = placed.uv.copy()
    moved[some] = (uv - low[owner][:, None]) * scale[owner][:, None] + start[owner][:, None]
    return moved


def boxes(uv: Floats, owner: Ints, count: int) -> tuple[Floats, Floats]:
    """Lower and upper corners of the islands' bounding boxes: (I, 2) both."""
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, owner, uv.min(axis=1))
    np.maximum.at(high, owner, uv.max(axis=1))
    return low, high
