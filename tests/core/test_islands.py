# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Islands and patches of triangles, their overlap and areas, and the sorting that finds them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from radtex_addon.core import arrays, islands, surface
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.errors import ShapeError
from radtex_addon.core.surface import patches

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
def test_overlap_is_a_share_of_the_covered_area_and_worst_where_it_is_deepest(turned: bool) -> None:
    uv = np.concatenate([square(0, 0, 0.5), square(0.25, 0, 0.5, turned)])
    overlap = islands.find_overlap(uv)
    assert overlap.fraction == pytest.approx(0.125 / 0.375, abs=2e-3)
    u, v = overlap.worst_uv
    assert 0.25 < u < 0.5
    assert 0 < v < 0.5
    assert overlap.depth == 2
    overlap = islands.find_overlap(np.concatenate([square(0, 0, 0.5)] * 2 + [square(0.7, 0.7, 0.1)] * 4))
    assert (overlap.depth, overlap.fraction) == (4, 1)
    assert min(overlap.worst_uv) > 0.7
    line = np.array(
        [[(0.1, 0.1), (0.9, 0.9), (0.5, 0.5)], [(0.5, 0.5)] * 3, [(0, 0.5), (1, 0.5), (0.2, 0.5)]]
    )
    assert (islands.find_overlap(line).depth, islands.find_overlap(line).fraction) == (0, 0)


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


CHANCE = np.random.default_rng(3)
KINDS = {
    "many equal": CHANCE.integers(0, 50, 5000, dtype=np.uint64),
    "one": np.full(3000, 7, dtype=np.uint64),
    "all 64 bits": CHANCE.integers(0, 2**64 - 1, 5000, dtype=np.uint64),
    "none": np.zeros(0, dtype=np.uint64),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("at_once", [10, 1000, 1 << 20])
def test_ranks_are_those_of_numpy_however_many_are_sorted_at_once(
    kind: str, at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrays, "AT_ONCE", at_once)
    keys = KINDS[kind]
    assert np.array_equal(arrays.ranks(keys), np.unique(keys, return_inverse=True)[1])
    ranges = list(arrays.sorted_ranges(keys))
    assert np.array_equal(np.concatenate(ranges), np.argsort(keys, kind="stable"))
    assert not any(set(keys[one]) & set(keys[other]) for one, other in pairwise(ranges))


@pytest.mark.parametrize("dtype", ["f4", "f8", "i4", "i8"])
def test_welded_rows_are_numbered_by_their_bytes(dtype: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arrays, "AT_ONCE", 100)
    rows = (np.random.default_rng(1).normal(size=(2000, 3)) * 4).round().astype(dtype)
    order = np.unique([row.tobytes() for row in rows + rows.dtype.type(0)], return_inverse=True)[1]
    assert np.array_equal(islands.weld(rows), order)


def test_first_and_index_are_those_of_numpy() -> None:
    labels = np.random.default_rng(2).integers(0, 300, (80, 3)) * 2
    _, first, index = np.unique(labels, return_index=True, return_inverse=True)
    found = islands.first_and_index(labels)
    assert np.array_equal(found[0], first)
    assert np.array_equal(found[1], index.reshape(-1))


def test_edges_pair_each_triangle_with_the_next_one_at_the_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arrays, "AT_ONCE", 20)
    vertex = np.random.default_rng(4).integers(0, 20, (200, 3))
    at_edge: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for corner, start in enumerate(vertex.ravel().tolist()):
        following = corner + 1 if corner % 3 < 2 else corner - 2
        end = int(vertex.ravel()[following])
        if start != end:
            ends = (corner, following) if start < end else (following, corner)
            at_edge.setdefault((min(start, end), max(start, end)), []).append(ends)
    expected = [
        (one[0], other[0], one[1], other[1])
        for _, some in sorted(at_edge.items())
        for one, other in pairwise(some)
    ]
    found = surface.inner_edges(vertex)
    assert np.array_equal(np.concatenate([found.starts, found.ends], axis=1), expected)


def test_areas_in_blocks_are_those_of_all_at_once() -> None:
    chance = np.random.default_rng(6)
    position, triangles = chance.normal(size=(50, 3)), chance.integers(0, 50, (300_000, 3))
    a, b, c = position[triangles].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    expected = np.linalg.norm(cross, axis=1) / 2
    np.testing.assert_allclose(islands.areas_on_surface(position, triangles), expected, rtol=1e-12)


def grid(side: int) -> tuple[Ints, Floats]:
    """A sheet of 2 side² triangles in no order, and their middles."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    corner = (y * (side + 1) + x).ravel()
    lower = np.stack([corner, corner + 1, corner + side + 1], axis=1)
    upper = np.stack([corner + 1, corner + side + 2, corner + side + 1], axis=1)
    triangles = np.random.default_rng(1).permutation(np.concatenate([lower, upper]))
    place = np.stack([triangles % (side + 1), triangles // (side + 1), 0 * triangles], axis=-1).mean(axis=1)
    return triangles, place


@pytest.mark.parametrize("most", [40, 300, 10_000])
def test_each_triangle_is_one_patchs_own_and_has_its_neighbours(most: int) -> None:
    triangles, place = grid(20)
    found = list(patches(triangles, place, most))
    assert sorted(np.concatenate([own for own, _ in found])) == list(range(len(triangles)))
    for own, whole in found:
        around = np.isin(triangles, triangles[own]).any(axis=1)
        assert np.array_equal(whole, np.flatnonzero(around))
        assert len(whole) <= most
    assert (len(found) == 1) == (most >= len(triangles))


def test_a_fan_is_not_cut_to_bits() -> None:
    count = 1000
    rim = np.arange(count)
    fan = np.stack([np.full(count, count), rim, (rim + 1) % count], axis=1)
    angle = 2 * np.pi * rim / count
    place = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    found = list(patches(fan, place, 320))
    assert len(found) <= 2 * count / (320 / 16)
    assert all(len(whole) == count for _, whole in found)
