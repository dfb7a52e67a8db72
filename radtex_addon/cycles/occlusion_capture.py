# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Capture which directions are blocked, by camera rays that start like shadow rays and end at the first hit.

The film is transparent and the world empty, so that alpha is the share of rays that were blocked. Lamps do
not block camera rays. No light is computed.

If only near objects count, each ray goes to a known point of its cell, and the position pass tells where it
ended. (A camera's clipping distance does not limit rays behind a portal.)
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, sqrt
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..bake.light_samples import spread_shifts
from ..bake.plan import MAX_IMAGE_SIDE, CapturePlan, Tile
from ..core.arrays import Bools, Floats
from ..core.atlas import AtlasLayout
from ..core.hemisphere import square_to_cosine
from ..scene.lights.casters import may_be_clear, shadow_casters_visible, show_all_collections
from ..settings.kinds import Kind
from ..settings.rays import CLEAR_SAMPLES
from .capture_settings import first_hit_only
from .portal import Aim, PortalCapture

_POSITION = "use_pass_position"
_MOST_PIXELS = 1 << 19  # of a render with the position pass


class OcclusionCapture:
    """Captures `shadow` and `ao` in a scratch scene: the share of each cell's rays that are not blocked."""

    def __init__(
        self,
        scene: bpy.types.Scene,
        plan: CapturePlan,
        kind: Kind,
        samples: int,
        seed: int,
        folder: Path,
        distance: float | None = None,
    ) -> None:
        """`scene` is a scratch scene, which is changed; `folder` is for the temporary files of tiles.

        For `shadow` all rays go to the middles of cells: one ray, or CLEAR_SAMPLES if a material may be
        clear. With a `distance`, in scene units, `ao` counts everything farther as open, and takes `rays` per
        cell: `samples` rounded up to a square, or fewer where the picture would become too large.
        """
        _look_for_casters_only(scene)
        self._scene, self._users = scene, {item.session_uid for item in bpy.data.objects}
        self._whole, self._distance = not kind.traits.samples, distance
        self._finer, aim = 1, None
        if self._whole:
            aim = Aim(np.full((len(plan.texel), 2), 0.5))
            samples = CLEAR_SAMPLES if may_be_clear() else 1
        elif distance is not None:
            self._finer = _finer(plan, samples)
            layout = plan.layout
            plan = replace(plan, layout=AtlasLayout(layout.width, layout.height, layout.bucket * self._finer))
            aim, samples = Aim(spread_shifts(len(plan.texel), seed), (_POSITION,)), 1
        self.rays = samples * self._finer**2
        self._plan, self._aim = plan, aim
        self._capture = PortalCapture(scene, plan, kind, samples, seed, folder, aim)

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels, (k, n, n, 1) float32, [texel, q, p]: 1 is open, 0 is blocked.

        For `shadow` there are no values in between. Raises BakeError where Cycles fails.
        """
        with shadow_casters_visible(self._scene, self._users):
            if self._distance is not None:
                return self._near(tile, self._distance)
            alpha = self._capture.render(tile)[..., 3:]
        return (alpha < 0.5).astype(np.float32) if self._whole else np.clip(1 - alpha, 0, 1)

    def _near(self, tile: Tile, distance: float) -> Floats:
        plan, side = self._plan, self._plan.layout.bucket
        rows = max(1, _MOST_PIXELS // (plan.columns * side * side))
        end, found = tile.first_row + tile.rows, []
        for first in range(tile.first_row, end, rows):
            part = Tile(first, min(rows, end - first))
            passes = self._capture.render_passes(part)
            stopped = self._stopped_within(distance, part, passes.raw["Position"][..., :3])
            alpha = np.clip(passes.raw_whole[..., 3], 0, 1) * stopped
            n = side // self._finer
            cells = alpha.reshape(len(alpha), n, self._finer, n, self._finer).mean(axis=(2, 4))
            found.append((1 - cells[..., None]).astype(np.float32))
        return np.concatenate(found)

    def _stopped_within(self, distance: float, tile: Tile, ends: Floats) -> Bools:
        """Which rays ended within `distance`: (k, n, n), for their `ends` (k, n, n, 3).

        Rays below the facet count as stopped; the result does not matter for rays that hit nothing.
        """
        plan, aim = self._plan, cast(Aim, self._aim)
        texels = slice(tile.first_row * plan.columns, tile.first_row * plan.columns + len(ends))
        frame = np.stack([plan.tangent, plan.bitangent, plan.normal]).reshape(3, -1, 3)[:, texels]
        facet = np.einsum("akx,kx->ka", frame, plan.facet.reshape(-1, 3)[texels])
        ways = square_to_cosine(aim.squares(plan.layout.bucket)[texels])
        below = np.einsum("kra,ka->kr", ways, facet).reshape(ends.shape[:3]) < 0
        away = ends - plan.points[texels][:, None, None]
        near: Bools = (np.einsum("kqpx,kqpx->kqp", away, away) <= distance * distance) | below
        return near


def _look_for_casters_only(scene: bpy.types.Scene) -> None:
    scene.render.film_transparent = True
    scene.world = cast(Any, None)
    show_all_collections(scene)
    first_hit_only(scene)
    cast(Any, scene).cycles.volume_bounces = 0


def _finer(plan: CapturePlan, samples: int) -> int:
    """Rays along a cell's side: enough for `samples`, but no more than a picture's largest side allows."""
    most = MAX_IMAGE_SIDE // (max(plan.rows, plan.columns) * plan.layout.bucket)
    return max(1, min(ceil(sqrt(samples)), most))
