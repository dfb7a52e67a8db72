# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The colours of a thin film, as engines draw glTF's iridescence: three.js, Unity's HDRP and others.

Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence"
(2017), with the Fourier transform of the eye's sensitivity, as KHR_materials_iridescence writes it down.
"""

from __future__ import annotations

import numpy as np

from radtex_addon.core.arrays import Floats

VALUE = np.array([5.4856e-13, 4.4201e-13, 5.2481e-13])  # Gaussians that X, Y and Z are fitted by
PLACE = np.array([1.6810e06, 1.7953e06, 2.2084e06])
VARIANCE = np.array([4.3278e09, 9.3046e09, 6.6121e09])
SECOND = 9.7470e-14, 2.2399e06, 4.5282e09  # X has another
WHITE = 1.0685e-7
TO_REC709 = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)
_ORDERS = 2


def filmed(frontal: Floats, cosine: Floats, thickness: float, ior: float) -> Floats:
    """Frontal reflectances (K, 3) under a film, for Schlick's formula to give those at a cosine (K,).

    `frontal` (K, 3) are those without; `thickness` is in nanometres.
    """
    inner = np.sqrt(1 - (1 - cosine[:, None] ** 2) / ior**2)
    outer: Floats = np.full(frontal.shape, ((ior - 1) / (ior + 1)) ** 2)
    outer_once = _schlick(outer, cosine[:, None])
    passed = 1 - outer_once
    root = np.sqrt(np.clip(frontal, 0, 0.9999))
    base = (1 + root) / (1 - root)
    base_once = _schlick(np.square((base - ior) / (base + ior)), inner)
    phase = np.pi + np.where(base < ior, np.pi, 0)
    both = np.clip(outer_once * base_once, 1e-5, 0.9999)
    through = passed**2 * base_once / (1 - both)
    light, order = outer_once + through, through - passed
    path = 2 * ior * thickness * inner
    for number in range(1, _ORDERS + 1):
        order = order * np.sqrt(both)
        light = light + order * 2 * _sensitivity(number * path, number * phase)
    edge = np.minimum((1 - cosine[:, None]) ** 5, 0.9999)
    found: Floats = (np.maximum(light, 0) - edge) / (1 - edge)
    return np.clip(found, 0, 1).astype(frontal.dtype)


def _schlick(frontal: Floats, cosine: Floats) -> Floats:
    found: Floats = frontal + (1 - frontal) * (1 - cosine) ** 5
    return found


def _sensitivity(path: Floats, shift: Floats) -> Floats:
    """The eye's response (K, 3) in Rec.709 to path differences (K, 1) in nanometres, shifted (K, 3)."""
    phase = 2 * np.pi * path * 1e-9
    wide = np.sqrt(2 * np.pi * VARIANCE)
    xyz = VALUE * wide * np.cos(PLACE * phase + shift) * np.exp(-(phase**2) * VARIANCE)
    value, place, variance = SECOND
    second = value * np.sqrt(2 * np.pi * variance) * np.exp(-variance * phase[:, 0] ** 2)
    xyz[:, 0] += second * np.cos(place * phase[:, 0] + shift[:, 0])
    response: Floats = (xyz / WHITE) @ TO_REC709.T
    return response
