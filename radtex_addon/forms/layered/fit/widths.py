# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Roughness that varies within a material: by how much a texel's lobes are wider than their material's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....bake.pooling import Neighbours
from ....core.arrays import Floats
from ....core.colour_spaces import LUMINANCE
from ..lookup.lobes import STEPS, Material
from .lobes import END, SHARPEST, Paths, angles, fit_materials

_VARIES = 0.15  # standard deviation of the widths' logarithm, from which they are kept
_WIDE = 0.02  # how much the wider neighbourhood counts for
_LEAST, _MOST = 1 / 256, 256.0  # of width²
_AT_ONCE = 1 << 18


def fit_lobes(
    paths: Paths, count: int, neighbours: Neighbours, vary: bool = True
) -> tuple[tuple[Material, ...], Floats]:
    """The lobes of so many materials, and what their width² is multiplied by in each texel: (K,) float32.

    All 1 where widths hardly differ, or if they may not `vary`.
    """
    width = fit_widths(paths, neighbours)
    if not vary or np.log(width).std() / 2 < _VARIES:
        return fit_materials(paths, count), np.ones_like(width)
    return fit_materials(replace(paths, width=width[paths.texel]), count), width


def fit_widths(paths: Paths, neighbours: Neighbours) -> Floats:
    """By how much the texels' paths are further from their axes than those of their material, squared: (K,).

    Means of logarithms, which the few paths in a lobe's tails hardly change; float32.
    """
    texels = len(neighbours.plan.texel)
    kind = paths.material.astype(np.intp) * STEPS
    kind += np.clip((paths.cosine * STEPS).astype(np.intp), 0, STEPS - 1)
    bright = (paths.weight @ LUMINANCE).astype(np.float64)
    bright[np.linalg.norm(paths.end, axis=1) < END] = 0
    far = np.empty(len(bright))
    for first in range(0, len(bright), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        length = np.maximum(np.linalg.norm(paths.end[some], axis=1), END)
        up, across = angles(paths.end[some] / length[:, None], paths.axis[some], paths.normal[some])
        far[some] = np.log(np.maximum(up**2 + across**2, SHARPEST**2))
    usual = np.bincount(kind, bright * far) / np.maximum(np.bincount(kind, bright), 1e-12)
    sums = [np.bincount(paths.texel, values, texels) for values in (bright * (far - usual[kind]), bright)]
    table = np.stack(sums)[..., None].astype(np.float32)
    pooled = neighbours.pool(table) + np.float32(_WIDE) * neighbours.pool(table, True)
    width = np.exp(pooled[0, :, 0] / np.maximum(pooled[1, :, 0], 1e-12))
    return np.clip(width, _LEAST, _MOST).astype(np.float32)
