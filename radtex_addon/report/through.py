# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Look baked surfaces up along rays, those behind clear parts of others, too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.arrays import Ints
from ..core.surface import ray_offset
from .finished_bake import Finished
from .gbuffer import Array, BakedSurface, CameraRays

_LAYERS = 6  # surfaces before each other
_LEFT = 0.01  # of the light from behind: less is nothing


@dataclass(frozen=True, eq=False)
class Shown:
    """A surface, and the bake of it."""

    surface: BakedSurface
    bake: Finished


@dataclass(frozen=True, eq=False)
class Along:
    """The `light` (N, 3) along rays, and what each meets first: the number of a surface, and its `triangle`.

    `first` (N,) is -1 where it meets none, and where a clear part shows what is behind all surfaces, which no
    bake knows.
    """

    light: Array
    first: Ints
    triangle: Ints


def light_along(shown: Sequence[Shown], rays: CameraRays, blocked: Array | None = None) -> Along:
    """The light that surfaces show along rays, which meet the first of them before `blocked` (N,) distances.

    What is behind clear parts counts as not blocked.
    """
    count = len(rays.away)
    light, left = np.zeros((count, 3)), np.ones(count)
    first, triangle = np.full(count, -1), np.zeros(count, dtype=np.int64)
    start = np.broadcast_to(rays.origin, rays.away.shape).copy()
    some = np.arange(count)
    step = max(ray_offset(one.surface.place) for one in shown)
    most = np.full(count, np.inf) if blocked is None else blocked
    for layer in range(_LAYERS):
        found = _nearest(shown, replace(rays, origin=start[some], away=rays.away[some]), most)
        light[some] += left[some, None] * found.light
        if layer == 0:
            first[some], triangle[some] = found.number, found.triangle
        else:
            first[some[(found.number < 0) & (left[some] > _LEFT)]] = -1
        left[some] *= 1 - found.alpha
        going = (found.number >= 0) & (left[some] > _LEFT)
        some, near = some[going], found.distance[going]
        if not len(some):
            break
        start[some] += rays.away[some] * (near + step)[:, None]
        most = np.full(len(some), np.inf)
    return Along(light, first, triangle)


@dataclass(frozen=True, eq=False)
class _Met:
    """What rays meet first: its distance, its number, -1 for nothing, triangle, light (N, 3) and alpha."""

    distance: Array
    number: Ints
    triangle: Ints
    light: Array
    alpha: Array


def _nearest(shown: Sequence[Shown], rays: CameraRays, most: Array) -> _Met:
    count = len(rays.away)
    near, met, triangle = most.copy(), np.full(count, -1), np.zeros(count, dtype=np.int64)
    light, alpha = np.zeros((count, 3)), np.zeros(count)
    for number, one in enumerate(shown):
        buffer = one.surface.gbuffer(rays, near)
        hit = buffer.hit
        if hit.any():
            light[hit] = one.bake.radiance(buffer)[hit]
            alpha[hit] = 1.0
            if one.bake.alpha is not None:
                drawn = ~one.surface.culled(buffer.triangle[hit], rays.away[hit])
                alpha[hit] = drawn * one.bake.alpha(buffer.uv[hit])
                light[hit] *= drawn[:, None]
            near[hit] = np.linalg.norm(buffer.position[hit] - rays.origin[hit], axis=1)
            met[hit], triangle[hit] = number, buffer.triangle[hit]
    return _Met(near, met, triangle, light, alpha)
