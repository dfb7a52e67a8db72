# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut a mesh into patches of triangles, each with its neighbours, to process one patch at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .arrays import Floats, Ints

_BITS = 10  # of each coordinate in a Morton number
_LEAST = 16  # a patch with `most` / _LEAST triangles or fewer is not split further


def patches(vertex: Ints, place: Floats, most: int) -> Iterator[tuple[Ints, Ints]]:
    """Cut triangles with vertex indices `vertex` (F, 3) into patches: yields (own, whole).

    Both are ascending triangle indices. Each triangle is in the `own` of exactly one patch; `whole` are the
    own triangles and all that share a vertex with them. `whole` has at most `most` triangles, except where
    very many meet at one vertex. `place` (F, 3) are positions of the triangles; a patch's triangles are
    close.
    """
    order = np.argsort(_along_a_curve(place), kind="stable")
    around = (np.argsort(vertex, axis=None, kind="stable") // 3).astype(np.int32)
    start = np.concatenate([[0], np.cumsum(np.bincount(vertex.ravel()))])
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
    """Morton number (Z-order) of each position (F, 3): (F,), mostly similar for neighbours in space."""
    low, high = place.min(axis=0, initial=np.inf), place.max(axis=0, initial=-np.inf)
    size = np.maximum(high - low, 1e-30)
    cell = np.minimum((place - low) / size * 2**_BITS, 2**_BITS - 1).astype(np.int32)
    number: Ints = np.zeros(len(place), dtype=np.int32)
    for bit in range(_BITS):
        for axis in range(3):
            number = number | (((cell[:, axis] >> bit) & 1) << (3 * bit + axis))
    return number
