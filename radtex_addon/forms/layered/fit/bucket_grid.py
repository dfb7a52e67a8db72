# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The buckets that a bake keeps: each is of the samples of several texels, pooled with its neighbours'.

Tables are (C, B, n*n) float32, channels first, of the B buckets that hold texels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import TypeVar

import numpy as np

from ....bake.blocks import SAMPLES_AT_ONCE, side_by_side
from ....bake.light_samples import Some
from ....bake.plan import CapturePlan, plan_of_some
from ....bake.pooling import Blur, Neighbours, Taps, corner_and_fractions, corner_cells, corners
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints
from ....core.atlas import AtlasLayout
from ....core.gutter import dilate, nearest_covered
from ....settings.rays import side_in

_Result = TypeVar("_Result")

_NEAR_SHARE = 0.04  # of a bucket's neighbour; with the mean over 2 x 2 texels a sigma of 0.75 texels
_FINE = 64  # texels along a side: where there are fewer, neighbours differ more, and are given less
_WIDE = Blur((0.0418, 0.1156, 0.2125, 0.2602, 0.2125, 0.1156, 0.0418))  # with that a sigma of 3 texels
_POOLED_AT_ONCE = 1 << 26  # bytes of sums
_PART, _LEAST_PART = 8, 512  # of how many buckets one is in the part that choices are judged by; no fewer
_PATCH, _SEED = 8, 3  # buckets along a side of that part's patches, which are drawn at random


def _near(layout: AtlasLayout) -> Blur:
    """The blur that lets neighbouring buckets share their samples."""
    share = _NEAR_SHARE * min(1.0, max(layout.width, layout.height) / _FINE)
    return Blur((share, 1 - 2 * share, share))


@dataclass(frozen=True, eq=False)
class Block:
    """Some of a grid's buckets, their `texels` (k,), and each texel's `bucket`, counted in the block (k,)."""

    buckets: slice
    texels: Ints
    bucket: Ints

    def scatter(self, place: Floats, n: int, columns: Iterable[Floats]) -> Floats:
        """Sum the columns of the texels' samples, (k, S) each, in n x n cells: (C, buckets, n*n).

        `place` (2, k, S) is the samples' places on the octahedron's square. Each column may also be that of
        some samples alone, (p,), if `place` is theirs, (2, p), and `texels` is one for each.
        """
        corner, x, y = corner_and_fractions(place, n)
        count, size = self.buckets.stop - self.buckets.start, (n + 1) ** 2
        flat = (corner + self.bucket.reshape(-1, *[1] * (corner.ndim - 1)) * size).ravel()
        found = []
        for column in columns:
            across = column * x
            parts = (column, across, column * y, across * y)
            one, x_, y_, both = (np.bincount(flat, part.ravel(), count * size) for part in parts)
            sums = np.stack([one - x_ - y_ + both, x_ - both, y_ - both, both])
            found.append(sums.reshape(4, count, size).swapaxes(0, 1).reshape(count, -1))
        order, first = _corners_of_cells(n)
        return np.add.reduceat(np.stack(found).take(order, axis=2), first, axis=2).astype(np.float32)


@cache
def _corners_of_cells(n: int) -> tuple[Ints, Ints]:
    """All that `corner_cells` says, ordered by cells, and where each of the n * n cells begins in it."""
    cells = corner_cells(n).ravel()
    order = np.argsort(cells, kind="stable")
    return order, np.searchsorted(cells[order], np.arange(n * n))


