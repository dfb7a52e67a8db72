# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking again only the texels whose light has changed."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..bake.changes import changed_texels
from ..bake.checkpoint import Keeper
from ..bake.filling import fill_missing
from ..bake.plan import CapturePlan, Tile, plan_capture
from ..bake.progress import Progress, Stage
from ..bake.session import fill_atlas
from ..bake.spec import BakeSpec, Kind
from ..bake.thumbnail import Thumbnail
from ..core.arrays import Bools, Floats, Ints
from ..core.texel_map import TexelMap
from ..cycles.portal import PortalCapture
from ..scene.scratch import scene_copied
from .accumulate import Earlier

_CHANGED = "changed"  # a piece's name
_TILE_PIXELS = 1 << 20
_SEED = 7919  # the probe's paths are none of the atlas's


@dataclass(frozen=True, eq=False)
class Refresh:
    """What to bake again of an earlier bake: `texels` in a `plan`, as a scratch scene shows them now."""

    scene: bpy.types.Scene
    spec: BakeSpec
    kind: Kind
    texels: TexelMap
    plan: CapturePlan
    hidden: Bools | None
    earlier: Earlier
    folder: Path

    def steps(
        self, keeper: Keeper, thumbnail: Thumbnail | None
    ) -> Generator[Progress, None, tuple[Floats, int]]:
        """Find what has changed, and capture that with the atlas's own number of samples.

        Returns the atlas (H*n, W*n, 4) float32, in which all else is what it was, and how many paths it took.
        Raises BakeError where Cycles fails.
        """
        layout = self.plan.layout
        buckets = layout.to_buckets(self.earlier.pixels.astype(np.float32)).copy()
        changed, paths = yield from self._changed(buckets, keeper)
        if changed.any():
            part = plan_capture(self.texels, layout.bucket, without=self._others(changed))
            capture = PortalCapture(
                self.scene, part, self.kind, self.earlier.samples, self.spec.seed, self.folder
            )
            image = yield from fill_atlas(part, capture, self.spec.memory_mb, None, keeper, thumbnail)
            buckets[part.covered] = layout.to_buckets(image)[part.covered]
            paths += len(part.texel) * layout.bucket**2 * self.earlier.samples
            marks = self.plan.placed(self.hidden) if self.hidden is not None and self.hidden.any() else None
            yield from fill_missing(buckets, self.plan.covered, marks)
        return layout.from_buckets(buckets), paths

    def _others(self, changed: Bools) -> Ints:
        """Flat indices of all covered texels but those that have changed."""
        return np.setdiff1d(np.flatnonzero(self.texels.triangle >= 0), self.plan.texel[changed])

    def _changed(self, buckets: Floats, keeper: Keeper) -> Generator[Progress, None, tuple[Bools, int]]:
        """Which of the plan's texels have changed, and how many paths it took to know."""
        side = _coarser(self.plan.layout.bucket)
        count = len(self.plan.texel)
        kept = keeper.found(_CHANGED)
        if kept is None:
            probe = yield from self._probe(side)
            flat = buckets.reshape(-1, *buckets.shape[2:])[self.plan.texel]
            fine = self.plan.layout.bucket // side
            before = flat.reshape(count, side, fine, side, fine, -1).mean(axis=(2, 4))
            kept = {"changed": changed_texels(self.plan, probe, before)}
            keeper.keep(_CHANGED, kept)
        return kept["changed"], count * side**2

    def _probe(self, side: int) -> Generator[Progress, None, Floats]:
        """One path in each of `side` x `side` cells of all texels: (K, side, side, 4)."""
        spec, count = self.spec, len(self.plan.texel)
        unseen = np.setdiff1d(np.flatnonzero(self.texels.triangle >= 0), self.plan.texel)
        plan = plan_capture(self.texels, side, without=unseen)
        rows = max(1, _TILE_PIXELS // (plan.columns * side**2))
        found = []
        with scene_copied(self.scene) as scene:
            capture = PortalCapture(scene, plan, self.kind, 1, (spec.seed + _SEED) % 2**31, self.folder)
            for row in range(0, plan.rows, rows):
                yield Progress(Stage.PROBE, min(row * plan.columns, count), count)
                found.append(capture.render(Tile(row, min(rows, plan.rows - row))))
        yield Progress(Stage.PROBE, count, count)
        return np.concatenate(found)


def _coarser(bucket: int) -> int:
    """Cells along the side of a probe's bucket: a divisor of the atlas's, about half of it."""
    return max(side for side in range(1, bucket + 1) if bucket % side == 0 and side <= max(2, bucket // 2))
