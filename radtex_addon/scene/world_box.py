# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An object's place and bounding box in world space."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats


def world_box(item: Any, matrix_world: Any) -> tuple[Floats, Floats]:
    """The least and the greatest coordinates, (3,) each, of the corners of an object's box under a matrix."""
    matrix = np.array(matrix_world)
    corners = np.array(item.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]
    return corners.min(axis=0), corners.max(axis=0)


def about_matrix(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> Floats:
    """An object's matrix (4, 4), from object to world, where no render may be made to ask for it.

    Blender does not evaluate for a viewport what is hidden there (the monitor icon), and leaves its
    `matrix_world` as it was: then it is the object's own transform and its parents', constraints left out.
    """
    graph = layer.depsgraph
    if graph is not None and cast(Any, item.evaluated_get(graph)).is_evaluated:
        return np.array(item.matrix_world, dtype=np.float64)
    own = np.array(item.matrix_basis, dtype=np.float64)
    if item.parent is None:
        return own
    placed: Floats = (
        about_matrix(item.parent, layer) @ np.array(item.matrix_parent_inverse, dtype=np.float64) @ own
    )
    return placed
