# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked surface as arrays: the mesh data that rasterisation needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Floats, Ints


@dataclass(frozen=True)
class SurfaceMesh:
    """A triangulated surface in world space, with the frame of its baked UV layer at every corner.

    V vertices, F triangles: `position` (V, 3); `triangles` (F, 3) vertex indices; `normal` and MikkTSpace's
    `tangent` (F, 3, 3), transformed by the object's matrix but not normalised: shaders interpolate before
    they normalise, and so must rasterisation; `sign` (F, 3) of the bitangent, +1 or -1, already multiplied by
    the sign of the object matrix's determinant; `uv` (F, 3, 2) with v up; `material` (F,), the number of each
    triangle's material, None if all have the first.
    """

    position: Floats
    triangles: Ints
    normal: Floats
    tangent: Floats
    sign: Floats
    uv: Floats
    material: Ints | None = None

    @property
    def material_numbers(self) -> Ints:
        """`material`, (F,) int32, 0 where it is None."""
        return np.zeros(len(self.triangles), dtype=np.int32) if self.material is None else self.material

    @property
    def corner_position(self) -> Floats:
        """Positions of the triangles' corners, (F, 3, 3)."""
        return self.position[self.triangles]
