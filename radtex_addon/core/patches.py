# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh cut into patches, each with all triangles around it, for work that looks no further."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .arrays import Floats, Ints

_BITS = 10  # of a place along each axis, on the curve that patches follow
_LEAST = 16  # a patch is not cut finer than this part of what it may have


def patches(vertex: Ints, place: Floats, most: int) -> Iterator[tuple[Ints, Ints]]:
    """Cut triangles, whose corners (F, 3) are numbered vertices from 0 on, into patches: yields (own, whole).

    Both are rising numbers of triangles. Each triangle is among one patch's `own`; `whole` are these and
    those that share a vertex with them, `most` of them but for where far more meet at one vertex. `place`
    (F, 3) says where triangles are, so that a patch's lie together.
    """
    order = np.argsort(_along_a_curve(place), kind="stable")
    corner = np.argsort(vertex, axis=None, kind="stable")
    around, start = corner // 3, np.concatenate([[0], np.cumsum(np.bincount(vertex.ravel()))])
    left = np.array_split(order, max(1, -(-len(order) // max(1, 3 * most // 4))))[::-1]
    while left:
        piece = left.pop()
        own = np.sort(piece)
        met = np.unique(vertex[own])
        counts = start[met + 1] - start[met]
        first = np.repeat(start[met] - np.cumsum(counts) + counts, counts)
        whole = np.unique(around[first + np.arange(len(first))])
        if len(whole) > most and len(own) > max(1, most // _LEAST):
            left += np.array_split(piece, 2)
        else:
            yield own, whole


def _along_a_curve(place: Floats) -> Ints:
    """Morton's number of each place (F, 3): neighbours in space are mostly near in it, (F,)."""
    low, high = place.min(axis=0, initial=np.inf), place.max(axis=0, initial=-np.inf)
    size = np.maximum(high - low, 1e-30)
    cell = np.minimum((place - low) / size * 2**_BITS, 2**_BITS - 1).astype(np.int64)
    number: Ints = np.zeros(len(place), dtype=np.int64)
    for bit in range(_BITS):
        for axis in range(3):
            number = number | (((cell[:, axis] >> bit) & 1) << (3 * bit + axis))
    return number
