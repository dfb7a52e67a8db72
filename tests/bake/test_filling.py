# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What was not captured takes the nearest texel's value, cell by cell, and what was captured stays."""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.filling import fill_missing
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


def nearest(valid: Bools, j: int, i: int) -> tuple[float, set[int]]:
    """Squared distance to the nearest valid texels of (j, i), and their flat indices, by trying all."""
    rows, columns = np.nonzero(valid)
    distance = (rows - j) ** 2 + (columns - i) ** 2
    least = distance.min()
    found = rows[distance == least] * valid.shape[1] + columns[distance == least]
    return float(least), {int(k) for k in found}


def test_gutters_take_the_nearest_covered_texel_and_the_rest_stays() -> None:
    rng = np.random.default_rng(1)
    covered = rng.random((7, 11)) < 0.2
    buckets = numbered(7, 11, 2)
    before = buckets.copy()
    fill(buckets, covered)
    np.testing.assert_array_equal(buckets[covered], before[covered])
    for j, i in np.argwhere(~covered):
        _, sources = nearest(covered, j, i)
        assert len(np.unique(buckets[j, i, ..., 0])) == 1, "a texel of the gutter is a whole copy"
        assert int(buckets[j, i, 0, 0, 0]) in sources
    np.testing.assert_array_equal(buckets[..., 1], before[..., 1])  # cells never change places


def test_a_hidden_cell_takes_the_same_cell_of_the_nearest_texel_that_shows_it() -> None:
    rng = np.random.default_rng(2)
    covered = rng.random((6, 9)) < 0.7
    hidden = rng.random((6, 9, 3, 3)) < 0.5
    buckets = numbered(6, 9, 3)
    before = buckets.copy()
    fill(buckets, covered, hidden)
    for q in range(3):
        for p in range(3):
            seen = covered & ~hidden[:, :, q, p]
            np.testing.assert_array_equal(buckets[seen][:, q, p], before[seen][:, q, p])
            for j, i in np.argwhere(~seen):
                _, sources = nearest(seen, j, i)
                assert int(buckets[j, i, q, p, 0]) in sources, "from the nearest, gutters included"
    np.testing.assert_array_equal(buckets[..., 1], before[..., 1])


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


def test_marks_on_texels_that_are_not_covered_say_nothing() -> None:
    covered = np.array([[True, False, True]])
    hidden = np.zeros((1, 3, 2, 2), dtype=bool)
    hidden[0, 1] = True
    marked, plain = numbered(1, 3, 2), numbered(1, 3, 2)
    fill(marked, covered, hidden)
    fill(plain, covered)
    np.testing.assert_array_equal(marked, plain)
