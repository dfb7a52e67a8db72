# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fill gutters, and cells that nobody can see, from the nearest texel that has them."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ..core.arrays import Bools, Floats
from ..core.gutter import dilate, nearest_covered
from .progress import Progress, Stage


def fill_missing(
    buckets: Floats, covered: Bools, hidden: Bools | None = None
) -> Generator[Progress, None, None]:
    """Fill buckets (H, W, n, n, C) in place where texels are not `covered` (H, W) or cells are `hidden`.

    A missing cell takes the value of the same cell in the nearest texel that has it, by distance in texels.
    `hidden` is (H, W, n, n); only covered texels count. A cell that is hidden in all texels keeps its value.
    Yields progress in directions, as each direction with hidden cells has its own nearest texels.
    """
    everywhere = nearest_covered(covered)
    dilate(buckets, everywhere)
    if hidden is None:
        return
    directions = np.argwhere((hidden & covered[..., None, None]).any(axis=(0, 1)))
    for done, (q, p) in enumerate(directions):
        yield Progress(Stage.FILL, done, len(directions))
        seen = covered & ~hidden[:, :, q, p]
        if seen.any():
            dilate(buckets[:, :, q, p], nearest_covered(seen))
