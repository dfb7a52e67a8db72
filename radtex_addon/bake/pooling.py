# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sum samples in the cells of octahedral buckets, and over neighbouring texels.

A fit works on K texels of n x n cells; their tables are (C, K, n*n) float32, channels first.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ..core import large_arrays
from ..core.arrays import Floats, Ints
from ..core.octahedron import cell_places, octahedron_taps
from .blocks import in_blocks, side_by_side
from .plan import CapturePlan

_KERNEL = np.array([0.054489, 0.244201, 0.402620, 0.244201, 0.054489], dtype=np.float32)  # sigma 1 texel
_NEAR = 6.0  # times the median distance between texels: farther ones belong to another island
_POOLED_AT_ONCE = 1 << 18  # sums
_TILE = 4  # texels along the side of a block pooled at once: OpenBLAS computes 16 x 64 x 256 on one core
SHARE = float((_KERNEL**2).sum() ** 2)  # share of a sum's variance that is left after pooling


def corners(place: Floats, n: int | Ints) -> tuple[Ints, Floats]:
    """The four cells around places (2, ...) on the octahedron's square of n x n cells, and their weights.

    Returns the flat index of the corner that the four cells share (...), of (n + 1) x (n + 1) corners with
    those on the edges, and the bilinear weights of the cells (4, ...), in the order of `corner_cells`.
    """
    flat, x, y = corner_and_fractions(place, n)
    weights = np.empty((4, *flat.shape), dtype=x.dtype)
    np.multiply(x, y, out=weights[3])
    np.subtract(x, weights[3], out=weights[1])
    np.subtract(y, weights[3], out=weights[2])
    np.subtract(1 - x, weights[2], out=weights[0])
    return flat, weights


def corner_and_fractions(place: Floats, n: int | Ints) -> tuple[Ints, Floats, Floats]:
    """As `corners`, with how far from the first cell's middle to the others' places are, along both axes."""
    side = np.asarray(n, dtype=np.float32)
    x, y = place * side + np.float32(0.5)
    column, row = x.astype(np.int32), y.astype(np.int32)  # at most n, as a place is at most 1
    flat = row.astype(np.intp) * (np.asarray(n) + 1) + column
    return flat, x - column.astype(x.dtype), y - row.astype(y.dtype)


@cache
def corner_cells(n: int) -> Ints:
    """The flat indices of the four cells around each corner: (4, (n + 1)²)."""
    corner = np.arange(n + 1) / n
    place = np.stack(np.meshgrid(corner, corner), axis=-1).reshape(-1, 2)
    return np.stack([cell for cell, _ in octahedron_taps(place, n)]).astype(np.intp)


@dataclass(frozen=True, eq=False)
class Taps:
    """The four cells that each of a block's samples falls on, and their weights, both (4, k, S).

    The buckets have n x n cells; `cells` are flat indices into the block's k * n * n.
    """

    cells: Ints
    weights: Floats
    n: int

    @classmethod
    def of(cls, place: Floats, n: int) -> Taps:
        """From the places (2, k, S) of k texels' samples on the octahedron's square."""
        corner, weights = corners(place, n)
        first = np.arange(place.shape[1], dtype=np.intp)[:, None] * (n * n)
        return cls(corner_cells(n).take(corner, axis=1) + first, weights, n)

    def gather(self, table: Floats) -> Floats:
        """Look the block's table (C, k, n*n) up at the samples: (C, k, S)."""
        found = np.zeros((len(table), *self.cells.shape[1:]), dtype=np.float32)
        for number, channel in enumerate(table.reshape(len(table), -1)):
            for cells, weights in zip(self.cells, self.weights, strict=True):
                found[number] += weights * channel.take(cells)
        return found

    def scatter(self, columns: Iterable[Floats]) -> Floats:
        """Sum the samples' columns, (k, S) each, in the cells: (C, k, n*n)."""
        texels, cells = self.cells.shape[1], self.n * self.n
        flat = self.cells.ravel()
        sums = [np.bincount(flat, (self.weights * column).ravel(), texels * cells) for column in columns]
        return np.stack(sums).astype(np.float32).reshape(-1, texels, cells)


@dataclass(frozen=True, eq=False)
class _Tile:
    """Some texels (g,), the texels around them (u,), and the kernel's weights (g, u)."""

    texels: Ints
    around: Ints
    weights: Floats


@dataclass(frozen=True)
class Blur:
    """A blur along both axes: an odd number of taps that sum to 1, `step` texels apart."""

    taps: tuple[float, ...]
    step: int = 1


_NEAR_BLUR = Blur(tuple(_KERNEL.tolist()))
_WIDE_BLUR = Blur(_NEAR_BLUR.taps, 3)


