# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sRGB transfer function, IEC 61966-2-1. GPUs decode textures of it before they filter."""

from __future__ import annotations

import numpy as np

from ...core.arrays import Floats


def to_srgb(linear: Floats) -> Floats:
    """Codes in 0..1, float32, of linear values of any shape, which are clipped to 0..1."""
    light = np.clip(linear, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055).astype(np.float32)


def from_srgb(coded: Floats) -> Floats:
    """The inverse of `to_srgb`."""
    curve = ((coded + 0.055) / 1.055) ** 2.4
    return np.where(coded <= 0.04045, coded / 12.92, curve).astype(np.float32)
