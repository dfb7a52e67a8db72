# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from radtex_addon.core import edges, islands, sorted_keys

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
    monkeypatch.setattr(sorted_keys, "AT_ONCE", at_once)
    keys = KINDS[kind]
    assert np.array_equal(sorted_keys.ranks(keys), np.unique(keys, return_inverse=True)[1])
    ranges = list(sorted_keys.sorted_ranges(keys))
    assert np.array_equal(np.concatenate(ranges), np.argsort(keys, kind="stable"))
    assert not any(set(keys[one]) & set(keys[other]) for one, other in pairwise(ranges))


@pytest.mark.parametrize("dtype", ["f4", "f8", "i4", "i8"])
def test_welded_rows_are_numbered_by_their_bytes(dtype: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sorted_keys, "AT_ONCE", 100)
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
    monkeypatch.setattr(sorted_keys, "AT_ONCE", 20)
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
    found = edges.inner_edges(vertex)
    assert np.array_equal(np.concatenate([found.starts, found.ends], axis=1), expected)


def test_areas_in_blocks_are_those_of_all_at_once() -> None:
    chance = np.random.default_rng(6)
    position, triangles = chance.normal(size=(50, 3)), chance.integers(0, 50, (300_000, 3))
    a, b, c = position[triangles].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    expected = np.linalg.norm(cross, axis=1) / 2
    np.testing.assert_allclose(islands.areas_on_surface(position, triangles), expected, rtol=1e-12)
