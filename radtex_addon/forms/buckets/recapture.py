# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Capture texels of an atlas again: all for --accumulate, those whose light has changed for --refresh."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np

from ...bake.changes import changed_texels
from ...bake.hidden_cells import HiddenCells, fill_missing
from ...bake.piece_store import PieceStore, PrefixedStore
from ...bake.plan import CapturePlan, Tile, plan_capture
from ...bake.progress import Progress, Stage, relayed
from ...bake.session import fill_atlas
from ...bake.thumbnail import Thumbnail
from ...core.arrays import Bools, Floats, Ints
from ...core.errors import InputError
from ...core.texel_map import TexelMap
from ...cycles.portal import PortalCapture
from ...scene.checks.see_through import has_volumes
from ...scene.scratch import scene_copied
from ...settings.spec import BakeSpec, Kind
from .previous_atlas import PreviousAtlas

_CHANGED = "changed"  # a piece's name
_TILE_PIXELS = 1 << 20
_SEED = 7919  # added to the seed, so that the probe's paths differ from the atlas's


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


def accumulated(
    again: Recapture, store: PieceStore, thumbnail: Thumbnail | None
) -> Generator[Progress, None, tuple[Floats, int, Ints]]:
    """Add the specification's number of samples to the chosen texels, after those that each texel has.

    Returns the atlas (H*n, W*n, 4) float32, the mean over all samples of each texel; the number of new paths;
    and the samples per cell that each texel has now, (H, W). Raises BakeError where Cycles fails.
    """
    plan, counts = again.plan, again.counts
    more = np.where(again.chosen, again.spec.samples, 0)
    before = again.buckets()
    buckets = before.copy()
    paths = yield from again.capture(buckets, more, counts, store, thumbnail)
    some = plan.placed(again.chosen)
    both = counts + more
    new, old = (plan.placed(part / both).astype(np.float32)[some] for part in (more, counts))
    buckets[some] = _weighted(buckets[some], new) + _weighted(before[some], old)
    yield from again.fill(buckets)
    return plan.layout.from_buckets(buckets), paths, plan.placed(both, gutter=True)


def _weighted(buckets: Floats, share: Floats) -> Floats:
    weighted: Floats = buckets * share[:, None, None, None]
    return weighted


def refreshed(
    again: Recapture, store: PieceStore, thumbnail: Thumbnail | None
) -> Generator[Progress, None, tuple[Floats, int, Ints]]:
    """Find which of the chosen texels have changed, and capture them again with as many samples as before.

    Returns the atlas (H*n, W*n, 4) float32, otherwise unchanged; the number of paths; and the samples per
    cell that each texel has, (H, W). Raises BakeError where Cycles fails.
    """
    plan, buckets = again.plan, again.buckets()
    side = _coarser(plan.layout.bucket)
    probed = again.part(again.chosen, side)
    kept = store.found(_CHANGED)
    if kept is None:
        probe = yield from _probe(again, probed)
        kept = {"changed": changed_texels(probed, probe, _coarse(buckets, probed))}
        store.keep(_CHANGED, kept)
    paths = len(probed.texel) * side**2
    changed: Bools = np.zeros(len(plan.texel), dtype=bool)
    changed[again.chosen] = kept["changed"]
    if changed.any():
        samples = np.where(changed, again.counts, 0)
        paths += yield from again.capture(buckets, samples, np.zeros_like(samples), store, thumbnail)
        yield from again.fill(buckets)
    return plan.layout.from_buckets(buckets), paths, again.earlier.counts


def _coarse(buckets: Floats, probed: CapturePlan) -> Floats:
    """The atlas's light in the larger cells of a probe, means over the atlas's cells: (K, m, m, C)."""
    flat = buckets.reshape(-1, *buckets.shape[2:])[probed.texel]
    count, side = len(flat), probed.layout.bucket
    fine = flat.shape[1] // side
    means: Floats = flat.reshape(count, side, fine, side, fine, -1).mean(axis=(2, 4))
    return means


def _probe(again: Recapture, plan: CapturePlan) -> Generator[Progress, None, Floats]:
    """One path in each cell of all texels of the plan: (K, m, m, 4)."""
    spec, count = again.spec, len(plan.texel)
    rows = max(1, _TILE_PIXELS // (plan.columns * plan.layout.bucket**2))
    found = []
    with scene_copied(again.scene) as scene:
        capture = PortalCapture(scene, plan, again.kind, 1, (spec.seed + _SEED) % 2**31, again.folder)
        for row in range(0, plan.rows, rows):
            yield Progress(Stage.PROBE, min(row * plan.columns, count), count)
            found.append(capture.render(Tile(row, min(rows, plan.rows - row))))
    yield Progress(Stage.PROBE, count, count)
    return np.concatenate(found)


def _coarser(bucket: int) -> int:
    """Cells along the side of a probe's bucket: a divisor of the atlas's, about half of it."""
    return max(side for side in range(1, bucket + 1) if bucket % side == 0 and side <= max(2, bucket // 2))
