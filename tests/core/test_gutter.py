# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gutter: exact distances, agreed ties, and copies of nothing but covered texels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as arrays
from scipy.ndimage import distance_transform_edt

from radtex_addon.bake.hidden_cells import fill_missing
from radtex_addon.core.arrays import Bools, Ints
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError, ShapeError
from radtex_addon.core.gutter import (
    LEAST_AGREEMENT,
    covered_in_coarser,
    dilate,
    gutter_agreement,
    nearest_covered,
)
from radtex_addon.textures.flat_lightmap import mean_of_buckets

masks = arrays.arrays(np.bool_, arrays.array_shapes(min_dims=2, max_dims=2, max_side=14)).filter(np.any)


def brute_force(covered: Bools) -> tuple[Ints, Ints]:
    """Nearest covered texel by looking at all of them, in the order of columns, then rows."""
    i_all, j_all = np.nonzero(covered.T)
    texel = np.indices(covered.shape)[..., None]
    squared = (texel[0] - j_all) ** 2 + (texel[1] - i_all) ** 2
    first = squared.argmin(axis=-1)
    return j_all[first], i_all[first]


@given(masks)
def test_the_nearest_texel_and_its_ties_are_those_of_a_full_search(covered: Bools) -> None:
    np.testing.assert_array_equal(nearest_covered(covered), brute_force(covered))


@pytest.mark.parametrize("share", [0.5, 0.02, 0.0002])
@pytest.mark.parametrize("shape", [(257, 190), (64, 400)])
def test_distances_are_scipys(share: float, shape: tuple[int, int]) -> None:
    covered = np.random.default_rng(1).uniform(size=shape) < share
    covered[3, 5] = True
    j, i = nearest_covered(covered)
    assert j.dtype == i.dtype == np.int32
    assert covered[j, i].all()
    rows, columns = np.indices(shape)
    distance = distance_transform_edt(~covered)
    np.testing.assert_array_equal((j - rows) ** 2 + (i - columns) ** 2, np.rint(distance**2))


def test_dilation_copies_buckets_in_place_and_leaves_covered_ones_alone() -> None:
    """Also in views, such as an atlas that is cut into buckets."""
    rng = np.random.default_rng(2)
    covered = rng.uniform(size=(12, 17)) < 0.2
    image = rng.uniform(size=(48, 68, 3)).astype(np.float32)
    buckets = image.reshape(12, 4, 17, 4, 3).transpose(0, 2, 1, 3, 4)
    buckets[~covered] = np.nan
    before, nearest = buckets.copy(), nearest_covered(covered)
    assert dilate(buckets, nearest) is buckets
    np.testing.assert_array_equal(buckets[covered], before[covered])
    np.testing.assert_array_equal(buckets, before[nearest])
    assert np.isfinite(image).all()


def test_wrong_shapes_are_refused_and_nothing_covered_is_the_users_error() -> None:
    with pytest.raises(InputError, match="covers no texel"):
        nearest_covered(np.zeros((3, 3), dtype=bool))
    with pytest.raises(ShapeError, match="covered"):
        nearest_covered(np.ones(3, dtype=bool))
    with pytest.raises(ShapeError, match="values"):
        dilate(np.zeros((3, 4)), nearest_covered(np.ones((4, 3), dtype=bool)))


def test_a_coarser_texel_is_covered_where_a_finer_one_is() -> None:
    covered = np.zeros((5, 4), dtype=bool)
    covered[0, 3] = covered[4, 0] = True  # the fifth row belongs to the second of two
    assert covered_in_coarser(covered, (2, 2), 2).tolist() == [[False, True], [True, False]]
    assert covered_in_coarser(covered, covered.shape, 1).tolist() == covered.tolist()


@pytest.mark.parametrize("rim", [0, 1, 3], ids="{} texels unseen".format)
def test_gutters_agree_with_their_own_layer_alone_whatever_nobody_sees_of_it(rim: int) -> None:
    covered = np.zeros((64, 64), dtype=bool)
    covered[4:20, 4:30] = covered[26:60, 8:22] = covered[30:56, 36:58] = True
    seen = covered.copy()
    for _ in range(rim):  # as leaves whose rims are cut out
        seen &= np.roll(seen, 1, 0) & np.roll(seen, -1, 0) & np.roll(seen, 1, 1) & np.roll(seen, -1, 1)
    values = dilate(np.random.default_rng(1).random((64, 64, 3)).astype(np.float32), nearest_covered(seen))
    others = [covered.T, covered[::-1], *(np.roll(covered, rim + 2, axis=axis) for axis in (0, 1))]
    found = [gutter_agreement(other, values) for other in others]
    print(rim, gutter_agreement(covered, values), found)
    assert gutter_agreement(covered, values) == 1
    assert max(found) < LEAST_AGREEMENT


def test_gutters_of_cells_agree_though_each_lacks_other_texels() -> None:
    covered = np.zeros((64, 64), dtype=bool)
    covered[4:20, 4:30] = covered[26:60, 8:22] = covered[30:56, 36:58] = True
    random = np.random.default_rng(2)
    hidden = (random.random((64, 64, 8, 8)) < 0.7) & covered[..., None, None]
    buckets = random.random((64, 64, 8, 8, 3)).astype(np.float32)
    for _ in fill_missing(buckets, covered, hidden):
        pass
    layout = AtlasLayout(64, 64, 8)
    image = layout.from_buckets(buckets)
    cells = layout.some_cells(image)
    assert cells.shape == (64, 64, 5, 3)
    assert (
        gutter_agreement(covered, mean_of_buckets(image, layout), 1e-4) < LEAST_AGREEMENT
    )  # why cells are asked
    assert gutter_agreement(covered, cells) == 1
    assert gutter_agreement(covered.T, cells) < LEAST_AGREEMENT
