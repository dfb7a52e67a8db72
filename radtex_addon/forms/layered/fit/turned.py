# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples along the mirror directions of shading normals."""

from __future__ import annotations

from typing import cast

import numpy as np

from ....bake.blocks import planes
from ....bake.light_samples import LobeSamples, Some, straight_through
from ....bake.plan import CapturePlan
from ....core.arrays import Floats
from ....core.octahedron import direction_to_octahedron


class _Turned(LobeSamples):
    """Samples along the mirror directions of shading normals `normal` (K, 3)."""

    normal: Floats

    def along(self, some: Some) -> tuple[Floats, Floats]:
        axis = mirrored_about(self.plan, self.square[some].astype(np.float32), self.normal, some)
        return planes(axis), planes(direction_to_octahedron(axis))


def turned_samples(samples: LobeSamples, normal: Floats) -> LobeSamples:
    """The samples along the mirror directions about `normal` (K, 3)."""
    turned = _Turned(samples.plan, samples.axis, samples.square, samples.values, samples.used)
    object.__setattr__(turned, "normal", normal)
    return turned


def mirrored_about(plan: CapturePlan, square: Floats, normal: Floats, some: Some) -> Floats:
    """The mirror directions about `normal` (K, 3) of viewers at bucket coordinates (k, S, 2): (k, S, 3)."""
    viewer = -straight_through(plan, square, some)
    about = normal[some][:, None]
    axis: Floats = 2 * (viewer * about).sum(axis=-1, keepdims=True) * about - viewer
    return axis.astype(np.float32)


def cosines(plan: CapturePlan, square: Floats, normal: Floats, some: Some) -> Floats:
    """N.V about the shading normals, (k, S)."""
    viewer = -straight_through(plan, square[some].astype(np.float32), some)
    return cast(Floats, np.clip((viewer * normal[some][:, None]).sum(axis=-1), 1e-3, 1))
