# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep points away from the edges of their triangles.

Whether a ray aimed exactly at an edge hits depends on rounding. Inside a mesh the neighbouring triangle
catches the ray, but along the border of an open mesh (a card, a leaf, a floor) it would see what lies behind.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import large_arrays
from .arrays import Floats
from .surface import SurfaceMesh
from .texel_map import TexelMap

_CHUNK = 1 << 18  # texels processed at once


def inset(texels: TexelMap, surface: SurfaceMesh, distance: float | Floats) -> TexelMap:
    """The texel map of `surface` with each position at least `distance` away from its triangle's edges.

    `distance` is in world units, a scalar or one for each triangle, (F,). Points that are far enough away,
    and those of triangles without area, are not changed at all; in a triangle too small for the distance the
    point moves towards the middle. Frames stay as they are.
    """
    covered = np.flatnonzero(texels.covered)
    distances = np.broadcast_to(np.asarray(distance, dtype=np.float64), (len(surface.triangles),))
    position = large_arrays.copied(texels.position)
    points, triangle = position.reshape(-1, 3), texels.triangle.ravel()
    for start in range(0, len(covered), _CHUNK):
        texel = covered[start : start + _CHUNK]
        corner = surface.position[surface.triangles[triangle[texel]]].astype(np.float64)
        weight, least = _weights(points[texel].astype(np.float64), corner, distances[triangle[texel]])
        near = np.flatnonzero((weight < least).any(axis=1))
        points[texel[near]] = np.einsum("kc,kcx->kx", _at_least(weight[near], least[near]), corner[near])
    return replace(texels, position=position)


def _weights(point: Floats, corner: Floats, distance: Floats) -> tuple[Floats, Floats]:
    """Barycentric weights (K, 3) of points (K, 3) in triangles (K, 3, 3), and the least allowed weights.

    A corner's weight is the point's distance from the opposite edge, divided by the corner's distance from
    that edge (its altitude). So the least weight is `distance` over the altitude.
    """
    ahead, behind = np.roll(corner, -1, axis=1), np.roll(corner, -2, axis=1)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, None]
    squared = np.sum(normal * normal, axis=-1)
    part = np.sum(np.cross(ahead - point[:, None], behind - point[:, None]) * normal, axis=-1)
    weight = np.divide(part, squared, out=np.full(part.shape, 1 / 3), where=squared > 0)
    edge = np.sqrt(np.sum((behind - ahead) ** 2, axis=-1))
    altitude = np.divide(np.sqrt(squared), edge, out=np.zeros_like(edge), where=edge > 0)
    most = np.full(altitude.shape, 1 / 3)
    least = distance[:, None]
    return weight, np.divide(least, altitude, out=most, where=3 * least < altitude)


def _at_least(weight: Floats, least: Floats) -> Floats:
    """Raise weights (K, 3) below `least` to it, and lower the others so that they sum to 1 again."""
    above = np.maximum(weight - least, 0)
    total, left = above.sum(axis=1, keepdims=True), 1 - least.sum(axis=1, keepdims=True)
    raised: Floats = least + above * np.divide(left, total, out=np.zeros_like(left), where=total > 0)
    return raised
