# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of a mesh that no picture survives: triangles that lie on others, and faces turned inside out."""

from __future__ import annotations

import numpy as np

from .arrays import Bools, Floats, Ints, blocks, sorted_ranges
from .frame import normalised
from .islands import weld
from .surface import edge_keys

_NEXT = 3  # triangles at an edge are compared with so many that follow: with all where two meshes coincide
_ONE_WAY = 1 - 1e-8  # cosine of 0.008 degrees: what lies closer together is one plane
_SHORT = np.uint64(32)  # bits of a vertex in an edge's key


def overlaid(position: Floats, vertex: Ints) -> Bools:
    """Which triangles (F, 3) of vertices `position` (V, 3) lie on others with which they share an edge: (F,).

    They lie in one plane, on the same side of that edge, whichever way they face. Vertices are told apart by
    number: `weld` them first.
    """
    found = np.zeros(len(vertex), dtype=bool)
    keys = edge_keys(vertex)
    for order in sorted_ranges(keys):
        ascending = keys[order]
        for step in range(1, _NEXT + 1):
            same = np.flatnonzero(ascending[step:] == ascending[:-step])
            for some in blocks(len(same)):
                first, second = order[same[some]], order[same[some] + step]
                on = _one_side(position, vertex, first, second)
                found[first[on] // 3] = found[second[on] // 3] = True
    return found


def turned_share(vertex: Ints) -> float:
    """The share of the edges between two triangles (F, 3) along which these face opposite sides."""
    turned, count = 0, 0
    keys, corner = edge_keys(vertex), vertex.reshape(-1)
    for order in sorted_ranges(keys):
        ascending = keys[order]
        start = np.flatnonzero(np.diff(ascending, prepend=ascending[0] + np.uint64(1)))
        pairs = start[np.diff(start, append=len(ascending)) == 2]
        key = ascending[pairs]
        pairs = pairs[(key >> _SHORT) != (key & np.uint64(0xFFFFFFFF))]
        first, second = order[pairs], order[pairs + 1]
        turned += int(np.count_nonzero(corner[first] == corner[second]))
        count += len(pairs)
    return turned / count if count else 0.0


def repeated(vertex: Ints, owner: Ints) -> Bools:
    """Which triangles (F, 3) have an earlier one's corners, in the same direction, and its `owner` (F,)."""
    least = vertex.argmin(axis=1)
    turned = np.take_along_axis(vertex, (least[:, None] + np.arange(3)) % 3, axis=1)
    label = weld(np.column_stack([turned, owner]).astype(np.int64))
    again = np.ones(len(vertex), dtype=bool)
    again[np.unique(label, return_index=True)[1]] = False
    return again


def _one_side(position: Floats, vertex: Ints, first: Ints, second: Ints) -> Bools:
    """Whether triangles lie on each other, by their corners `first` and `second` (N,) at one edge: (N,)."""
    corner = vertex.reshape(-1)
    start, end = (position[corner[some]].astype(np.float64) for some in (first, _following(first)))
    along = normalised(end - start)
    one, other = (
        position[corner[_following(_following(some))]].astype(np.float64) - start for some in (first, second)
    )
    across = [away - (away * along).sum(axis=1, keepdims=True) * along for away in (one, other)]
    found: Bools = (normalised(across[0]) * normalised(across[1])).sum(axis=1) > _ONE_WAY
    return found


def _following(corner: Ints) -> Ints:
    """The next corner of the same triangle."""
    following: Ints = corner + np.where(corner % 3 == 2, -2, 1)
    return following
