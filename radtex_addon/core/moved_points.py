# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a surface, moved by a step in its UV map."""

from __future__ import annotations

import numpy as np

from . import large_arrays
from .arrays import Floats, Ints
from .surface import SurfaceMesh

_AT_ONCE = 1 << 18  # points


def moved_points(surface: SurfaceMesh, triangle: Ints, point: Floats, step: tuple[float, float]) -> Floats:
    """Points (K, 3) of triangles (K,) moved by a `step` in UV, but no further than their triangle reaches.

    Those of triangles without area, on the surface or in UV, stay. float32.
    """
    moved = large_arrays.empty((len(point), 3))
    for first in range(0, len(point), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        moved[some] = _moved(surface, triangle[some], point[some], step)
    return moved


def _moved(surface: SurfaceMesh, triangle: Ints, point: Floats, step: tuple[float, float]) -> Floats:
    corner = surface.position[surface.triangles[triangle]].astype(np.float64)
    uv = surface.uv[triangle].astype(np.float64)
    along, across = corner[:, 1:] - corner[:, :1], uv[:, 1:] - uv[:, :1]
    metric = along @ np.swapaxes(along, 1, 2)
    usable = (np.linalg.det(metric) > 0) & (np.abs(np.linalg.det(across)) > 0)
    metric[~usable] = across[~usable] = np.eye(2)
    place = np.linalg.solve(metric, along @ (point - corner[:, 0])[..., None])[..., 0]
    place += np.linalg.solve(np.swapaxes(across, 1, 2), np.broadcast_to(step, place.shape)[..., None])[..., 0]
    weight = np.maximum(np.concatenate([1 - place.sum(axis=1, keepdims=True), place], axis=1), 0)
    moved = ((weight / weight.sum(axis=1, keepdims=True))[..., None] * corner).sum(axis=1)
    return np.where(usable[:, None], moved, point)
