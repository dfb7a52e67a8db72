# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Streams of EXT_meshopt_compression, read by the specification's own steps."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.codecs.meshopt import (
    Indices,
    encode_triangles,
    encode_vertices,
    exponential,
    from_octahedral,
    octahedral,
    triangle_order,
)
from tests.reference.meshopt import attributes, triangles, unfiltered


def grid(side: int) -> Indices:
    """The triangles of a grid of so many squares, numbered row by row."""
    row, column = np.divmod(np.arange(side * side), side)
    corner = row * (side + 1) + column
    low = np.stack([corner, corner + 1, corner + side + 2], axis=1)
    high = np.stack([corner, corner + side + 2, corner + side + 1], axis=1)
    return np.concatenate([low, high])


def numbered(found: Indices) -> Indices:
    """Vertices numbered as they are met."""
    met, first = np.unique(found, return_index=True)
    number = np.zeros(found.max() + 1, np.int64)
    number[met[np.argsort(first)]] = np.arange(len(met))
    return number[found]


def same(one: Indices, other: Indices) -> bool:
    """Whether these are the same triangles in this order, each begun at any of its corners."""
    turns = np.stack([np.roll(other, turn, axis=1) for turn in range(3)])
    return bool((turns == one).all(axis=2).any(axis=0).all())


@pytest.mark.parametrize(("count", "stride"), [(1, 4), (15, 8), (16, 12), (257, 12), (1000, 16), (100, 256)])
def test_vertices_come_back(count: int, stride: int) -> None:
    """Of all ways in which a group can be stored, and with a last block that is not full."""
    rng = np.random.default_rng(count)
    steps = rng.integers(-1, 2, (count, stride)) * rng.integers(0, 4, (1, stride)) ** 3
    rows = np.cumsum(steps, axis=0).astype(np.uint8)
    rows[:, 0] = rng.integers(0, 256, count)
    stream = encode_vertices(rows)
    np.testing.assert_array_equal(attributes(stream, count, stride), rows)


def test_smooth_vertices_take_few_bytes() -> None:
    rows = np.linspace(0, 200, 4096).astype(np.uint8)[:, None].repeat(8, axis=1)
    assert len(encode_vertices(rows)) < rows.size / 3


def test_triangles_come_back_in_whatever_order() -> None:
    rng = np.random.default_rng(1)
    for found in (grid(20), rng.integers(0, 40, (500, 3)), rng.integers(0, 90000, (300, 3)), grid(1)):
        for each in (found, numbered(found), numbered(triangle_order(found))):
            assert same(triangles(encode_triangles(each), len(each)), each)


def test_neighbours_in_a_row_take_about_a_byte_each() -> None:
    rng = np.random.default_rng(2)
    shuffled = rng.permutation(grid(60))
    ordered = triangle_order(shuffled)
    assert sorted(map(sorted, ordered.tolist())) == sorted(map(sorted, shuffled.tolist()))
    assert same(ordered, ordered)
    turned = {tuple(np.roll(each, -int(each.argmin()))) for each in ordered}
    assert turned == {tuple(np.roll(each, -int(each.argmin()))) for each in shuffled}, "none is mirrored"
    assert len(encode_triangles(numbered(ordered))) < 1.25 * len(ordered)
    assert len(encode_triangles(numbered(shuffled))) > 2 * len(ordered)


def unit_vectors() -> Floats:
    rng = np.random.default_rng(3)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    vectors = np.concatenate([axes, rng.normal(size=(50000, 3))])
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


@pytest.mark.parametrize(("bits", "degrees"), [(12, 0.06), (15, 0.009)])
def test_directions_on_an_octahedron(bits: int, degrees: float) -> None:
    vectors = unit_vectors()
    signs = np.where(np.arange(len(vectors)) % 2, 1.0, -1.0)
    told = octahedral(vectors, bits, signs)
    read = from_octahedral(told)
    np.testing.assert_array_equal(unfiltered(told.view(np.uint8), "OCTAHEDRAL").view("<i2"), read)
    np.testing.assert_array_equal(read[:, 3], signs * 32767)
    again = octahedral(read[:, :3] / 32767, bits, signs)
    np.testing.assert_array_equal(from_octahedral(again), read)
    away = np.linalg.norm(read[:, :3] / 32767 - vectors, axis=1)
    assert np.degrees(away.max()) < degrees


def test_places_on_a_grid_are_exact() -> None:
    whole = np.random.default_rng(4).integers(-(2**22), 2**22, (500, 3))
    rows = exponential(whole, -17).view(np.uint8)
    np.testing.assert_array_equal(unfiltered(rows, "EXPONENTIAL").view("<f4"), whole * 2.0**-17)
