# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion and the bent normal, from a grid of cells of equal cosine-weighted solid angle.

Buckets are too coarse for this: at the horizon the cosine varies so much within a cell that a low wall would
count half as much again as it should. So rays for ambient occlusion use another grid: the square mapped to
the disc by Shirley and Chiu, "A Low Distortion Map Between Disk and Square" (1997), which preserves area, and
the disc projected up to the hemisphere (Malley's method), which turns area into the cosine times solid angle.
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats, as_floats
from .errors import ShapeError
from .hemisphere import cell_centres


def square_to_cosine(b: Floats) -> Floats:
    """Directions in the frame for points of the square: B (..., 2) in [-1, 1]^2 -> I (..., 3), unit.

    Equal areas of the square have equal cosine-weighted solid angles: a cell of n x n has pi / n^2 sr.
    """
    b = as_floats("B", b, 2)
    size = np.abs(b)
    radius = size.max(axis=-1)
    ratio = np.divide(size.min(axis=-1), radius, out=np.zeros_like(radius), where=radius > 0)
    near = ratio * b.dtype.type(np.pi / 4)  # the angle from the nearer axis
    along, across = radius * np.cos(near), radius * np.sin(near)
    wide = size[..., 0] >= size[..., 1]
    x, y = np.where(wide, along, across), np.where(wide, across, along)
    up = np.sqrt(np.maximum(1 - radius * radius, 0))
    return np.stack([np.copysign(x, b[..., 0]), np.copysign(y, b[..., 1]), up], axis=-1)


def occlusion(visibility: Floats) -> tuple[Floats, Floats]:
    """The bent normal (..., 3) and the ambient visibility (...), 0 to 1, of grids (..., n, n), [q, p].

    A cell's `visibility` is the share of its directions by `square_to_cosine` that nothing blocks. The
    ambient visibility is its cosine-weighted mean over the hemisphere: 1 in the open. The bent normal is the
    mean visible direction with the same weights, taken at cell centres: a unit vector in the frame (T, Bt,
    N); where nothing is visible it is the normal, (0, 0, 1). Float64. Raises ShapeError for other shapes.
    """
    if visibility.ndim < 2 or visibility.shape[-1] != visibility.shape[-2]:
        raise ShapeError(f"visibility: expected shape (..., n, n), got {visibility.shape}")
    ambient = visibility.mean(axis=(-2, -1), dtype=np.float64)
    centres = square_to_cosine(cell_centres(visibility.shape[-1]))
    total = np.einsum("...qp,qpx->...x", visibility, centres)
    length = np.linalg.norm(total, axis=-1, keepdims=True)
    upright = np.broadcast_to([0.0, 0.0, 1.0], total.shape)
    bent: Floats = np.where(length > 1e-6, total / np.maximum(length, 1e-6), upright)
    return bent, ambient
