# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Merge flat islands into fewer and larger ones, while they stretch little and do not overlap.

Unwrappers end an island where the surface has turned by some 70 degrees, although a sheet that is bent
further flattens as well: around a rounded edge, along a tube, over a fold. In rounds, neighbours with much
border in common are flattened together, all pairs of a round at once; pairs that stretch too much or overlap
stay apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ...core.islands import coverage_depth, signed_areas, split_corners, surface_areas, triangle_islands, weld
from ...core.stretch import stretches
from .blender_unwrap import Way, unwrapped_by_blender

_MOST_STRETCH = 1.7  # of a merged island: how much wider or narrower its worst parts may be than the whole
_WORST = 0.02  # share of an island's area that may be worse
_FLIPPED = 1e-3  # share of an island's area that may lie upside down
_OVERLAP = 1e-3  # share of an island's covered area that may be covered twice
_FINE = 96  # sample points across an island, to find overlaps by
_MOST_POINTS = 6144  # across all islands


@dataclass(frozen=True, eq=False)
class Seamed:
    """A mesh, V points (V, 3) and triangles (F, 3), and its inner edges that islands may cross.

    `sides` (E, 2) are the triangles on both sides of each of these edges, `length` (E,) their lengths.
    """

    points: Floats
    triangles: Ints
    sides: Ints
    length: Floats


def merged(mesh: Seamed, uv: Floats, island: Ints, rounds: int) -> Iterator[tuple[Floats, Ints]]:
    """Merge islands, round after round: the uv (F, 3, 2), to scale, and island numbers (F,), after each.

    An `island` of -1 is none. It ends when nothing more can be merged, or after so many `rounds`.
    """
    area = surface_areas(mesh.points[mesh.triangles])
    uv, island = uv.copy(), island.copy()
    apart: set[tuple[int, int]] = set()  # pairs that do not merge, until one of them does with another
    for _ in range(rounds):
        pairs = _chosen(mesh, area, island, apart)
        if not len(pairs):
            return
        fine = _merge(mesh, area, uv, island, pairs)
        apart |= {(int(one), int(other)) for one, other in pairs[~fine]}
        grown = set(pairs[fine].ravel().tolist())
        apart = {pair for pair in apart if not grown & set(pair)}
        if fine.any():
            yield uv.copy(), _connected(mesh.triangles, island)


