# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The directions from which a `transfer` bake looks at its texels: see `bake.choices.View`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.arrays import Floats
from ..core.frame import normalised, to_frame
from ..core.hemisphere import direction_to_square
from .choices import View
from .plan import CapturePlan

_AROUND = 3  # views along a bucket's side
_STRAIGHT = 0.51  # almost along the normal: the exact middle of a bucket has no azimuth


@dataclass(frozen=True)
class Eye:
    """A camera's place in world space; if `far`, as for an orthographic camera, the unit direction to it."""

    place: tuple[float, float, float]
    far: bool = False

    def direction_from(self, points: Floats) -> Floats:
        """Unit vectors (K, 3) float64 from points (K, 3) to the eye."""
        place = np.asarray(self.place, dtype=np.float64)
        return normalised(np.broadcast_to(place, points.shape) if self.far else place - points)


def views_along(view: View) -> int:
    """The number of views along a bucket's side; its square is captured."""
    return _AROUND if view is View.AROUND else 1


def view_shift(plan: CapturePlan, eye: Eye | None = None) -> Floats:
    """The place in its cells from which each texel is looked at: (K, 2) float32, 0 to 1 along a side.

    Without an `eye` it is the cells' middle, which for buckets of one cell is along the normal. A texel that
    faces away from the eye is looked at from the eye's mirror image in its plane: near a silhouette that is
    almost the same direction, and elsewhere nobody sees such texels.
    """
    count = len(plan.texel)
    if eye is None:
        return np.full((count, 2), _STRAIGHT, dtype=np.float32)
    frame = (field.reshape(-1, 3)[:count] for field in (plan.tangent, plan.bitangent, plan.normal))
    local = to_frame(eye.direction_from(plan.points.astype(np.float64)), *frame)
    local[:, 2] = np.abs(local[:, 2])
    place: Floats = ((direction_to_square(normalised(local)) + 1) / 2).astype(np.float32)
    middle = np.abs(place - 0.5).max(axis=1) < _STRAIGHT - 0.5
    place[middle] = _STRAIGHT
    return place
