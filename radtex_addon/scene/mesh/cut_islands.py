# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut flat islands that leave much of their bounding box empty, as curved strips do: they pack badly."""

from __future__ import annotations

import math

import numpy as np

from ...core.arrays import Floats, Ints
from ...core.islands import signed_areas, split_corners, triangle_islands

_FILLED = 0.5  # share of its smallest bounding box that an island fills: more is compact
_LONG = 0.3  # times the root of all islands' area: shorter islands find a place anyway
_FEWEST = 8  # triangles of an island worth cutting
_ANGLES = 30  # tried in a quarter turn, to find the smallest box
_SAMPLED = 1000  # points of an island that its box is found by


def cut_once(triangles: Ints, uv: Floats, island: Ints) -> Ints | None:
    """Cut each long island that fills little of its box in two, across its length: new island numbers (F,).

    `triangles` (F, 3) are vertex numbers, `uv` (F, 3, 2) flat and to scale; an `island` (F,) of -1 is none.
    None if no island is worth a cut. Pieces that do not hang together become islands of their own.
    """
    area = np.abs(signed_areas(uv))
    order = np.argsort(island, kind="stable")
    count = int(island.max(initial=-1)) + 1
    begins = np.searchsorted(island[order], np.arange(count + 1))
    whole = math.sqrt(float(area[island >= 0].sum()))
    found = island.copy()
    following = count
    for number in range(count):
        some = order[begins[number] : begins[number + 1]]
        if len(some) < _FEWEST:
            continue
        half = _halves(uv[some], area[some], whole)
        if half is None:
            continue
        found[some] = following + triangle_islands(split_corners(triangles[some], half))
        following = int(found[some].max()) + 1
    return None if following == count else found


def _halves(uv: Floats, area: Floats, whole: float) -> Ints | None:
    """On which side of a cut through half of its area each triangle lies (F,), None if it needs no cut."""
    points = uv.reshape(-1, 2)
    sample = points[:: max(len(points) // _SAMPLED, 1)]
    turn = np.arange(_ANGLES) * (math.pi / 2 / _ANGLES)
    axes = np.stack([np.cos(turn), np.sin(turn), -np.sin(turn), np.cos(turn)], axis=1).reshape(-1, 2, 2)
    sizes = np.ptp(np.einsum("axc,pc->apx", axes, sample), axis=1)
    best = int(np.argmin(sizes.prod(axis=1)))
    box = sizes[best]
    if area.sum() >= _FILLED * box.prod() or box.max() < _LONG * whole:
        return None
    along = uv.mean(axis=1) @ axes[best][int(box[1] > box[0])]
    order = np.argsort(along, kind="stable")
    middle = along[order][np.searchsorted(np.cumsum(area[order]), area.sum() / 2)]
    halves: Ints = (along > middle).astype(np.int64)
    return halves
