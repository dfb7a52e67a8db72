# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Add samples to an existing atlas, for --accumulate."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ...bake.piece_store import PieceStore
from ...bake.progress import Progress
from ...bake.thumbnail import Thumbnail
from ...core.arrays import Floats, Ints
from .recapture import Recapture


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
