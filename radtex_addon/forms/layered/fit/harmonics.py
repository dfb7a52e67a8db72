# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Spherical harmonics up to the second band, fitted to what texels show in the directions of a hemisphere."""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.pooling import Neighbours
from ....core.arrays import Floats
from .bucket_grid import Block, BucketGrid

COUNT = 9
_TINY = 1e-9  # for buckets without samples
_AT_ONCE = 1 << 13  # samples in hand, of nine numbers each


def basis(direction: Floats) -> Floats:
    """The nine real spherical harmonics of unit directions (..., 3): (..., 9).

    Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps" (2001).
    """
    x, y, z = np.moveaxis(direction, -1, 0)
    columns = [
        np.full_like(x, 0.282095),
        0.488603 * y,
        0.488603 * z,
        0.488603 * x,
        1.092548 * x * y,
        1.092548 * y * z,
        0.315392 * (3 * z * z - 1),
        1.092548 * x * z,
        0.546274 * (x * x - y * y),
    ]
    return np.stack(columns, axis=-1)


def fit_harmonics(
    direction: Floats, values: Floats, weight: Floats, grid: BucketGrid, ridge: float
) -> Floats:
    """Coefficients (B, 9, 3) of samples (K, S, 3) in directions (K, S, 3), by least squares.

    `weight` (K, S) sums to 1 for each of the K texels. Equations are means over the texels of each of the
    `grid`'s buckets, pooled with their neighbours'. On a hemisphere the nine are all but dependent, and cut
    off after them a highlight rings: each coefficient but the first costs `ridge` times its square, beside a
    mean square error.
    """

    def equations(block: Block) -> Floats:
        some = block.texels
        columns = basis(direction[some])
        weighted = columns * weight[some][..., None]
        against = np.einsum("ksa,ksb->kab", weighted, columns, optimize=True)
        towards = np.einsum("ksa,csk->kac", weighted, planes(values[some]).swapaxes(1, 2), optimize=True)
        both = np.concatenate([against, towards], axis=2)
        means: Floats = grid.means(block, both.reshape(1, len(some), -1))[0]
        return means

    penalty = np.diag([_TINY] + [ridge] * (COUNT - 1))

    def solve(some: slice) -> Floats:
        table = sums[some].reshape(-1, COUNT, COUNT + 3).astype(np.float64)
        found: Floats = np.linalg.solve(table[..., :COUNT] + penalty, table[..., COUNT:])
        return found.astype(np.float32)

    sums = pooled(grid.neighbours, np.concatenate(grid.in_blocks(equations, weight.shape[1], _AT_ONCE)))
    return np.concatenate(in_blocks(solve, len(grid), 1, _AT_ONCE))


def pooled(neighbours: Neighbours, values: Floats) -> Floats:
    """Values (K, C) of texels, each the weighted mean of its own and its neighbours': (K, C) float32."""
    table = np.concatenate([values, np.ones((len(values), 1))], axis=1).astype(np.float32)
    sums = neighbours.pool(np.ascontiguousarray(table.T[..., None]))[..., 0].T
    found: Floats = sums[:, :-1] / sums[:, -1:]
    return found
