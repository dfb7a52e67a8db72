# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The other half of the split sum: how much of even surroundings a GGX lobe mirrors, as a small table.

Karis, "Real Shading in Unreal Engine 4" (2013), with Smith's height-correlated masking (Heitz, 2014), and
with the light of many bounces between the microfacets put back: Turquin, "Practical Multiple Scattering
Compensation for Microfacet Models" (2019), as Filament and Unreal have it.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import bilinear

_SIZE = 32
_RAYS = 1024


def reflectance(frontal: Floats, cosine: Floats, roughness: Floats) -> Floats:
    """The share (K, 3) that a lobe mirrors of even light, for its reflectance from the front, (K, 3).

    `cosine` (K,) of the angle between normal and viewer, `roughness` (K,) as the Principled shader has it.
    """
    uv = np.stack([cosine, roughness], axis=1).astype(np.float32)
    scale, bias = np.moveaxis(bilinear(table(), uv)[:, :2, None], 1, 0)
    once = frontal * scale + bias
    found: Floats = once * (1 + frontal * (1 / np.maximum(scale + bias, 1e-3) - 1))
    return found


@cache
def table() -> Floats:
    """Scale and bias of the frontal reflectance, (32, 32, 2) float32: by roughness, then by cosine."""
    middle = (np.arange(_SIZE) + 0.5) / _SIZE
    return np.stack([np.stack([_entry(c, rough**2) for c in middle]) for rough in middle]).astype(np.float32)


def _entry(cosine: float, alpha: float) -> Floats:
    half = ggx_halves(alpha, _RAYS)
    viewer = np.array([np.sqrt(1 - cosine**2), 0, cosine])
    along = half @ viewer
    light = 2 * along * half[:, 2] - cosine
    seen = light > 0
    along, light, upright = along[seen], light[seen], half[seen, 2]
    masked = light * np.sqrt(cosine**2 * (1 - alpha**2) + alpha**2)
    shadowed = cosine * np.sqrt(light**2 * (1 - alpha**2) + alpha**2)
    visible = 2 * light * cosine / (masked + shadowed)
    share = visible * along / (upright * cosine)
    edge = (1 - along) ** 5
    return np.array([((1 - edge) * share).sum(), (edge * share).sum()]) / _RAYS


def ggx_halves(alpha: float, count: int) -> Floats:
    """Half vectors around +z, (count, 3), as GGX of width `alpha` has them, times the cosine; a spiral."""
    share = (np.arange(count) + 0.5) / count
    cosine = np.sqrt((1 - share) / (1 + (alpha**2 - 1) * share))
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    azimuth = np.arange(count) * np.pi * (3 - np.sqrt(5))
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=1)
