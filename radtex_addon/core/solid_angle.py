# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solid angles of a bucket's cells, in closed form.

The projection preserves area: a solid angle is twice its area on the disc. The map to the square does not:
where |B.x| >= |B.y| it has the Jacobian x^2 / (x^2 + y^2), whose integral over a rectangle is elementary.
"""

from __future__ import annotations

import numpy as np

from .arrays import Floats
from .errors import ShapeError


def cell_solid_angles_sr(bucket: int) -> Floats:
    """Solid angle of each cell: (n, n) float64, steradians, indexed [q, p]; they sum to 2 pi."""
    if bucket < 1:
        raise ShapeError(f"bucket: expected at least 1 cell a side, got {bucket}")
    edges = (2 * np.arange(bucket + 1) - bucket) / bucket  # exactly symmetric
    index = np.arange(bucket)
    near = np.minimum(np.abs(edges[:-1]), np.abs(edges[1:]))  # a cell's edge towards the centre …
    far = np.maximum(np.abs(edges[:-1]), np.abs(edges[1:]))  # … and away from it
    column, row = np.meshgrid(index, index)
    major = np.maximum(far[column], far[row])
    wide = np.where(far[column] >= far[row], column, row)  # the axis along which the cell lies further out
    narrow = np.where(far[column] >= far[row], row, column)
    area = _rectangle_area(near[wide], far[wide], edges[narrow], edges[narrow + 1])
    diagonal = far[column] == far[row]
    area[diagonal] = _diagonal_area(near[column], far[column])[diagonal]
    centre = bucket // 2
    if bucket % 2:  # the middle cell is a small disc
        area[centre, centre] = np.pi * major[centre, centre] ** 2
    return 2 * area


def _primitive(x: Floats, y: Floats) -> Floats:
    """F with dF/dx = x atan(y / x): the Jacobian integrated over y from 0."""
    value: Floats = (x * x * np.arctan2(y, x) + y * x - y * y * np.arctan2(x, y)) / 2
    return value


def _rectangle_area(x0: Floats, x1: Floats, y0: Floats, y1: Floats) -> Floats:
    """Disc area of the cell [x0, x1] x [y0, y1] within 0 <= |y| <= x."""

    def strip(y: Floats) -> Floats:
        magnitude = np.abs(y)
        area: Floats = np.sign(y) * (_primitive(x1, magnitude) - _primitive(x0, magnitude))
        return area

    return strip(y1) - strip(y0)


def _diagonal_area(near: Floats, far: Floats) -> Floats:
    """Disc area of the cell [near, far]^2: twice its triangle below the diagonal."""
    below: Floats = np.pi / 8 * (far**2 - near**2) - (_primitive(far, near) - _primitive(near, near))
    area: Floats = 2 * below
    return area
