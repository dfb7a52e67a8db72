# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack the islands of small atlases closer, texel by texel, than the library does."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...bake.progress import Steps
from ...core.arrays import Bools, Floats, Ints
from ...core.cell_packing import Spot, place
from ...core.islands import signed_areas
from ...core.texel_map import triangle_of_texels
from .island_packing import Packed, boxes
from .uvunwrap_job import MERGED, Placed, unwrap_progress

_MOST_GAIN = 1.7  # times as dense: more than islands gain by closer packing
_TRIES = 7  # of densities, each half as far from the best one as the last
_QUICK = 8_000_000  # islands times texels: a try of so many takes a second
_ROUNDING = 1e-3  # texels: an island that ends this close to a texel's edge ends there


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
    def of(cls, placed: Placed) -> _Shapes:
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
    width, height = (int(np.ceil(most - _ROUNDING)) for most in uv.max(axis=(0, 1)))
    width, height = (texels, height) if width >= height else (width, texels)
    placed = packed.uv.copy()
    placed[packed.island >= 0] = uv
    density = packed.density * shapes.density(uv) / shapes.loose
    return replace(packed, uv=placed, width=width, height=height, density=density)
