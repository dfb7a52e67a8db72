# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A condensed lobe's texels are mixtures of their clusters' buckets, and what does not fit is refused."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from radtex_addon.core.errors import ShapeError
from radtex_addon.core.shared import Axis
from tests.shared_atlases import random_condensed_atlas

PARTS = ("ends", "gain", "rest")


@pytest.mark.parametrize("rank", [2, 6])
@pytest.mark.parametrize("clusters", [1, 4, 60])
def test_a_texel_is_its_clusters_first_bucket_and_shares_of_the_others(clusters: int, rank: int) -> None:
    """Of 60 clusters some have none of the 35 texels."""
    for lobe in random_condensed_atlas(7, 5, clusters, rank, 6).lobes:
        expanded = lobe.expanded()
        assert (expanded.axis, lobe.rank) == (lobe.axis, rank)
        for part in PARTS:
            base, mixed = getattr(lobe, part), getattr(expanded, part)
            assert mixed.dtype == np.float32
            for j, i in np.ndindex(5, 7):
                own = base[lobe.cluster[j, i]].astype(float)
                expected = own[0] + sum(lobe.weights[j, i, k] * own[k + 1] for k in range(rank))
                np.testing.assert_allclose(mixed[j, i], expected, rtol=2e-6, atol=1e-6, err_msg=part)


def test_without_weights_each_texel_is_its_clusters_first_bucket() -> None:
    lobe = random_condensed_atlas(4, 3, 12).lobes[0]
    own = np.arange(12, dtype=np.int32).reshape(3, 4)
    expanded = replace(lobe, cluster=own, weights=np.zeros_like(lobe.weights)).expanded()
    for part in PARTS:
        np.testing.assert_array_equal(getattr(expanded, part), getattr(lobe, part)[own, 0])


def test_the_other_maps_stay_as_they_are() -> None:
    atlas = random_condensed_atlas()
    expanded = atlas.expanded()
    assert [lobe.axis for lobe in expanded.lobes] == list(Axis)
    for field in fields(atlas):
        if field.name != "lobes":
            assert getattr(expanded, field.name) is getattr(atlas, field.name)


def zeros(*shape: int) -> Any:
    return np.zeros(shape, dtype=np.float32)


@pytest.mark.parametrize(
    ("part", "value", "message"),
    [
        (
            "weights",
            zeros(5, 7, 3),
            r"expected shapes \(H, W\) and \(H, W, 2\), got \(5, 7\) and \(5, 7, 3\)",
        ),
        ("weights", zeros(7, 5, 2), r"got \(5, 7\) and \(7, 5, 2\)"),
        ("cluster", np.zeros(35, np.int32), r"got \(35,\) and \(5, 7, 2\)"),
        (
            "ends",
            zeros(4, 3, 14, 12, 4),
            r"ends: expected shape \(C, 1 \+ r, n, n, 4\), got \(4, 3, 14, 12, 4\)",
        ),
        ("ends", zeros(4, 3, 14, 14, 3), r"ends: expected shape .*, got \(4, 3, 14, 14, 3\)"),
        (
            "gain",
            zeros(3, 3, 14, 14, 3),
            r"gain: expected shape \(C, 1 \+ r, n, n, 3\), got \(3, 3, 14, 14, 3\)",
        ),
        ("rest", zeros(4, 2, 14, 14, 3), r"rest: expected shape .*, got \(4, 2, 14, 14, 3\)"),
        ("cluster", np.full((5, 7), 4, np.int32), "cluster: expected 0 to 3"),
        ("cluster", np.full((5, 7), -1, np.int32), "cluster: expected 0 to 3"),
    ],
)
def test_what_does_not_fit_is_refused(part: str, value: Any, message: str) -> None:
    lobe = random_condensed_atlas(lobes=[Axis.THROUGH]).lobes[0]
    with pytest.raises(ShapeError, match=f"through .*{message}"):
        replace(lobe, **{part: value})


def test_an_expanded_atlas_must_fit_itself() -> None:
    atlas = random_condensed_atlas()
    with pytest.raises(ShapeError, match=r"mirror ends: shape .* does not fit the other maps"):
        replace(atlas, irradiance=zeros(4, 7, 3)).expanded()
