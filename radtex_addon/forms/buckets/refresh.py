# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake only the texels again whose light has changed, for --refresh."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ...bake.changes import changed_texels
from ...bake.piece_store import PieceStore
from ...bake.plan import CapturePlan, Tile
from ...bake.progress import Progress, Stage
from ...bake.thumbnail import Thumbnail
from ...core.arrays import Bools, Floats, Ints
from ...cycles.portal import PortalCapture
from ...scene.scratch import scene_copied
from .recapture import Recapture

_CHANGED = "changed"  # a piece's name
_TILE_PIXELS = 1 << 20
_SEED = 7919  # added to the seed, so that the probe's paths differ from the atlas's


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
