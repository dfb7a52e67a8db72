# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far from the surface a ray starts."""

from __future__ import annotations

import numpy as np

from .arrays import Floats

GRAZING = 0.01  # least cosine between a ray and the normal of the facet that it starts from
_OF_SIZE = 5e-4  # times the object's diagonal: less than a texel, more than facets lie off the smooth surface
_OF_COORDINATE = 5e-5  # times the largest coordinate: lifts a grazing ray's start by eight float32 steps


def ray_offset(position: Floats) -> float:
    """Distance in scene units between P and a ray's start, for surface positions (..., 3) in world space."""
    points = position.reshape(-1, 3).astype(np.float64)
    diagonal = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    return max(_OF_SIZE * diagonal, _OF_COORDINATE * float(np.abs(points).max()), 1e-9)
