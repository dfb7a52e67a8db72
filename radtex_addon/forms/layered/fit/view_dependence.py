# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffuse light that changes with the viewer by more than the falloff: of skin, wax, jade.

Light that wanders below the surface comes from elsewhere for each viewer, as paths are refracted when they
enter. Nine spherical harmonics of the viewer's direction, up to the second band, tell it where they are worth
more than their noise. They are fitted to what texels show in the directions of a hemisphere.
"""

from __future__ import annotations

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.computed_rows import computed
from ....bake.light_samples import LightSamples, Some
from ....bake.pooling import Neighbours
from ....core import large_arrays
from ....core.arrays import Bools, Floats
from ....core.hemisphere import square_to_direction
from ....core.octahedron import cell_directions
from ..lookup.lobes import falloff_at
from .bucket_grid import Block, BucketGrid
from .own_light import Surface
from .rows import random_half

COUNT = 9
_TINY = 1e-9  # for buckets without samples
_RIDGE = 0.03  # as of the lightmap of spherical harmonics; with less, noise is told, too
_AT_ONCE = 1 << 16  # samples in hand, of nine numbers each
_SEED = 1


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

    found = large_arrays.concatenated(grid.in_blocks(equations, weight.shape[1], _AT_ONCE))
    sums = pooled(grid.neighbours, found)
    return np.concatenate(in_blocks(solve, len(grid), 1, _AT_ONCE))


def pooled(neighbours: Neighbours, values: Floats) -> Floats:
    """Values (K, C) of texels, each the weighted mean of its own and its neighbours': (K, C) float32."""
    channels = values.shape[1]
    table = large_arrays.empty((channels + 1, len(values), 1))
    table[:-1, :, 0], table[-1] = values.T, 1
    sums = neighbours.pool(table)[..., 0].T
    return large_arrays.from_blocks(len(values), lambda some: sums[some, :-1] / sums[some, -1:], _AT_ONCE)


def view_dependence(
    light: LightSamples, used: Bools, surface: Surface, onto: BucketGrid, cells: int
) -> Floats | None:
    """What diffuse samples have beyond the surface's diffuse light, in buckets `onto`: (3, B, cells * cells).

    By the mirror direction about the shading normals. `used` (K, S): which samples count. None where
    harmonics of half of the samples do not predict the other half, in a part of the buckets.
    """
    grid, shape = surface.grid, (*used.shape, 3)

    def towards(some: Some) -> Floats:
        return square_to_direction(light.square[some]).astype(np.float32)

    def left(some: Some) -> Floats:
        cosine = np.maximum(towards(some)[..., 2], 0)
        material = np.repeat(surface.material[some], cosine.shape[1])
        model = falloff_at(surface.falloff, material, cosine.ravel()).reshape(*cosine.shape, 3)
        rest: Floats = light.diffuse[some] - surface.diffuse[some][:, None] * model
        return rest

    direction, values = computed(shape, towards), computed(shape, left)
    half = random_half(used.shape, _SEED)
    found = fit_harmonics(direction, values, _shares(used, half), grid.part, _RIDGE)
    if _gain(direction, values, used, half, found, grid.part) <= 0:
        return None
    found = fit_harmonics(direction, values, _shares(used, None), grid, _RIDGE)
    return _by_mirror_direction(grid, found, surface.normal, onto, cells)


def _shares(used: Bools, half: Bools | None) -> Floats:
    """What the used samples count for, those of a half if there is one: (K, S), 1 for each texel."""

    def shares(some: Some) -> Floats:
        own = used[some] if half is None else used[some] & half[some]
        found: Floats = (own / np.maximum(own.sum(axis=1, keepdims=True), 1)).astype(np.float32)
        return found

    return computed(used.shape, shares)


def _gain(
    direction: Floats, values: Floats, used: Bools, half: Bools, found: Floats, grid: BucketGrid
) -> float:
    """By how much coefficients (B, 9, 3) lessen the squares of values (K, S, 3) that are not in `half`."""

    def gain(block: Block) -> float:
        some = block.texels
        told = np.einsum("ksa,kac->ksc", basis(direction[some]), found[grid.bucket[some]], optimize=True)
        less = told * (2 * values[some] - told)
        return float(less[used[some] & ~half[some]].sum(dtype=np.float64))

    return sum(grid.in_blocks(gain, used.shape[1], _AT_ONCE))


def _by_mirror_direction(
    grid: BucketGrid, found: Floats, normal: Floats, onto: BucketGrid, cells: int
) -> Floats:
    """Coefficients (B, 9, 3) of a grid's buckets, in cells of buckets of the same texels, `onto`."""
    plan, axis = grid.plan, cell_directions(cells).astype(np.float32)
    frame = [field.reshape(-1, 3)[: len(plan.texel)] for field in (plan.tangent, plan.bitangent, plan.normal)]

    by_cell: Floats = large_arrays.empty((3, len(onto), cells * cells))

    def look(block: Block) -> None:
        some = block.texels
        about = normal[some]
        viewer = 2 * (axis @ about.T).T[..., None] * about[:, None] - axis
        local = np.stack([np.einsum("kmc,kc->km", viewer, one[some]) for one in frame], axis=-1)
        local[..., 2] = np.maximum(local[..., 2], 0)
        local /= np.maximum(np.linalg.norm(local, axis=-1, keepdims=True), 1e-6)
        coefficients = found[grid.bucket[some]]
        told: Floats = np.einsum("kma,kac->ckm", basis(local), coefficients, optimize=True)
        by_cell[:, block.buckets] = onto.means(block, told)

    onto.in_blocks(look, len(axis))
    return by_cell
