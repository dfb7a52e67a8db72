# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an engine does with alpha: fragments of one ray, one behind another, over what it has drawn before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radtex_addon.core.surface import ray_offset
from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays, GBuffer
from radtex_addon.report.metrics import Picture

from .method import Baked

LAYERS = 16  # of the mesh, one behind another, that are drawn at most
_HIDDEN = 1 / 512  # of the light from behind: what eight bits round to nothing


def seen_light(
    baked: Baked,
    surface: BakedSurface,
    rays: CameraRays,
    blocked: Array,
    first: GBuffer,
    behind: Picture | None = None,
) -> Array:
    """Radiance (N, 3) along rays that meet the baked surface `first` in that G-buffer; anything elsewhere.

    Where the baked object's alpha leaves something of it, what lies behind shows too, to the distances
    `blocked` (N,): the surface again, up to LAYERS times, and behind that the picture `behind` (pixels,
    pixels, 3), black if None.
    """
    if baked.alpha is None:
        return baked.radiance(first)
    light, left = np.zeros((len(first.hit), 3)), np.ones(len(first.hit))
    origin = np.broadcast_to(rays.origin, rays.away.shape)
    offset = ray_offset(surface.place)
    some, buffer = np.arange(len(left)), first
    for layer in range(LAYERS):
        if layer:
            travelled = ((buffer.position - origin[some]) * rays.away[some]).sum(axis=1) + offset
            going = buffer.hit & (left[some] > _HIDDEN)
            some, travelled = some[going], travelled[going]
            start = origin[some] + rays.away[some] * travelled[:, None]
            onward = replace(rays, origin=start, away=rays.away[some])
            buffer = surface.gbuffer(onward, blocked[some] - travelled)
        if not buffer.hit.any():
            break
        hit = some[buffer.hit]
        light[hit] += left[hit, None] * baked.radiance(buffer)[buffer.hit]
        left[hit] *= 1 - np.clip(baked.alpha(buffer)[buffer.hit], 0, 1)
    if behind is not None:
        light += left[:, None] * np.repeat(behind.reshape(-1, 3), rays.subsamples**2, axis=0)
    return light
