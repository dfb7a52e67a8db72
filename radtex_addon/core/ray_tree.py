# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bounding volume hierarchy of triangles, for shaders that trace rays without a stack.

Nodes are in depth-first order. A ray that meets a node's box goes on with the next node; one that misses it
jumps to the node's `skip`, the first one behind its subtree. So a walk visits each node once at most.
Splits minimise the surface area heuristic along the longest axis of the triangles' middles: Wald, "On fast
Construction of SAH-based Bounding Volume Hierarchies", 2007, there with bins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Floats, Ints

IN_LEAF = 4  # the most triangles of a leaf
_BOX_COST = 0.5  # of testing a box, in tests of a triangle


@dataclass(frozen=True, eq=False)
class RayTree:
    """N nodes over F triangles.

    `low`, `high` (N, 3): the boxes; `skip` (N,): the node behind the subtree; `first`, `count` (N,): a
    leaf's triangles in `order`, 0 of them in inner nodes; `order` (F,): the triangles' numbers in the mesh.
    """

    low: Floats
    high: Floats
    skip: Ints
    first: Ints
    count: Ints
    order: Ints


def build_tree(corners: Floats) -> RayTree:
    """The tree of triangles (F, 3, 3), F at least 1."""
    corners = corners.astype(np.float64)
    low, high = corners.min(axis=1), corners.max(axis=1)
    middle = (low + high) / 2
    order = np.arange(len(corners))
    boxes: list[tuple[Floats, Floats]] = []
    facts: list[list[int]] = []  # first, count, skip
    todo: list[tuple[int, int, list[int]]] = [(0, len(corners), [])]  # begin, end, nodes that end here
    while todo:
        begin, end, ending = todo.pop()
        own = order[begin:end]
        number = len(facts)
        boxes.append((low[own].min(axis=0), high[own].max(axis=0)))
        cut = _cut(low[own], high[own], middle[own])
        if cut is None:
            facts.append([begin, end - begin, number + 1])
            for above in ending:
                facts[above][2] = number + 1
            continue
        place, sorted_ = cut
        order[begin:end] = own[sorted_]
        facts.append([0, 0, 0])
        todo.append((begin + place, end, [*ending, number]))
        todo.append((begin, begin + place, []))
    first, count, skip = np.array(facts, dtype=np.int64).T
    return RayTree(
        np.array([box[0] for box in boxes]), np.array([box[1] for box in boxes]), skip, first, count, order
    )


def _cut(low: Floats, high: Floats, middle: Floats) -> tuple[int, Ints] | None:
    """How many triangles go to the first half, and their order; None for a leaf."""
    count = len(middle)
    if count == 1:
        return None
    axis = int(np.argmax(np.ptp(middle, axis=0)))
    ordered = np.argsort(middle[:, axis], kind="stable")
    low, high = low[ordered], high[ordered]
    before = _areas(np.minimum.accumulate(low), np.maximum.accumulate(high))
    behind = _areas(np.minimum.accumulate(low[::-1]), np.maximum.accumulate(high[::-1]))[::-1]
    steps = np.arange(1, count)
    cost = before[:-1] * steps + behind[1:] * (count - steps)
    best = int(np.argmin(cost))
    whole = before[-1]
    if count <= IN_LEAF and cost[best] + 2 * _BOX_COST * whole >= count * whole:
        return None
    if whole <= 0:  # all in one point
        best = count // 2 - 1
    return best + 1, ordered


def _areas(low: Floats, high: Floats) -> Floats:
    """Half the surface of boxes."""
    size = high - low
    areas: Floats = np.sum(size * np.roll(size, 1, axis=1), axis=1)
    return areas