@dataclass
class Neighbours:
    """The texels around each of a plan's texels, on the same piece of surface.

    Sums are blurred by `near`, a Gaussian with a sigma of one texel unless another is given, and if they are
    pooled widely also by `wide`, of about three.
    """

    plan: CapturePlan
    near: Blur = _NEAR_BLUR
    wide: Blur = _WIDE_BLUR
    _found: dict[Blur, list[_Tile]] = field(default_factory=dict)

    def of(self, plan: CapturePlan) -> Neighbours:
        """The same blurs, of the texels of another plan."""
        return Neighbours(plan, self.near, self.wide)

    def pool(self, table: Floats, wide: bool = False) -> Floats:
        """Add to each texel's sums (C, K, m) its neighbours', weighted, at the same world direction."""
        near = self._pooled(table, self.near)
        return self._pooled(near, self.wide) if wide else near

    def pool_further(self, near: Floats) -> Floats:
        """Pool sums (C, K, m) widely that are pooled already."""
        return self._pooled(near, self.wide)

    def _pooled(self, table: Floats, blur: Blur) -> Floats:
        result = large_arrays.empty(table.shape)
        table = np.ascontiguousarray(table)  # `take` would copy all of another one, for each tile

        def pool(tiles: list[_Tile]) -> None:
            for tile in tiles:
                result[:, tile.texels] = tile.weights @ table.take(tile.around, axis=1)

        tiles = self._tiles(blur)
        step = max(1, _POOLED_AT_ONCE // (table[:, :1].size * _TILE * _TILE))
        side_by_side(pool, [tiles[first : first + step] for first in range(0, len(tiles), step)])
        return result

    def _tiles(self, blur: Blur) -> list[_Tile]:
        """All texels in tiles that share many neighbours."""
        if blur not in self._found:
            step = blur.step
            other, weight = self._around(blur)
            j, i = np.divmod(self.plan.texel, self.plan.layout.width)
            side = _TILE * step
            corner = np.stack([j // side, i // side, j % step, i % step])
            tile = np.unique(corner, axis=1, return_inverse=True)[1].ravel()
            order = np.argsort(tile, kind="stable")
            cuts = np.flatnonzero(np.diff(tile[order])) + 1
            alike: dict[tuple[tuple[int, ...], bytes], Floats] = {}  # nearly all tiles have the same weights
            self._found[blur] = [_tile(texels, other, weight, alike) for texels in np.split(order, cuts)]
        return self._found[blur]

    def _around(self, blur: Blur) -> tuple[Ints, Floats]:
        """Texel numbers and weights (T * T, K) of a blur of T taps."""
        layout, count = self.plan.layout, len(self.plan.texel)
        place = self.plan.points
        kernel, step = np.array(blur.taps, dtype=np.float32), blur.step
        middle = len(kernel) // 2
        reach = middle * step
        number = np.full((layout.height + 2 * reach, layout.width + 2 * reach), -1, dtype=np.int32)
        j, i = self.plan.texel // layout.width + reach, self.plan.texel % layout.width + reach
        number[j, i] = np.arange(count)

        def offset(dy: int, dx: int) -> tuple[Ints, Floats]:
            other = number[j + dy, i + dx]
            apart = np.linalg.norm(place - place[np.maximum(other, 0)], axis=1)
            return other, np.where(other >= 0, apart, np.inf)

        _, apart = offset(0, 1) if layout.width > 1 else offset(1, 0)
        usual = float(np.median(apart[np.isfinite(apart)])) if np.isfinite(apart).any() else 0.0
        others = large_arrays.empty((len(kernel) ** 2, count), np.int32)
        weights = large_arrays.empty((len(kernel) ** 2, count))
        for y, along_y in enumerate(kernel):
            for x, along_x in enumerate(kernel):
                dy, dx = (y - middle) * step, (x - middle) * step
                other, apart = offset(dy, dx)
                near = apart <= _NEAR * usual * max(step, float(np.hypot(dx, dy)))
                others[y * len(kernel) + x] = np.maximum(other, 0)
                weights[y * len(kernel) + x] = along_y * along_x * near
        return others, weights


def _tile(
    texels: Ints, other: Ints, weight: Floats, alike: dict[tuple[tuple[int, ...], bytes], Floats]
) -> _Tile:
    """A tile of texels (g,); `other` and `weight` are those of `_around`, `alike` are tiles' weights."""
    tap, row = np.nonzero(weight[:, texels])
    around, column = np.unique(other[tap, texels[row]], return_inverse=True)
    weights = np.zeros((len(texels), len(around)), dtype=np.float32)
    weights[row, column] = weight[tap, texels[row]]
    weights = alike.setdefault((weights.shape, weights.tobytes()), weights)
    return _Tile(texels.astype(np.int32), around.astype(np.int32), weights)


@cache
def _upsampling(n: int, finer: int) -> Floats:
    """The weight of each of n x n cells in each cell of a finer bucket: (n*n, finer*finer)."""
    share = np.zeros((n * n, finer * finer), dtype=np.float32)
    for cell, weight in octahedron_taps(cell_places(finer), n):
        share[cell, np.arange(finer * finer)] += weight
    return share


def upsampled(table: Floats, finer: int) -> Floats:
    """Interpolate buckets of n x n cells to finer x finer cells: (C, K, n*n) -> (C, K, finer*finer)."""
    channels, texels, cells = table.shape
    n = round(cells**0.5)
    if n == finer:
        return table
    result = np.empty((channels, texels, finer * finer), dtype=np.float32)

    def look_up(some: slice) -> None:
        np.matmul(table[:, some], _upsampling(n, finer), out=result[:, some])

    in_blocks(look_up, texels, finer * finer, _TILE * _TILE * finer * finer)
    return result
