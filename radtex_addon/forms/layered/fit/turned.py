# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples along the mirror directions of shading normals."""

from __future__ import annotations

import numpy as np

from ....bake.blocks import planes
from ....bake.light_samples import Some, straight_through
from ....bake.plan import CapturePlan
from ....core.arrays import Floats
from ....core.octahedron import direction_to_octahedron
from ..lookup.lobes import lifted


def mirrored_about(plan: CapturePlan, square: Floats, normal: Floats, some: Some) -> tuple[Floats, Floats]:
    """The mirror directions of some texels' viewers about `normal` (K, 3), (3, k, S), and N.V (k, S).

    None lies below the surface.

    `square` (K, S, 2): the viewers' bucket coordinates; float32.
    """
    viewer = planes(-straight_through(plan, square[some].astype(np.float32, copy=False), some))
    about = normal[some].T[..., None]
    cosine = (viewer * about).sum(axis=0)
    axis = lifted(2 * cosine * about - viewer, plan.normals[some].T[..., None])
    return axis, np.clip(cosine, 1e-3, 1)


def octahedral(axis: Floats) -> Floats:
    """Places on the octahedron's square of directions (3, ...): (2, ...)."""
    return planes(direction_to_octahedron(np.moveaxis(axis, 0, -1)))
