# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans of a unit sphere and of a floor, whose texels are known."""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.plan import CapturePlan, plan_capture
from radtex_addon.core.arrays import Floats
from radtex_addon.core.texel_map import TexelMap

HEIGHT, WIDTH = 16, 32
CELLS = 8


def sphere() -> CapturePlan:
    """A unit sphere, one column of gutter at either side."""
    normal = normals(centres()).astype(np.float32)
    tangent = tangents(centres()).astype(np.float32)
    triangle = np.zeros((HEIGHT, WIDTH), dtype=np.int32)
    triangle[:, [0, -1]] = -1
    ones = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    return plan_capture(TexelMap(normal, normal, tangent, ones, normal, triangle, triangle >= 0), CELLS)


def floor() -> CapturePlan:
    """The square [-1, 1]^2 at z = 0, whose texels all look up."""
    position = np.concatenate([centres() * 2 - 1, np.zeros((HEIGHT, WIDTH, 1))], axis=-1).astype(np.float32)
    normal, tangent = (np.broadcast_to(np.eye(3, dtype=np.float32)[k], position.shape) for k in (2, 0))
    ones = np.ones((HEIGHT, WIDTH), dtype=np.float32)
    triangle = np.zeros((HEIGHT, WIDTH), dtype=np.int32)
    return plan_capture(TexelMap(position, normal, tangent, ones, normal, triangle, triangle >= 0), CELLS)


def normals(uv: Floats) -> Floats:
    """Those of the unit sphere, +z at v = 1: (..., 2) -> (..., 3). They are its positions, too."""
    azimuth, polar = 2 * np.pi * uv[..., 0], np.pi * (1 - uv[..., 1])
    across = np.sin(polar)
    normal: Floats = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(polar)], axis=-1)
    return normal


def tangents(uv: Floats) -> Floats:
    azimuth = 2 * np.pi * uv[..., 0]
    return np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth], axis=-1)


def centres() -> Floats:
    i, j = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    return np.stack([(i + 0.5) / WIDTH, (j + 0.5) / HEIGHT], axis=-1)
