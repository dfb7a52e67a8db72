# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction to bucket and back: the equisolid azimuthal projection and the disc-to-square map.

Fober, "Radiance Textures for Rasterizing Ray-Traced Data" (2023), section "Methodology". Vectors lie on the
last axis and are unit vectors; `incidence` points from the surface towards the viewer, in the surface frame
(T, Bt, N) unless a function says otherwise. float32 stays float32; results are NaN only for NaN inputs.

Components are computed one by one, and lie apart in memory where that is faster for the caller: NumPy is fast
only along a long axis.

The solid angles of cells have a closed form. The projection preserves area: a solid angle is twice its area
on the disc. The map to the square does not: where |B.x| >= |B.y| it has the Jacobian x^2 / (x^2 + y^2), whose
integral over a rectangle is elementary.

Buckets are too coarse for ambient occlusion and the bent normal: at the horizon the cosine varies so much
within a cell that a low wall would count half as much again as it should. So their rays use a grid of cells
of equal cosine-weighted solid angle: the square mapped to
the disc by Shirley and Chiu, "A Low Distortion Map Between Disk and Square" (1997), which preserves area, and
the disc projected up to the hemisphere (Malley's method), which turns area into the cosine times solid angle.
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats, as_floats
from .errors import ShapeError

_TINY = 1e-30  # avoids 0/0; too small to change the result for a unit vector


def _length(v: Floats) -> Floats:
    """Length of 2-vectors, shape (..., 1), without underflow: |B| = 1e-30 does not become 0."""
    length: Floats = np.hypot(v[..., 0], v[..., 1])[..., None]
    return length


def _max_norm(v: Floats) -> Floats:
    norm: Floats = np.maximum(np.abs(v[..., 0]), np.abs(v[..., 1]))[..., None]
    return norm


def equisolid(incidence: Floats) -> Floats:
    """Project directions in the frame onto the unit disc, equal area: (..., 3) -> A (..., 2).

    A = sqrt(2) I.xy / |I + (0,0,1)|, which for a unit I is I.xy / sqrt(1 + I.z); |A| = sqrt(2) sin(theta/2).
    Directions below the horizon are clamped to the rim at their azimuth; I = -N has no azimuth: A = 0.
    """
    incidence = as_floats("incidence", incidence, 3)
    a = incidence[..., :2] / np.sqrt(np.maximum(1 + incidence[..., 2:], _TINY))
    clamped: Floats = a / np.maximum(_length(a), 1)
    return clamped


def equisolid_inverse(a: Floats) -> Floats:
    """Direction in the frame for a point of the unit disc: A (..., 2) -> I (..., 3).

    I = (A.x q, A.y q, 1 - |A|^2), q = sqrt(2 - |A|^2). Outside the disc (|A| > 1) the direction lies below
    the horizon; for |A| > sqrt(2) there is no direction, and q is clamped to 0.
    """
    a = as_floats("A", a, 2)
    x, y = a[..., 0], a[..., 1]
    r2 = x * x + y * y
    q = np.sqrt(np.maximum(2 - r2, 0))
    return np.moveaxis(np.stack([x * q, y * q, 1 - r2]), 0, -1)


def disc_to_square(a: Floats) -> Floats:
    """Stretch the unit disc radially onto the square [-1, 1]^2: B = A |A| / max(|A.x|, |A.y|), or 0 at 0."""
    a = as_floats("A", a, 2)
    widest = _max_norm(a)
    ratio = np.divide(_length(a), widest, out=np.ones_like(widest), where=widest != 0)
    b: Floats = a * ratio
    return b


def square_to_disc(b: Floats) -> Floats:
    """Shrink the square back onto the disc: A = B max(|B.x|, |B.y|) / |B|, A = 0 at B = 0."""
    b = as_floats("B", b, 2)
    x, y = b[..., 0], b[..., 1]
    length = _length(b)[..., 0]
    ratio = _max_norm(b)[..., 0] / np.maximum(length, np.finfo(length.dtype).tiny)
    return np.moveaxis(np.stack([x * ratio, y * ratio]), 0, -1)


def direction_to_square(incidence: Floats) -> Floats:
    """Bucket coordinates of directions in the frame: I (..., 3) -> B (..., 2) in [-1, 1]^2."""
    return np.clip(disc_to_square(equisolid(incidence)), -1, 1)


def square_to_direction(b: Floats) -> Floats:
    """Directions in the frame for bucket coordinates: B (..., 2) -> I (..., 3)."""
    return equisolid_inverse(square_to_disc(b))


def mirror_direction(incidence: Floats) -> Floats:
    """Mirror direction of I in the frame: R = (-I.x, -I.y, I.z), both (..., 3)."""
    incidence = as_floats("incidence", incidence, 3)
    mirrored: Floats = incidence * np.array([-1, -1, 1], dtype=incidence.dtype)
    return mirrored


def bleed_guard(b: Floats, bucket: int) -> Floats:
    """Keep bilinear lookups inside their bucket: B clamped to [1/n - 1, 1 - 1/n] on both axes."""
    if bucket < 1:
        raise ShapeError(f"bucket: expected at least 1 cell a side, got {bucket}")
    limit = 1 - 1 / bucket
    return np.clip(as_floats("B", b, 2), -limit, limit)


def cell_centres(bucket: int) -> Floats:
    """B of a bucket's cell centres: (n, n, 2) float64, indexed [q, p] (rows along Bt, columns along T)."""
    if bucket < 1:
        raise ShapeError(f"bucket: expected at least 1 cell a side, got {bucket}")
    centres = (2 * np.arange(bucket) + 1 - bucket) / bucket
    return np.stack(np.meshgrid(centres, centres), axis=-1)


def cell_solid_angles_sr(bucket: int) -> Floats:
    """Solid angle of each cell: (n, n) float64, steradians, indexed [q, p]; they sum to 2 pi."""
    if bucket < 1:
        raise ShapeError(f"bucket: expected at least 1 cell a side, got {bucket}")
    edges = (2 * np.arange(bucket + 1) - bucket) / bucket  # exactly symmetric
    index = np.arange(bucket)
    near = np.minimum(np.abs(edges[:-1]), np.abs(edges[1:]))  # a cell's edge towards the centre …
    far = np.maximum(np.abs(edges[:-1]), np.abs(edges[1:]))  # … and away from it
    column, row = np.meshgrid(index, index)
    major = np.maximum(far[column], far[row])
    wide = np.where(far[column] >= far[row], column, row)  # the axis along which the cell lies further out
    narrow = np.where(far[column] >= far[row], row, column)
    area = _rectangle_area(near[wide], far[wide], edges[narrow], edges[narrow + 1])
    diagonal = far[column] == far[row]
    area[diagonal] = _diagonal_area(near[column], far[column])[diagonal]
    centre = bucket // 2
    if bucket % 2:  # the middle cell is a small disc
        area[centre, centre] = np.pi * major[centre, centre] ** 2
    return 2 * area


def _primitive(x: Floats, y: Floats) -> Floats:
    """F with dF/dx = x atan(y / x): the Jacobian integrated over y from 0."""
    value: Floats = (x * x * np.arctan2(y, x) + y * x - y * y * np.arctan2(x, y)) / 2
    return value


def _rectangle_area(x0: Floats, x1: Floats, y0: Floats, y1: Floats) -> Floats:
    """Disc area of the cell [x0, x1] x [y0, y1] within 0 <= |y| <= x."""

    def strip(y: Floats) -> Floats:
        magnitude = np.abs(y)
        area: Floats = np.sign(y) * (_primitive(x1, magnitude) - _primitive(x0, magnitude))
        return area

    return strip(y1) - strip(y0)


def _diagonal_area(near: Floats, far: Floats) -> Floats:
    """Disc area of the cell [near, far]^2: twice its triangle below the diagonal."""
    below: Floats = np.pi / 8 * (far**2 - near**2) - (_primitive(far, near) - _primitive(near, near))
    area: Floats = 2 * below
    return area


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
