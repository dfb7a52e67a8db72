# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What was not captured takes the nearest texel's value, cell by cell, and what was captured stays."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake.hidden_cells import fill_missing
from radtex_addon.core.arrays import Bools, Floats


def numbered(height: int, width: int, n: int) -> Floats:
    """Buckets (H, W, n, n, 2) whose cells tell where they came from: flat texel index, and q * n + p."""
    texel = np.broadcast_to(np.arange(height * width).reshape(height, width, 1, 1), (height, width, n, n))
    cell = np.broadcast_to(np.arange(n * n).reshape(n, n), (height, width, n, n))
    return np.stack([texel, cell], axis=-1).astype(np.float32)


def fill(buckets: Floats, covered: Bools, hidden: Bools | None = None) -> None:
    """Fill to the end; the steps count up to the number of directions."""
    steps = list(fill_missing(buckets, covered, hidden))
    assert [step.done for step in steps] == list(range(len(steps)))
    assert all(step.total == len(steps) for step in steps)


def nearest(valid: Bools, j: int, i: int) -> set[int]:
    """The flat indices of the nearest valid texels of (j, i), by trying all."""
    rows, columns = np.nonzero(valid)
    distance = (rows - j) ** 2 + (columns - i) ** 2
    found = (rows * valid.shape[1] + columns)[distance == distance.min()]
    return {int(k) for k in found}


@pytest.mark.parametrize(("share", "marked"), [(0.2, 0.0), (0.7, 0.5)])
def test_a_cell_takes_the_same_cell_of_the_nearest_texel_that_shows_it(share: float, marked: float) -> None:
    """Marks on texels that are not covered say nothing; without any, a gutter has whole copies."""
    rng = np.random.default_rng(2)
    covered = rng.random((7, 11)) < share
    hidden = rng.random((7, 11, 3, 3)) < marked
    buckets = numbered(7, 11, 3)
    before = buckets.copy()
    fill(buckets, covered, hidden if marked else None)
    for q, p in np.ndindex(3, 3):
        seen = covered & ~hidden[:, :, q, p]
        np.testing.assert_array_equal(buckets[seen][:, q, p], before[seen][:, q, p])
        for j, i in np.argwhere(~seen):
            assert int(buckets[j, i, q, p, 0]) in nearest(seen, j, i), "from the nearest, gutters included"
            assert marked or len(np.unique(buckets[j, i, ..., 0])) == 1
    np.testing.assert_array_equal(buckets[..., 1], before[..., 1])  # cells never change places


def test_a_cell_that_is_hidden_everywhere_keeps_what_was_captured() -> None:
    covered = np.ones((3, 4), dtype=bool)
    covered[0, 0] = False
    hidden = np.zeros((3, 4, 2, 2), dtype=bool)
    hidden[..., 1, 0] = True
    buckets = numbered(3, 4, 2)
    before = buckets.copy()
    fill(buckets, covered, hidden)
    np.testing.assert_array_equal(buckets[covered], before[covered])
    assert buckets[0, 0, 1, 0, 0] in {1.0, 4.0}  # the gutter still takes its neighbour's
