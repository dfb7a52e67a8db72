# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Capture some or all texels of an existing atlas again, each with its own number of samples."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np

from ...bake.hidden_cells import HiddenCells, fill_missing
from ...bake.piece_store import PieceStore, PrefixedStore
from ...bake.plan import CapturePlan, plan_capture
from ...bake.progress import Progress, Stage, relayed
from ...bake.session import fill_atlas
from ...bake.spec import BakeSpec, Kind
from ...bake.thumbnail import Thumbnail
from ...core.arrays import Bools, Floats, Ints
from ...core.errors import InputError
from ...core.texel_map import TexelMap
from ...cycles.portal import PortalCapture
from ...scene.checks.see_through import has_volumes
from ...scene.scratch import scene_copied
from .previous_atlas import PreviousAtlas


@dataclass(frozen=True, eq=False)
class Recapture:
    """The texels of a `plan` in a scratch scene, to be captured again, and their `earlier` atlas.

    `hidden` are the cells that nobody can see. `chosen` (K,) are the plan's texels that may change.
    """

    scene: bpy.types.Scene
    spec: BakeSpec
    kind: Kind
    texels: TexelMap
    plan: CapturePlan
    hidden: HiddenCells | None
    earlier: PreviousAtlas
    chosen: Bools
    folder: Path

    @property
    def counts(self) -> Ints:
        """The samples per cell that the plan's texels have in the earlier atlas: (K,)."""
        counts: Ints = self.earlier.counts.ravel()[self.plan.texel]
        return counts

    def buckets(self) -> Floats:
        """A copy of the earlier atlas's buckets: (H, W, n, n, 4)."""
        copy: Floats = self.plan.layout.to_buckets(self.earlier.pixels).copy()
        return copy

    def part(self, some: Bools, bucket: int) -> CapturePlan:
        """A plan of only the texels where `some` (K,) is True, with `bucket` cells along a bucket's side."""
        others = np.setdiff1d(np.flatnonzero(self.texels.covered), self.plan.texel[some])
        return plan_capture(self.texels, bucket, others, self.spec.sheet)

    def capture(
        self, buckets: Floats, samples: Ints, first: Ints, store: PieceStore, thumbnail: Thumbnail | None
    ) -> Generator[Progress, None, int]:
        """Capture the plan's texels and replace their `buckets` (H, W, n, n, 4); returns the number of paths.

        Each texel gets `samples` (K,) per cell, numbered from `first` (K,) on; with 0 it is left as it is.
        Raises BakeError where Cycles fails.
        """
        layout, wanted = self.plan.layout, samples > 0
        done, paths, total = 0, 0, int(wanted.sum())
        for start, number in np.unique(np.stack([first, samples], axis=1)[wanted], axis=0).tolist():
            some = (first == start) & (samples == number)
            part = self.part(some, layout.bucket)
            with scene_copied(self.scene) as scene:
                capture = PortalCapture(
                    scene, part, self.kind, number, self.spec.seed, self.folder, first=start
                )
                drawer = PrefixedStore(store, f"{start}-{number}-")
                memory, uncut = self.spec.tile_mb, has_volumes(scene)
                steps = fill_atlas(part, capture, memory, None, drawer, thumbnail, uncut=uncut)
                image = yield from relayed(steps, partial(_after, done, total))
            buckets[part.covered] = layout.to_buckets(image)[part.covered]
            done += len(part.texel)
            paths += len(part.texel) * layout.bucket**2 * number
        return paths

    def fill(self, buckets: Floats) -> Generator[Progress, None, None]:
        """Fill gutters and hidden cells of `buckets` in place, from the nearest texels."""
        hidden = self.hidden
        marks = None if hidden is None else self.plan.placed(hidden.cells)
        yield from fill_missing(buckets, self.plan.covered, marks)


def chosen_texels(plan: CapturePlan, texels: TexelMap, triangles: Bools | None, where: str | None) -> Bools:
    """Marks (K,) of the plan's texels that lie on the chosen `triangles` (F,); all if that is None.

    Raises InputError, with the name `where`, if there are none.
    """
    if triangles is None:
        return np.ones(len(plan.texel), dtype=bool)
    chosen: Bools = triangles[texels.triangle.ravel()[plan.texel]]
    if not chosen.any():
        raise InputError(f"the atlas shows no face of '{where}': name another place, or bake more texels")
    return chosen


def _after(done: int, total: int, step: Progress) -> Progress:
    """The progress of all groups, from that of one."""
    return Progress(step.stage, done + step.done, total) if step.stage is Stage.CAPTURE else step
