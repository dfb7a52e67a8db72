# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges of a mesh: which corners of which triangles lie on both sides of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Ints
from .sorted_keys import Keys, sorted_ranges

_HALF = np.uint64(32)  # bits of a key for each of an edge's vertices


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges between two triangles: corner numbers, 0 to 3F, of their starts and of their ends, (E, 2) each.

    A column is of one of the two triangles, whose numbers are those of its corners divided by three.
    """

    starts: Ints
    ends: Ints


def inner_edges(vertex: Ints) -> Edges:
    """The edges that two triangles with vertices (F, 3) share, of all numbers below 2^32: int32 if these fit.

    Edges ascend by their lower vertex, then by the other. Of K triangles at one edge, each makes an edge with
    the next.
    """
    corners = vertex.reshape(-1)
    small = np.int32 if len(corners) <= np.iinfo(np.int32).max else np.int64
    keys = edge_keys(vertex)
    found = []
    for order in sorted_ranges(keys):
        ascending = keys[order]
        same = ascending[1:] == ascending[:-1]
        same &= (ascending[1:] >> _HALF) != (ascending[1:] & np.uint64(0xFFFFFFFF))
        found.append(np.stack([order[:-1][same], order[1:][same]], axis=1).astype(small))
    start = np.concatenate(found)
    end = start + np.where(start % 3 == 2, -2, 1).astype(small)
    turned = corners[start] > corners[end]  # of an edge, both columns run from its lower vertex
    return Edges(np.where(turned, end, start), np.where(turned, start, end))


def edge_keys(vertex: Ints) -> Keys:
    """A number for each edge from corner k to k + 1 of triangles (F, 3), the same either way round: (3F,)."""
    here, there = vertex.astype(np.uint64), np.roll(vertex, -1, axis=1).astype(np.uint64)
    keys = np.minimum(here, there)
    keys <<= _HALF
    keys |= np.maximum(here, there)
    return keys.reshape(-1)