def _chosen(mesh: Seamed, area: Floats, island: Ints, apart: set[tuple[int, int]]) -> Ints:
    """Pairs of neighbours (P, 2), no island twice, those with most border in common for their size first."""
    count = int(island.max(initial=-1)) + 1
    sides = np.sort(island[mesh.sides], axis=1)
    between = (sides[:, 0] >= 0) & (sides[:, 0] != sides[:, 1])
    key, edge = np.unique(sides[between] @ [count, 1], return_inverse=True)
    shared = np.bincount(edge, mesh.length[between], minlength=len(key))
    pairs = np.stack([key // max(count, 1), key % max(count, 1)], axis=1)
    size = np.bincount(island[island >= 0], area[island >= 0], minlength=count)
    worth = shared / np.sqrt(np.maximum(size[pairs].min(axis=1), 1e-30))
    taken = np.zeros(count, dtype=bool)
    chosen = []
    for one, other in pairs[np.argsort(-worth, kind="stable")].tolist():
        if not (taken[one] or taken[other] or (one, other) in apart):
            taken[[one, other]] = True
            chosen.append((one, other))
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _merge(mesh: Seamed, area: Floats, uv: Floats, island: Ints, pairs: Ints) -> Bools:
    """Flatten each pair as one island; where that is good, write `uv` and `island` and mark the pair (P,)."""
    of_pair = np.full(int(island.max()) + 1, -1)
    of_pair[pairs.ravel()] = np.repeat(np.arange(len(pairs)), 2)
    some = np.flatnonzero((island >= 0) & (of_pair[island] >= 0))
    pair = of_pair[island[some]]
    corner = split_corners(mesh.triangles[some], pair)
    fine = _open(corner, pair, len(pairs))
    kept = fine[pair]
    some, pair, corner = some[kept], pair[kept], split_corners(mesh.triangles[some[kept]], pair[kept])
    if not len(some):
        return fine
    _, first = np.unique(corner, return_index=True)
    points = mesh.points[mesh.triangles[some].ravel()[first]]
    flat = unwrapped_by_blender(points, corner, Way.CONFORMAL)
    flat = _to_scale(flat, area[some], pair)
    fine &= _good(mesh.points[mesh.triangles[some]], area[some], flat, pair, len(pairs))
    good = fine[pair]
    uv[some[good]] = flat[good]
    island[some[good]] = pairs[pair[good], 0]
    return fine


def _open(corner: Ints, owner: Ints, count: int) -> Bools:
    """Which of `count` islands have a border, as what is closed all round cannot be flattened."""
    following = np.roll(corner, -1, axis=1)
    edges = np.stack([np.minimum(corner, following), np.maximum(corner, following)], axis=-1).reshape(-1, 2)
    _, first, uses = np.unique(weld(edges), return_index=True, return_counts=True)
    found = np.zeros(count, dtype=bool)
    found[np.repeat(owner, 3)[first[uses == 1]]] = True
    return found


def _to_scale(flat: Floats, area: Floats, owner: Ints) -> Floats:
    """Scale each island to its area on the surface."""
    covered = np.bincount(owner, np.abs(signed_areas(flat)))
    scale = np.sqrt(np.bincount(owner, area) / np.maximum(covered, 1e-30))
    return flat * scale[owner][:, None, None]


def _good(corners: Floats, area: Floats, flat: Floats, owner: Ints, count: int) -> Bools:
    """Which of the islands are flat, not stretched much, and overlap nowhere: (count,)."""
    whole = np.maximum(np.bincount(owner, area, minlength=count), 1e-30)
    most, least = stretches(corners, flat).T
    off = np.maximum(most, 1 / np.maximum(least, 1e-9)) > _MOST_STRETCH
    fine: Bools = np.bincount(owner, area * off, minlength=count) <= _WORST * whole
    up = np.bincount(owner, area * (signed_areas(flat) > 0), minlength=count)
    fine &= np.minimum(up, whole - up) <= _FLIPPED * whole
    fine &= np.isfinite(np.bincount(owner, flat.sum(axis=(1, 2)), minlength=count))
    kept = fine[owner]
    fine[fine] = _overlaps(flat[kept], np.cumsum(fine)[owner[kept]] - 1, int(fine.sum())) <= _OVERLAP
    return fine


def _overlaps(flat: Floats, owner: Ints, count: int) -> Floats:
    """For each island the share of its area that is covered twice: (count,)."""
    if not count:
        return np.zeros(0)
    across = math.ceil(math.sqrt(count))
    fine = max(min(_FINE, _MOST_POINTS // across), 8)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, owner, flat.min(axis=1))
    np.maximum.at(high, owner, flat.max(axis=1))
    size = np.maximum((high - low).max(axis=1), 1e-30)
    cell = np.stack([np.arange(count) % across, np.arange(count) // across], axis=1)
    placed = (flat - low[owner][:, None]) / size[owner][:, None, None] * (1 - 2 / fine) + 1 / fine
    depth = coverage_depth((placed + cell[owner][:, None]) / across, across * fine)
    cells = depth.reshape(across, fine, across, fine).transpose(0, 2, 1, 3).reshape(-1, fine * fine)[:count]
    shares: Floats = np.count_nonzero(cells > 1, axis=1) / np.maximum(np.count_nonzero(cells, axis=1), 1)
    return shares


def _connected(triangles: Ints, island: Ints) -> Ints:
    """Islands numbered without gaps, each one piece: (F,); -1 stays."""
    found = np.full(len(island), -1)
    real = island >= 0
    found[real] = triangle_islands(split_corners(triangles[real], island[real]))
    return found