@dataclass(frozen=True, eq=False)
class BucketGrid:
    """Which texels of a plan share a bucket, and which buckets are neighbours.

    `bucket` (K,): each texel's, -1 if it is in none of them; `order`: the texels that are in one, bucket by
    bucket, each of which begins at `first` (B + 1,). `place` (B,): flat indices in a grid of `size`, rows and
    columns.
    """

    plan: CapturePlan
    bucket: Ints
    order: Ints
    first: Ints
    place: Ints
    size: tuple[int, int]
    neighbours: Neighbours

    @classmethod
    def of(cls, plan: CapturePlan, coarser: float) -> BucketGrid:
        """Of buckets of `coarser` x `coarser` texels."""
        height, width = (side_in(side, coarser) for side in (plan.layout.height, plan.layout.width))
        j, i = np.divmod(plan.texel, plan.layout.width)
        row, column = ((place // coarser).astype(np.int64) for place in (j, i))
        place = np.minimum(row, height - 1) * width + np.minimum(column, width - 1)
        found, bucket = np.unique(place, return_inverse=True)
        bucket = bucket.ravel().astype(np.int32)
        order = np.argsort(bucket, kind="stable").astype(np.int32)
        first = np.searchsorted(bucket[order], np.arange(len(found) + 1))
        middle = np.add.reduceat(plan.points[order], first[:-1], axis=0) / np.diff(first)[:, None]
        points = middle.astype(np.float32)[:, None]
        coarse = CapturePlan(
            AtlasLayout(width, height, plan.layout.bucket), found, points, points, points, points, points
        )
        neighbours = (
            Neighbours(plan) if coarser == 1 else Neighbours(coarse, near=_near(plan.layout), wide=_WIDE)
        )
        return cls(plan, bucket, order, first, found, (height, width), neighbours)

    def __len__(self) -> int:
        return len(self.place)

    @cached_property
    def part(self) -> BucketGrid:
        """Some of the buckets, in patches, by which choices are judged; all of them if there are few."""
        row, column = np.divmod(self.place, self.size[1])
        patch = row // _PATCH * self.size[1] + column // _PATCH
        _, patch, count = np.unique(patch, return_inverse=True, return_counts=True)
        drawn = np.random.default_rng(_SEED).permutation(len(count))
        enough = np.searchsorted(np.cumsum(count[drawn]), max(len(self) // _PART, _LEAST_PART)) + 1
        if enough >= len(drawn):
            return self
        return self.of_some(np.isin(patch.ravel(), drawn[:enough]))

    def of_some(self, chosen: Bools) -> BucketGrid:
        """Those buckets that are `chosen` (B,)."""
        texels = chosen[self.bucket]
        first = np.concatenate([[0], np.cumsum(np.diff(self.first)[chosen])])
        return replace(
            self,
            bucket=np.where(texels, (np.cumsum(chosen) - 1)[self.bucket], -1).astype(np.int32),
            order=self.order[texels[self.order]],
            first=first,
            place=self.place[chosen],
            neighbours=self.neighbours.of(plan_of_some(self.neighbours.plan, chosen)),
        )

    def of_texels(self) -> BucketGrid:
        """The grid in which each of these texels has a bucket of its own."""
        grid, inside = BucketGrid.of(self.plan, 1), self.bucket >= 0
        return grid if inside.all() else grid.of_some(inside)

    def in_blocks(
        self, function: Callable[[Block], _Result], samples: int, at_once: int = SAMPLES_AT_ONCE
    ) -> list[_Result]:
        """Run the function on blocks of buckets, whose texels have `samples` each; its results in order."""
        step = max(1, at_once * len(self) // max(samples * len(self.order), 1))
        blocks = []
        for begin in range(0, len(self), step):
            buckets = slice(begin, min(begin + step, len(self)))
            texels = self.order[self.first[buckets.start] : self.first[buckets.stop]]
            blocks.append(Block(buckets, texels, self.bucket[texels] - begin))
        return side_by_side(function, blocks)

    def gather(self, table: Floats, place: Floats, some: Some) -> Floats:
        """Look some texels' samples up in a table: (C, k, S); `place` (2, k, S) as for `Block.scatter`."""
        n = round(table.shape[2] ** 0.5)
        corner, weights = corners(place, n)
        first = self.bucket[some].astype(np.intp)[:, None] * (n * n)
        return Taps(corner_cells(n).take(corner, axis=1) + first, weights, n).gather(table)

    def pool(
        self,
        table: Floats,
        pooled: Callable[[Floats], Floats],
        combine: Callable[[Floats, Floats], Floats],
    ) -> Floats:
        """Replace a table's sums by what `combine` makes of them, and of those that are `pooled`.

        Of a few cells of all buckets at a time, (C, B, m) both; it gives (D, B, m), D <= C. Returns the first
        D channels of the table, which is overwritten.
        """
        channels, buckets, cells = table.shape
        step = max(1, _POOLED_AT_ONCE // (4 * channels * max(buckets, 1)))
        kept = channels
        for begin in range(0, cells, step):
            own = np.ascontiguousarray(table[:, :, begin : begin + step])
            made = combine(own, pooled(own))
            kept = len(made)
            table[:kept, :, begin : begin + step] = made
        return table[:kept]

    def share(self, wide: bool) -> float:
        """The share of a sum's variance that is left after pooling."""
        near, far = self.neighbours.near, self.neighbours.wide
        taps = np.array(near.taps)
        if wide:
            apart = np.zeros((len(far.taps) - 1) * far.step + 1)
            apart[:: far.step] = far.taps
            taps = np.convolve(taps, apart)
        return float((taps**2).sum() ** 2)

    def means(self, block: Block, values: Floats) -> Floats:
        """The mean over each bucket's texels of values (C, k, m): (C, buckets, m)."""
        begin = self.first[block.buckets.start : block.buckets.stop]
        count = np.diff(self.first[block.buckets.start : block.buckets.stop + 1])
        sums = np.add.reduceat(values, begin - begin[0], axis=1)
        return (sums / count[:, None]).astype(np.float32)

    def placed(self, *tables: Floats) -> Floats:
        """Tables (C, B, n*n), channels after channels, as buckets (h, w, n, n, C), gutter filled."""
        n = round(tables[0].shape[2] ** 0.5)
        height, width = self.size
        image = large_arrays.zeros((height * width, n * n, sum(map(len, tables))))
        for number, channel in enumerate(channel for table in tables for channel in table):
            image[self.place, :, number] = channel
        covered = np.zeros(height * width, dtype=bool)
        covered[self.place] = True
        filled: Floats = dilate(
            image.reshape(height, width, n, n, -1), nearest_covered(covered.reshape(height, width))
        )
        return filled
