# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels' numbers of samples as a line of text, there and back."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.errors import FormatError
from radtex_addon.formats.sample_counts import count_text, read_counts


def test_runs_go_row_after_row_from_the_bottom() -> None:
    counts = np.array([[8, 8, 8], [8, 24, 24], [8, 8, 2**24 * 1000]])
    assert count_text(counts) == "8x4 24x2 8x2 16777216000x1"
    assert not count_text(np.full((4, 5), 16))  # equal ones need no words
    for each in (counts, np.random.default_rng(1).integers(1, 4, (37, 53))):
        np.testing.assert_array_equal(read_counts(count_text(each), *each.shape[::-1], "here"), each)


@pytest.mark.parametrize("text", ["", "8x4", "8x10", "0x9", "8x4,24x5", "8x4  24x5", "-8x9", "8x0 8x9"])
def test_what_does_not_fit_is_refused(text: str) -> None:
    with pytest.raises(FormatError, match=r'a\.json has a "texel_samples" that does not tell 3 x 3 texels'):
        read_counts(text, 3, 3, "a.json")
