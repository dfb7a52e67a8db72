# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radtex_addon.core import islands
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import ShapeError

LOWER, UPPER = [(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]


def square(x: float, y: float, side: float, turned: bool = False) -> Floats:
    """Two triangles, clockwise if turned: (2, 3, 2)."""
    corners = np.array([LOWER, UPPER], dtype=np.float32) * side + [x, y]
    return corners[:, ::-1] if turned else corners


def tiling(cells: int) -> Floats:
    """A grid of squares, its inner corners shaken, that covers the unit square: (2 cells², 3, 2)."""
    rng = np.random.default_rng(5)
    lattice = np.stack(np.meshgrid(*[np.arange(cells + 1)] * 2, indexing="xy"), axis=-1).astype(np.float64)
    lattice[1:-1, 1:-1] += rng.uniform(-0.2, 0.2, (cells - 1, cells - 1, 2))
    lattice = (lattice / cells).astype(np.float32)
    a, b, c, d = lattice[:-1, :-1], lattice[:-1, 1:], lattice[1:, 1:], lattice[1:, :-1]
    return np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 2)


def test_welding_joins_equal_rows_only_and_both_zeros() -> None:
    rows = np.array([[0.0, 1.0], [-0.0, 1.0], [0.0, 1.0 + 1e-15], [0.0, 1.0]])
    label = islands.weld(rows)
    assert label[0] == label[1] == label[3] != label[2]
    assert sorted(set(label)) == [0, 1]
    with pytest.raises(ShapeError):
        islands.weld(np.zeros(3))


@pytest.mark.parametrize(("nodes", "pairs"), [(1, 0), (50, 20), (300, 300), (2000, 1900)])
def test_components_are_those_of_the_graph(nodes: int, pairs: int) -> None:
    edges = np.random.default_rng(nodes).integers(0, nodes, (pairs, 2))
    count, expected = connected_components(coo_array((np.ones(pairs), edges.T), shape=(nodes, nodes)))
    found = islands.components(edges, nodes)
    assert found.max() + 1 == count
    assert len(np.unique(np.stack([found, expected]), axis=1).T) == count


def test_a_long_chain_is_one_component() -> None:
    order = np.random.default_rng(0).permutation(5000)
    assert islands.components(np.stack([order[:-1], order[1:]], axis=1), 5000).max() == 0


def test_a_seam_in_uv_parts_islands_and_a_shared_place_of_two_vertices_does_not_join_them() -> None:
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]])
    whole = np.array([LOWER, UPPER, LOWER], dtype=np.float32)
    assert islands.uv_islands(triangles, whole).tolist() == [0, 0, 1]
    torn = whole.copy()
    torn[1] += 2
    assert len(set(islands.uv_islands(triangles, torn))) == 3


def test_areas() -> None:
    assert islands.signed_areas(square(0, 0, 2)) == pytest.approx([2, 2])
    assert islands.signed_areas(square(0, 0, 2, turned=True)) == pytest.approx([-2, -2])
    corners = np.array([[[0, 0, 0], [3, 0, 0], [0, 0, 4]]], dtype=np.float64)
    assert islands.surface_areas(corners) == pytest.approx([6])


@pytest.mark.parametrize("cells", [1, 3, 40, 400])
def test_neighbours_do_not_overlap(cells: int) -> None:
    """However finely the square is cut, shared edges and corners count once, or not at all."""
    uv = tiling(cells)
    depth = islands.coverage_depth(uv, 512)
    assert depth.max() == 1
    assert np.mean(depth) > 0.99
    assert islands.find_overlap(uv).fraction == 0


@pytest.mark.parametrize("turned", [False, True])
def test_overlap_is_a_share_of_the_covered_area(turned: bool) -> None:
    uv = np.concatenate([square(0, 0, 0.5), square(0.25, 0, 0.5, turned)])
    overlap = islands.find_overlap(uv)
    assert overlap.fraction == pytest.approx(0.125 / 0.375, abs=2e-3)
    u, v = overlap.worst_uv
    assert 0.25 < u < 0.5
    assert 0 < v < 0.5
    assert overlap.depth == 2


def test_the_worst_place_is_the_deepest() -> None:
    uv = np.concatenate([square(0, 0, 0.5)] * 2 + [square(0.7, 0.7, 0.1)] * 4)
    overlap = islands.find_overlap(uv)
    assert overlap.depth == 4
    assert min(overlap.worst_uv) > 0.7
    assert overlap.fraction == 1


def test_depth_is_that_of_every_triangle_on_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the plain definition: each sample point asked of each triangle; also in small portions."""
    rng = np.random.default_rng(1)
    uv = rng.uniform(-0.3, 1.3, (60, 3, 2))
    grid = (np.arange(48) + 0.5) / 48
    points = np.stack(np.meshgrid(grid, grid), axis=-1)[None]
    a, b, c = (uv[:, k, None, None] for k in range(3))
    pairs = [(end - start, points - start) for start, end in ((a, b), (b, c), (c, a))]
    edges = [d[..., 0] * p[..., 1] - d[..., 1] * p[..., 0] for d, p in pairs]
    inside = np.all(np.array(edges) > 0, axis=0) | np.all(np.array(edges) < 0, axis=0)
    expected = inside.sum(axis=0)
    assert np.array_equal(islands.coverage_depth(uv, 48), expected)
    monkeypatch.setattr(islands, "ROWS_AT_ONCE", 7)
    assert np.array_equal(islands.coverage_depth(uv, 48), expected)


def test_triangles_without_area_cover_nothing() -> None:
    uv = np.array([[(0.1, 0.1), (0.9, 0.9), (0.5, 0.5)], [(0.5, 0.5)] * 3, [(0, 0.5), (1, 0.5), (0.2, 0.5)]])
    assert islands.find_overlap(uv).depth == 0
    assert islands.find_overlap(uv).fraction == 0
