# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Slices: the same cells in other places, mip levels that shift and lose nothing."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.slices import to_slices
from tests.lookups import LAYOUT, random_atlas
from tests.reference.levels import level_chain
from tests.reference.slices import from_slices, mip_chain

ATLAS = random_atlas().astype(np.float64)


def test_a_layer_holds_one_cell_of_all_texels() -> None:
    slices = to_slices(ATLAS, LAYOUT)
    i, j, p, q = 11, 5, 4, 2
    assert slices.shape == (36, 7, 13, 4)
    assert (slices[q * 6 + p, j, i] == ATLAS[j * 6 + q, i * 6 + p]).all()
    assert (from_slices(slices) == ATLAS).all()


def test_levels_have_floored_sizes_and_one_mean() -> None:
    chain = mip_chain(to_slices(ATLAS, LAYOUT))
    assert [level.shape[1:3] for level in chain] == [(7, 13), (3, 6), (1, 3), (1, 1)]
    for level in chain:
        np.testing.assert_allclose(level.mean(axis=(1, 2)), chain[0].mean(axis=(1, 2)), rtol=1e-12)


def test_odd_sizes_weigh_three_pixels_by_their_overlap() -> None:
    """Of five pixels the first of two covers 2.5: two wholly and half the third."""
    line = np.array([1.0, 2, 4, 8, 16]).reshape(1, 1, 5, 1)
    np.testing.assert_allclose(
        mip_chain(line)[1].ravel(), [(1 + 2 + 2) / 2.5, (2 + 8 + 16) / 2.5], rtol=1e-15
    )


def test_levels_are_those_of_the_matrix_where_nothing_is_odd() -> None:
    layout = AtlasLayout(8, 4, 6)
    atlas = ATLAS[: 4 * 6, : 8 * 6]
    chain = mip_chain(to_slices(atlas, layout))
    for level, image in enumerate(level_chain(atlas, layout, 3)):
        half = AtlasLayout(8 >> level, 4 >> level, 6)
        np.testing.assert_allclose(to_slices(image, half), chain[level], rtol=1e-14)


def test_wrong_shapes_are_named() -> None:
    with pytest.raises(ShapeError, match="2116 layers"):
        to_slices(np.zeros((46, 46, 1)), AtlasLayout(1, 1, 46))
    with pytest.raises(ShapeError, match=r"\(n\*n, H, W, C\)"):
        from_slices(np.zeros((5, 2, 2, 1)))
    with pytest.raises(ShapeError, match=r"\(n\*n, H, W, C\)"):
        from_slices(np.zeros((4, 2, 2)))
