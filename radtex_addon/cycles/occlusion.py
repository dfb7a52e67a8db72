# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which directions are blocked: camera rays that start where shadow rays do, and end where they hit.

The film is transparent and the world empty, so that alpha says how much of a ray was stopped. Lamps do not
stop camera rays. No light is looked at.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..bake.plan import CapturePlan, Tile
from ..bake.spec import Kind
from ..core.arrays import Floats
from ..scene.casters import casters_seen, may_be_clear, show_all_collections
from .portal import Aim, PortalCapture
from .settings import first_hit_only

CLEAR_SAMPLES = 16  # rays that vote on a bit where something lets some of them through


class OcclusionCapture:
    """Captures `shadow` and `ao` in a scratch scene: the share of each cell's rays that nothing stops."""

    def __init__(
        self, scene: bpy.types.Scene, plan: CapturePlan, kind: Kind, samples: int, seed: int, folder: Path
    ) -> None:
        """`scene` is a scratch scene, written freely; `folder` takes the files that tiles pass through.

        For `shadow` all rays go to the middles of cells, `samples` of them only where anything is clear.
        """
        self._whole = kind is Kind.SHADOW
        scene.render.film_transparent = True
        scene.world = cast(Any, None)
        show_all_collections(scene)
        first_hit_only(scene)
        cast(Any, scene).cycles.volume_bounces = 0
        aim = None
        if self._whole:
            aim = Aim(np.full((len(plan.texel), 2), 0.5))
            samples = CLEAR_SAMPLES if may_be_clear() else 1
        self._users = {item.session_uid for item in bpy.data.objects}
        self._capture = PortalCapture(scene, plan, kind, samples, seed, folder, aim)

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels, (k, n, n, 1) float32, [texel, q, p]: 1 is open, 0 is blocked.

        Of `shadow` every cell is one or the other. Raises BakeError where Cycles fails.
        """
        with casters_seen(self._users):
            alpha = self._capture.render(tile)[..., 3:]
        return (alpha < 0.5).astype(np.float32) if self._whole else np.clip(1 - alpha, 0, 1)
