# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake that is there says of an object, for a fit to more samples of its light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....bake.plan import CapturePlan
from ....core.arrays import Floats
from ....core.sampler import bilinear
from ..cells import Cells
from ..lookup.atlas import LayeredAtlas
from .texel_maps import texel_middles


@dataclass(frozen=True, eq=False)
class Known:
    """The `atlas` that is there, and the `share` that new samples are of all."""

    atlas: LayeredAtlas
    share: float

    @property
    def cells(self) -> Cells:
        """The cells of its buckets."""
        own, rest = self.atlas.own, self.atlas.rest
        return Cells(own.shape[2], rest.shape[2], own.shape[:2] != rest.shape[:2])

    def widths(self, plan: CapturePlan) -> Floats:
        """What lobes' width² is multiplied by in each of the plan's texels, (K,) float32."""
        if self.atlas.width is None:
            return np.ones(len(plan.texel), dtype=np.float32)
        width: Floats = 2.0 ** bilinear(self.atlas.width, texel_middles(plan))[:, 0].astype(np.float32)
        return width
