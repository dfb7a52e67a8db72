# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack flattened islands into an atlas with a given number of texels along its longer side.

xatlas packs at a given texel density and lets the atlas grow; it does not shrink islands to fit. So densities
are tried until the longer side just fits. Islands are not scaled after packing, so the gaps between them keep
their width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from ...core.islands import weld
from ..mesh.flatten import FlatIslands
from .xatlas_process import Options, Steps, XatlasProcess

_TRIES = 9  # bisections: the density comes within half a percent of the best
_THOROUGH = 256  # texels up to which xatlas tries every place, instead of 4096 random ones per island


@dataclass(frozen=True, eq=False)
class Packed:
    """`uv` (F, 3, 2) in texels, within `width` x `height`; `density` is in texels per scene unit."""

    uv: Floats
    width: int
    height: int
    density: float


def pack_to_size(xatlas: XatlasProcess, flat: FlatIslands, texels: int, padding: int) -> Steps[Packed]:
    """Pack islands as large as they fit into an atlas whose longer side is `texels`.

    At least `padding` texels that no island touches lie between two islands, and no bilinear lookup in one
    reads a texel of another, even with a padding of 0. Yields progress. Raises InputError if there are too
    many islands for so few texels.
    """
    packer = _Packer(xatlas, flat, padding, thorough=texels <= _THOROUGH)
    high = 1.5 * texels / math.sqrt(flat.area)
    low = high / 64
    best = yield from packer.pack(low)
    if max(best.width, best.height) > texels:
        count = flat.count
        raise InputError(
            f"{texels} texels are too few for the {count} islands of this unwrap with a padding of {padding}:"
            f" ask for at least {_next_power_of_two(max(best.width, best.height))} texels, or less padding"
        )
    for _ in range(_TRIES):
        density = math.sqrt(low * high)
        packed = yield from packer.pack(density)
        if max(packed.width, packed.height) <= texels:
            best, low = packed, density
        else:
            high = density
    if best.width >= best.height:
        return Packed(best.uv, texels, best.height, best.density)
    return Packed(best.uv, best.width, texels, best.density)


def pack_to_density(xatlas: XatlasProcess, flat: FlatIslands, density: float, padding: int) -> Steps[Packed]:
    """Pack islands at `density` texels per scene unit; the atlas is as large as needed. Yields progress."""
    thorough = density * math.sqrt(flat.area) <= _THOROUGH
    return _Packer(xatlas, flat, padding, thorough=thorough).pack(density)


class _Packer:
    """Packs one set of islands with xatlas, as often as wanted."""

    def __init__(self, xatlas: XatlasProcess, flat: FlatIslands, padding: int, *, thorough: bool) -> None:
        self._xatlas, self._flat = xatlas, flat
        # xatlas adds padding around every island, so two islands lie twice the padding apart.
        self._options: Options = {"padding": (padding + 1) // 2, "bilinear": True, "bruteForce": thorough}
        self._real = flat.island >= 0
        corners = flat.uv[self._real].reshape(-1, 2) / flat.unit
        owner = np.repeat(flat.island[self._real], 3)
        key = weld(np.column_stack([corners, owner]))
        _, first, index = np.unique(key, return_index=True, return_inverse=True)
        self._points = corners[first].astype(np.float32)
        self._index = index.reshape(-1, 3).astype(np.uint32)
        self._owner = flat.island[self._real, None].astype(np.uint32)

    def pack(self, density: float) -> Steps[Packed]:
        options = {**self._options, "texels_per_unit": density * self._flat.unit}
        found = yield from self._xatlas.pack(self._points, self._index, self._owner, options)
        size = np.array([max(found.width, 1), max(found.height, 1)])
        placed = np.zeros(self._flat.uv.shape)
        placed[self._real] = found.uv[found.index].astype(np.float64) * size
        return Packed(placed, int(size[0]), int(size[1]), density)


def _next_power_of_two(value: int) -> int:
    return 1 << max(value - 1, 0).bit_length()
