# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An object's bounding box in world space."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.arrays import Floats


def world_box(item: Any, matrix_world: Any) -> tuple[Floats, Floats]:
    """The least and the greatest coordinates, (3,) each, of the corners of an object's box under a matrix."""
    matrix = np.array(matrix_world)
    corners = np.array(item.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]
    return corners.min(axis=0), corners.max(axis=0)
