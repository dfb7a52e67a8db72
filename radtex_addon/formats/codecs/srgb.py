# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sRGB transfer function, IEC 61966-2-1, which GPUs undo before they filter."""

from __future__ import annotations

import numpy as np

from ...core.arrays import Floats


def to_srgb(linear: Floats) -> Floats:
    """Codes in 0..1, float32, of linear values in 0..1, of any shape."""
    curve = 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curve).astype(np.float32)


def from_srgb(coded: Floats) -> Floats:
    """The inverse of `to_srgb`."""
    curve = ((coded + 0.055) / 1.055) ** 2.4
    return np.where(coded <= 0.04045, coded / 12.92, curve).astype(np.float32)
