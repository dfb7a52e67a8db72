# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Roughness that varies within a material: by how much the lobes of each texel are wider than their material's.

The scale that makes a texel's paths likeliest, by expectation maximisation as in lobes.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radtex_addon.bake.gloss import LUMINANCE
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.core.arrays import Floats

from .lobes import END, Material, Paths, angles, fit_materials, lobe

_ROUNDS = 2  # of materials, and widths in them
_TURNS = 3
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
    texels = len(neighbours.plan.texel)
    materials, width = fit_materials(paths, count), np.ones(texels, dtype=np.float32)
    if not vary or not len(paths.texel):
        return materials, width
    varied = materials
    for _ in range(_ROUNDS):
        width = fit_widths(paths, varied, width, neighbours)
        if np.log(width).std() / 2 < _VARIES:
            return materials, np.ones(texels, dtype=np.float32)
        varied = fit_materials(replace(paths, width=width[paths.texel]), count)
    return varied, width


def fit_widths(paths: Paths, materials: Sequence[Material], start: Floats, neighbours: Neighbours) -> Floats:
    """What each texel's width² is multiplied by, (K,) float32, beginning with `start` (K,)."""
    texels = len(start)
    width = start.astype(np.float64)
    for _ in range(_TURNS):
        sums = np.zeros((2, texels))
        for first in range(0, len(paths.texel), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            texel = paths.texel[some]
            for row, values in zip(sums, _pull(paths, some, materials, width[texel]), strict=True):
                row += np.bincount(texel, values, texels)
        table = sums[..., None].astype(np.float32)
        pooled = neighbours.pool(table) + _WIDE * neighbours.pool(table, True)
        told = pooled[1, :, 0] > 0
        width[told] = np.clip(pooled[0, told, 0] / pooled[1, told, 0], _LEAST, _MOST)
    return width.astype(np.float32)


def _pull(paths: Paths, some: slice, materials: Sequence[Material], width: Floats) -> tuple[Floats, Floats]:
    """Squared widths that paths ask for over those of their material, times their weight, and the weight."""
    bright = (paths.weight[some] @ LUMINANCE).astype(np.float64)
    length = np.linalg.norm(paths.end[some], axis=1)
    bright[length < END] = 0
    end = paths.end[some] / np.maximum(length, END)[:, None]
    up, across = angles(end, paths.axis[some], paths.normal[some])
    asked = np.zeros(len(bright))
    for number, material in enumerate(materials):
        own = np.flatnonzero(paths.material[some] == number)
        if not len(own):
            continue
        weight, variance, bend = material.at(paths.cosine[some][own])
        squared = (up[own] - bend) ** 2 + across[own] ** 2
        variance = np.maximum(variance, 1e-9)
        now = variance * width[own]
        likely = weight.sum(axis=1) * lobe(squared, now)
        likely /= np.maximum(likely.sum(axis=0), 1e-30)
        asked[own] = (likely * 2 / (2 + squared / now) * squared / variance).sum(axis=0)
    return bright * asked, bright
