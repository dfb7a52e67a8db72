# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far from the surface a ray starts."""

from __future__ import annotations

import numpy as np

from .arrays import Floats

GRAZING = 0.01  # least cosine between a ray and the facet it starts at
_OF_SIZE = 5e-4  # of the object's diagonal: below a texel, above what smooth shading bends
_OF_COORDINATE = 5e-5  # of the largest coordinate: eight float32 steps of height at a grazing ray


def ray_offset(position: Floats) -> float:
    """Distance in scene units between P and a ray's start, for surface positions (..., 3) in world space."""
    points = position.reshape(-1, 3).astype(np.float64)
    diagonal = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    return max(_OF_SIZE * diagonal, _OF_COORDINATE * float(np.abs(points).max()), 1e-9)
