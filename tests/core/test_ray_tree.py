# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees of triangles: whole, tight, and walked in one direction."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.ray_tree import IN_LEAF, RayTree, build_tree
from tests.reference.traced import random_rays, random_surface


def visited(tree: RayTree, origin: Floats, ray: Floats) -> int:
    """How many nodes a ray visits that meets nothing."""
    count = node = 0
    while node < len(tree.skip):
        count += 1
        with np.errstate(divide="ignore", invalid="ignore"):
            planes = np.stack([tree.low[node] - origin, tree.high[node] - origin]) / ray
        near, far = np.nanmin(planes, axis=0).max(), np.nanmax(planes, axis=0).min()
        node = node + 1 if max(near, 0) <= far else int(tree.skip[node])
    return count


def test_each_triangle_lies_in_one_leaf_and_in_all_boxes_above_it() -> None:
    corners = random_surface().corner_position
    tree = build_tree(corners)
    assert sorted(tree.order) == list(range(len(corners)))
    assert tree.count.max() <= IN_LEAF
    assert tree.count.sum() == len(corners)
    assert (tree.skip > np.arange(len(tree.skip))).all()
    leaves = np.nonzero(tree.count)[0]
    for node in range(len(tree.skip)):
        inside = leaves[(leaves >= node) & (leaves < tree.skip[node])]
        assert len(inside)
        own = np.concatenate([tree.order[tree.first[k] : tree.first[k] + tree.count[k]] for k in inside])
        assert np.allclose(corners[own].min(axis=(0, 1)), tree.low[node])
        assert np.allclose(corners[own].max(axis=(0, 1)), tree.high[node])


def test_a_ray_visits_a_part_of_the_nodes() -> None:
    tree = build_tree(random_surface().corner_position)
    origins, rays = random_rays()
    counts = [visited(tree, origin, ray) for origin, ray in zip(origins[:200], rays[:200], strict=True)]
    assert np.mean(counts) < 0.25 * len(tree.skip)


@pytest.mark.parametrize("faces", [1, 2, 3, 50])
def test_triangles_in_one_place_make_a_tree(faces: int) -> None:
    tree = build_tree(np.zeros((faces, 3, 3)))
    assert tree.count.sum() == faces
    assert tree.skip[0] == len(tree.skip)
