# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction to bucket and back: the equisolid azimuthal projection and the disc-to-square map.

Fober, "Radiance Textures for Rasterizing Ray-Traced Data" (2023), section "Methodology". Vectors lie on the
last axis and are unit vectors; `incidence` points from the surface towards the viewer, in the surface frame
(T, Bt, N) unless a function says otherwise. float32 stays float32; results are NaN only for NaN inputs.

Components are computed one by one, and lie apart in memory where that is faster for the caller: NumPy is fast
only along a long axis.
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
