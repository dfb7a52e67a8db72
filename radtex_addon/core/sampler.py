# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference sampler: the radiance that every shader must return for a uv and an incidence vector."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum

import numpy as np

from .arrays import Floats, Ints, as_floats
from .atlas import AtlasLayout
from .errors import ShapeError
from .hemisphere import bleed_guard, direction_to_square


def bilinear(image: Floats, uv: Floats) -> Floats:
    """Bilinear lookup in an image (H, W, C) at uv (K, 2), clamped at the edges: (K, C) float32."""
    height, width = image.shape[:2]
    flat = image.reshape(height * width, -1)
    total = np.zeros((len(uv), flat.shape[1]), dtype=np.float32)
    for texel, weight in bilinear_texels(uv, width, height):
        total += weight[:, None] * flat[texel]
    return total


def bilinear_texels(uv: Floats, width: int, height: int) -> Iterator[tuple[Ints, Floats]]:
    """Yield the four texels around uv (K, 2), as flat indices clamped at the edge, and their weights."""
    position = uv * np.array([width, height], dtype=uv.dtype) - uv.dtype.type(0.5)
    corner = np.floor(position)
    fraction = position - corner
    for dy in (0, 1):
        for dx in (0, 1):
            i = np.clip(corner[:, 0].astype(np.int32) + dx, 0, width - 1)
            j = np.clip(corner[:, 1].astype(np.int32) + dy, 0, height - 1)
            yield j * width + i, np.prod(np.where(np.array([dx, dy]) == 1, fraction, 1 - fraction), axis=1)


class Filter(StrEnum):
    """How many cells a lookup blends."""

    NEAREST = "nearest"  # the paper's one lookup, at the nearest cell
    LINEAR = "linear"  # one lookup, bilinear inside the bucket
    QUADRILINEAR = "quadrilinear"  # four texels, each bilinear inside its bucket


def sample(image: Floats, layout: AtlasLayout, uv: Floats, incidence: Floats, kind: Filter) -> Floats:
    """Radiance at texture coordinates, seen from the given directions.

    `image` (H*n, W*n, C), row 0 at the bottom; `uv` (K, 2), clamped to the atlas's edge; `incidence` (K, 3)
    unit vectors in the frame. Returns (K, C) in the image's unit, float32 or float64 as `uv` is. A NaN in
    `uv` or `incidence` gives NaN for that lookup. Raises ShapeError for shapes that do not fit.
    """
    uv, incidence = checked_lookups(uv, incidence)
    buckets, texels = layout.to_buckets(image), np.array([layout.width, layout.height], dtype=uv.dtype)
    known = np.isfinite(uv).all(axis=1) & np.isfinite(incidence).all(axis=1)
    result = np.full((len(uv), image.shape[2]), np.nan, dtype=uv.dtype)
    b = direction_to_square(incidence[known])
    result[known] = blend_buckets(buckets, uv[known] * texels, b, texels, kind)
    return result


def checked_lookups(uv: Floats, incidence: Floats) -> tuple[Floats, Floats]:
    """`uv` (K, 2) and `incidence` (K, 3) as float arrays. Raises ShapeError for other shapes."""
    uv, incidence = as_floats("uv", uv, 2), as_floats("incidence", incidence, 3)
    if uv.ndim != 2 or incidence.shape != (len(uv), 3):
        raise ShapeError(
            f"uv and incidence: expected (K, 2) and (K, 3), got {uv.shape} and {incidence.shape}"
        )
    return uv, incidence


def blend_buckets(buckets: Floats, position: Floats, b: Floats, texels: Floats, kind: Filter) -> Floats:
    """Look up `buckets` (H, W, n, n, C), [j, i, q, p], at positions in texels and in buckets: (K, C).

    `position` (K, 2), x first: texel (i, j) has its centre at (i + 0.5, j + 0.5). `b` (K, 2) is B.
    Lookups are clamped to the first `texels` (2,), x first, where the atlas's edge is; the rest is padding.
    """
    n = buckets.shape[2]
    total = np.zeros((len(position), buckets.shape[4]), dtype=position.dtype)
    for texel, texel_weight in _texels(position, texels, blend=kind is Filter.QUADRILINEAR):
        for cell, cell_weight in _cells(b, n, blend=kind is not Filter.NEAREST):
            value = buckets[texel[:, 1], texel[:, 0], cell[:, 1], cell[:, 0]]
            total += (texel_weight * cell_weight)[:, None] * value
    return total


def _texels(position: Floats, size: Floats, blend: bool) -> Iterator[tuple[Ints, Floats]]:
    """The texel that contains each position (in texels), or the four around it, with their weights."""
    if blend:
        yield from four_texels(position, size)
        return
    inside = np.clip(np.floor(position), 0, size - 1)
    yield inside.astype(np.intp), np.ones(len(position), dtype=position.dtype)


def four_texels(position: Floats, size: Floats) -> Iterator[tuple[Ints, Floats]]:
    """The four texels (K, 2) around each position (K, 2), in texels, x first, and their weights (K,)."""
    yield from _bilinear(position - 0.5, size - 1)


def _cells(b: Floats, n: int, blend: bool) -> Iterator[tuple[Ints, Floats]]:
    """The cell that contains each B, or the four around it within the bucket, with their weights."""
    if blend:
        yield from four_cells(b, n)
        return
    cell = np.clip(np.floor((b + 1) / 2 * n), 0, n - 1)
    yield cell.astype(np.intp), np.ones(len(b), dtype=b.dtype)


def four_cells(b: Floats, n: int) -> Iterator[tuple[Ints, Floats]]:
    """The four cells (K, 2) of n x n around each B (K, 2), p first, and their weights (K,)."""
    position = (bleed_guard(b, n) + 1) / 2 * n - 0.5
    yield from _bilinear(position, np.full(2, n - 1, dtype=b.dtype))


def _bilinear(position: Floats, last: Floats) -> Iterator[tuple[Ints, Floats]]:
    """Four neighbours of each position (index centres at whole numbers), clamped to [0, last]."""
    corner = np.floor(position)
    fraction = position - corner
    for dy in (0, 1):
        for dx in (0, 1):
            step = np.array([dx, dy])
            weight = np.prod(np.where(step == 1, fraction, 1 - fraction), axis=1)
            yield np.clip(corner + step, 0, last).astype(np.intp), weight
