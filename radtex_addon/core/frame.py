# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface frame (T, Bt, N) at a fragment, computed in the same way by the bake and by every shader."""

from __future__ import annotations

import numpy as np

from .arrays import Floats, as_floats
from .errors import ShapeError

DEGENERATE = 1e-8  # T is degenerate if the squared sine of its angle to N is smaller


def _dot(a: Floats, b: Floats) -> Floats:
    product: Floats = np.sum(a * b, axis=-1, keepdims=True)
    return product


def normalised(v: Floats) -> Floats:
    """Unit vectors (..., 3); a zero vector stays zero."""
    length = np.sqrt(_dot(v, v))
    unit: Floats = np.divide(v, length, out=np.zeros_like(v), where=length != 0)
    return unit


def fallback_tangent(normal: Floats) -> Floats:
    """Unit vectors orthogonal to unit normals, (..., 3) both: normalize(cross(|N.z| < 0.9 ? z : x, N))."""
    normal = as_floats("normal", normal, 3)
    axis = np.where(np.abs(normal[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]).astype(normal.dtype)
    return normalised(np.cross(axis, normal))


def orthonormal_frame(normal: Floats, tangent: Floats, sign: Floats) -> tuple[Floats, Floats, Floats]:
    """(T, Bt, N) from interpolated normals and tangents (..., 3) and bitangent signs (...): (..., 3) each.

    Vectors may have any length. N and T are normalised, T is made orthogonal to N and normalised again,
    Bt = sign * cross(N, T); a degenerate T is replaced by `fallback_tangent`. Raises ShapeError if the signs
    do not fit the normals.
    """
    normal = normalised(as_floats("normal", normal, 3))
    tangent = normalised(as_floats("tangent", tangent, 3))
    sign = np.asarray(sign)
    if sign.shape != normal.shape[:-1]:
        raise ShapeError(f"sign: expected shape {normal.shape[:-1]}, got {sign.shape}")
    flat = tangent - normal * _dot(normal, tangent)
    degenerate = _dot(flat, flat) < DEGENERATE
    tangent = np.where(degenerate, fallback_tangent(normal), normalised(flat))
    bitangent = np.sign(sign)[..., None].astype(normal.dtype) * np.cross(normal, tangent)
    return tangent, bitangent, normal


def to_frame(vectors: Floats, tangent: Floats, bitangent: Floats, normal: Floats) -> Floats:
    """Components of vectors (..., 3) along T, Bt and N: (..., 3)."""
    return np.concatenate([_dot(vectors, tangent), _dot(vectors, bitangent), _dot(vectors, normal)], axis=-1)
