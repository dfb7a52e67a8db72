# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays first meet triangles, by asking each ray and triangle: what trees of triangles are held to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.surface import SurfaceMesh

COUNT = 10_000
_FACES = 300
_FACING = 1e-12


@dataclass(frozen=True, eq=False)
class Traced:
    """Of N rays: `far` (N,), infinite where there is nothing; `triangle` (N,); `weight` (N, 3).

    `clear` (N,): the ray passes no edge so closely that 32-bit floats may see another triangle.
    """

    far: Floats
    triangle: Ints
    weight: Floats
    clear: npt.NDArray[np.bool_]

    def between(self, values: Floats) -> Floats:
        """Corners' values (F, 3, C) where the rays hit: (N, C)."""
        found: Floats = np.einsum("nk,nkc->nc", self.weight, values[self.triangle])
        return found


def trace(corners: Floats, origin: Floats, ray: Floats, culled: bool) -> Traced:
    """The nearest hits of rays (N, 3) with triangles (F, 3, 3), on their fronts alone if `culled`."""
    far = np.full(len(ray), np.inf)
    triangle = np.zeros(len(ray), dtype=np.int64)
    weight, clear = np.zeros((len(ray), 3)), np.ones(len(ray), dtype=bool)
    for number, (a, b, c) in enumerate(corners.astype(np.float64)):
        across = np.cross(ray, c - a)
        size = across @ (b - a)
        facing = size > _FACING if culled else np.abs(size) > _FACING
        safe = np.where(facing, size, 1.0)
        towards = origin - a
        turned = np.cross(towards, b - a)
        u, v = np.sum(towards * across, axis=1) / safe, np.sum(ray * turned, axis=1) / safe
        along = turned @ (c - a) / safe
        least = np.minimum(np.minimum(u, v), 1 - u - v)
        clear &= ~facing | (along < 0) | (np.abs(least) > 1e-3) | (along > far + 1e-3)
        hit = facing & (least >= 0) & (along > 0) & (along < far)
        far[hit], triangle[hit] = along[hit], number
        weight[hit] = np.column_stack([1 - u - v, u, v])[hit]
    return Traced(far, triangle, weight, clear)


def random_surface(seed: int = 3) -> SurfaceMesh:
    """Small triangles in a cube of side 2, some of them twice the same or without area, of five materials."""
    random = np.random.default_rng(seed)
    corners = random.uniform(-1, 1, (_FACES, 1, 3)) + random.normal(0, 0.25, (_FACES, 3, 3))
    corners[10:14, 2] = corners[10:14, 1]
    corners = np.concatenate([corners, corners[20:30]])
    faces = len(corners)
    return SurfaceMesh(
        position=corners.reshape(-1, 3).astype(np.float32),
        triangles=np.arange(3 * faces).reshape(-1, 3),
        normal=random.normal(0, 1, (faces, 3, 3)),
        tangent=random.normal(0, 1, (faces, 3, 3)),
        sign=np.repeat(random.choice([-1.0, 1.0], (faces, 1)), 3, axis=1),
        uv=random.uniform(0, 1, (faces, 3, 2)),
        material=random.integers(0, 5, faces),
    )


def random_rays(seed: int = 4) -> tuple[Floats, Floats]:
    """Origins and unit directions, (COUNT, 3) each; some run along an axis."""
    random = np.random.default_rng(seed)
    origin = random.uniform(-1.5, 1.5, (COUNT, 3))
    ray = random.normal(0, 1, (COUNT, 3))
    ray[:300] = np.eye(3)[random.integers(0, 3, 300)] * random.choice([-1, 1], (300, 1))
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    return origin.astype(np.float32), ray.astype(np.float32)
