# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack flattened islands, by their true outlines, into an atlas of so many texels.

Islands of small atlases are packed closer, texel by texel, than the library does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...bake.progress import Steps, in_a_thread
from ...core.arrays import Bools, Floats, Ints
from ...core.cell_packing import Spot, place
from ...core.islands import first_and_index, signed_areas, weld
from ...core.texel_map import triangle_of_texels
from ..mesh.flatten import FlatIslands
from .uvunwrap_job import MERGED, PackedIslands, pack, unwrap_progress

_MOST_GAIN = 1.7  # times as dense: more than islands gain by closer packing
_TRIES = 7  # of densities, each half as far from the best one as the last
_QUICK = 40_000_000  # islands times texels: a try of so many takes a second
_ENDS_THERE = 1e-3  # texels: an island that ends this close to a texel's edge ends there
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
    loose: PackedIslands | None


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


def _on_centres(placed: PackedIslands) -> Floats:
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


def packed_closer(packed: Packed, texels: int, padding: int) -> Steps[Packed]:
    """Pack islands again, larger, with no more than `padding` free texels between those that they touch.

    The library leaves up to twice as many, and one more where sides are moved to texels' centres: in small
    atlases, most of the place. Here each island's box is made as large as a whole number of texels, and the
    texels that it touches are packed; two free texels are the least, or lookups in two islands would read the
    same one. `packed` is returned where that is no better, where the padding is 0, and where there are too
    many texels and islands, or triangles, for that to be quick. Yields progress.
    """
    if packed.loose is None or not padding or packed.islands * texels**2 > _QUICK:
        return packed
    shapes = _Shapes.of(packed.loose)
    best = packed
    low = shapes.density(packed.uv[packed.island >= 0])
    high = low * _MOST_GAIN
    for number in range(_TRIES):
        density = math.sqrt(low * high)
        outlines = shapes.at(density)
        spots = place(outlines.masks, texels, texels, max(padding, 2))
        if spots is None:
            high = density
        else:
            low = density
            best = _moved(packed, shapes, outlines, spots, texels)
        yield unwrap_progress(MERGED + (1 - MERGED) * (number + 1) / _TRIES)
    return best


@dataclass(frozen=True, eq=False)
class _Outlines:
    """Islands of whole texels: `uv` (F, 3, 2) from each one's own corner, and the texels that it touches."""

    uv: Floats
    owner: Ints
    masks: list[Bools]


@dataclass(frozen=True, eq=False)
class _Shapes:
    """Islands, in any unit: `uv` (F, 3, 2) from the lower corner of each one's box, `size` (I, 2) of it.

    As the library placed them, they had `loose` texels a unit.
    """

    uv: Floats
    owner: Ints
    size: Floats
    loose: float

    @classmethod
    def of(cls, placed: PackedIslands) -> _Shapes:
        some = placed.owner >= 0
        owner = placed.owner[some]
        low, high = boxes(placed.uv[some], owner, placed.islands)
        uv = (placed.uv[some] - low[owner][:, None]) / placed.density
        return cls(uv, owner, (high - low) / placed.density, placed.density)

    def density(self, uv: Floats) -> float:
        """Texels along a unit of the islands, in the mean, as placed at `uv` (F, 3, 2)."""
        shown, whole = (float(np.abs(signed_areas(each)).sum()) for each in (uv, self.uv))
        return math.sqrt(shown / whole)

    def at(self, density: float) -> _Outlines:
        """The islands of so many texels a unit, their boxes rounded to whole texels between centres."""
        size = self.size * density
        whole = np.where(size < 0.5, size, np.maximum(np.round(size), 1))
        start = np.where(size < 0.5, (1 - size) / 2, 0.5)
        scale = np.divide(whole, self.size, out=np.zeros_like(size), where=self.size > 0)
        uv = self.uv * scale[self.owner][:, None] + start[self.owner][:, None]
        cells = np.where(size < 0.5, 1, whole + 1).astype(np.int64)
        ends = np.cumsum(cells[:, 0] + 1)  # side by side, with a column between
        begins = ends - cells[:, 0] - 1
        width, height = int(ends[-1]), int(cells[:, 1].max())
        row = uv.copy()
        row[..., 0] += begins[self.owner][:, None]
        touched = triangle_of_texels(row / [width, height], width, height) >= 0
        places = zip(begins.tolist(), cells.tolist(), strict=True)
        return _Outlines(uv, self.owner, [touched[:h, x : x + w] for x, (w, h) in places])


def _moved(packed: Packed, shapes: _Shapes, outlines: _Outlines, spots: list[Spot], texels: int) -> Packed:
    """The islands at their spots; the atlas's longer side is `texels`."""
    turned = np.array([spot.turned for spot in spots])[outlines.owner]
    tall = np.array([len(mask) for mask in outlines.masks])[outlines.owner]
    corner = np.array([[spot.column, spot.row] for spot in spots])[outlines.owner]
    uv = outlines.uv.copy()
    uv[turned] = np.stack([tall[turned][:, None] - uv[turned][..., 1], uv[turned][..., 0]], axis=-1)
    uv += corner[:, None]
    width, height = (int(np.ceil(most - _ENDS_THERE)) for most in uv.max(axis=(0, 1)))
    width, height = (texels, height) if width >= height else (width, texels)
    placed = packed.uv.copy()
    placed[packed.island >= 0] = uv
    density = packed.density * shapes.density(uv) / shapes.loose
    return replace(packed, uv=placed, width=width, height=height, density=density)
