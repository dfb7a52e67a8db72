# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles that lie on others, and faces turned inside out, of a box whose corners are numbered."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Ints
from radtex_addon.core.mesh_faults import overlaid, repeated, turned_share

PLACE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float32)
QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def triangles(quads: Ints) -> Ints:
    """Two of each quad, cut from its first corner."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


BOX = triangles(QUADS)


@pytest.mark.parametrize(
    ("other", "again"),
    [
        (BOX, True),
        (np.roll(BOX, 1, axis=1), True),
        (BOX[:, ::-1], False),
        (triangles(np.roll(QUADS, 1, axis=1)), False),
        (triangles(np.roll(QUADS[:, ::-1], 1, axis=1)), False),
    ],
    ids=["copied", "from another corner", "turned", "cut otherwise", "turned and cut otherwise"],
)
def test_what_lies_on_another_is_found_however_it_is_cut(other: Ints, again: bool) -> None:
    both = np.concatenate([BOX, other])
    assert overlaid(PLACE, both).all()
    found = repeated(both, np.zeros(24, dtype=int))
    assert not found[:12].any()
    assert (found[12:] == again).all()
    assert not repeated(both, np.arange(24)).any()


def test_a_part_that_is_there_twice_is_told_apart_and_walls_at_an_edge_are_none() -> None:
    assert not overlaid(PLACE, BOX).any()
    assert not repeated(BOX, np.zeros(12, dtype=int)).any()
    both = np.concatenate([BOX, BOX[:3]])
    np.testing.assert_array_equal(np.flatnonzero(overlaid(PLACE, both)), [0, 1, 2, 12, 13, 14])
    fan = [(np.cos(turn), np.sin(turn), 0.5) for turn in np.radians([0, 0.1, 90, 200, 270])]
    place = np.array([(0, 0, 0), (0, 0, 1), *fan])
    assert not overlaid(place, np.array([(0, 1, 2 + number) for number in range(5)])).any()


@pytest.mark.parametrize("turned", [0, 1, 6])
def test_faces_that_are_turned_show_at_their_edges(turned: int) -> None:
    """A quad that is turned changes four of the 18 edges of a box's triangles; if all are, none changes."""
    quads = QUADS.copy()
    quads[:turned] = quads[:turned, ::-1]
    assert turned_share(triangles(quads)) == pytest.approx({0: 0, 1: 4 / 18, 6: 0}[turned])
