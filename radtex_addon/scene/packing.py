# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packing flattened islands into an atlas whose longer side is exactly as many texels as asked for.

xatlas packs at a given texel density and lets the atlas grow; it shrinks nothing to fit. So densities
are tried until the longer side just fits. Islands are placed, never scaled afterwards: the gaps between
them stay whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xatlas

from ..core.arrays import Floats
from ..core.errors import InputError
from ..core.islands import weld
from .flatten import FlatIslands

_TRIES = 9  # bisections: the density comes within half a percent of the best
_THOROUGH = 256  # texels up to which xatlas tries every place, instead of 4096 random ones per island


@dataclass(frozen=True, eq=False)
class Packed:
    """`uv` (F, 3, 2) in texels, within `width` x `height`; `density` is in texels per scene unit."""

    uv: Floats
    width: int
    height: int
    density: float


def pack_to_size(flat: FlatIslands, texels: int, padding: int) -> Packed:
    """Pack islands as large as they fit into an atlas whose longer side is `texels`.

    At least `padding` texels that no island touches lie between two islands, and no bilinear lookup in
    one reads a texel of another, even at 0. Raises InputError where the islands are too many for so few
    texels.
    """
    packer = _Packer(flat, padding, thorough=texels <= _THOROUGH)
    high = 1.5 * texels / math.sqrt(flat.area)
    low = high / 64
    best = packer.pack(low)
    if max(best.width, best.height) > texels:
        count = flat.count
        raise InputError(
            f"{texels} texels are too few for the {count} islands of this unwrap with a padding of {padding}:"
            f" ask for at least {_next_power_of_two(max(best.width, best.height))} texels, or less padding"
        )
    for _ in range(_TRIES):
        density = math.sqrt(low * high)
        packed = packer.pack(density)
        if max(packed.width, packed.height) <= texels:
            best, low = packed, density
        else:
            high = density
    if best.width >= best.height:
        return Packed(best.uv, texels, best.height, best.density)
    return Packed(best.uv, best.width, texels, best.density)


def pack_to_density(flat: FlatIslands, density: float, padding: int) -> Packed:
    """Pack islands at `density` texels per scene unit; the atlas is as large as it takes."""
    return _Packer(flat, padding, thorough=density * math.sqrt(flat.area) <= _THOROUGH).pack(density)


class _Packer:
    """xatlas with one set of islands, packed as often as you like."""

    def __init__(self, flat: FlatIslands, padding: int, *, thorough: bool) -> None:
        self._flat = flat
        self._options = xatlas.PackOptions()
        # xatlas keeps its padding around every island, so two of them lie twice as far apart.
        self._options.padding = (padding + 1) // 2
        self._options.bilinear = True
        self._options.bruteForce = thorough
        self._real = flat.island >= 0
        corners = flat.uv[self._real].reshape(-1, 2) / flat.unit
        owner = np.repeat(flat.island[self._real], 3)
        key = weld(np.column_stack([corners, owner]))
        _, first, index = np.unique(key, return_index=True, return_inverse=True)
        self._points = corners[first].astype(np.float32)
        self._index = index.reshape(-1, 3).astype(np.uint32)
        self._owner = flat.island[self._real, None].astype(np.uint32)

    def pack(self, density: float) -> Packed:
        self._options.texels_per_unit = density * self._flat.unit
        atlas = xatlas.Atlas()
        atlas.add_uv_mesh(self._points, self._index, self._owner)
        atlas.generate(xatlas.ChartOptions(), self._options)
        _, index, uv = atlas.get_mesh(0)
        size = np.array([max(atlas.width, 1), max(atlas.height, 1)])
        placed = np.zeros(self._flat.uv.shape)
        placed[self._real] = uv[index].astype(np.float64) * size
        return Packed(placed, int(size[0]), int(size[1]), density)


def _next_power_of_two(value: int) -> int:
    return 1 << max(value - 1, 0).bit_length()
