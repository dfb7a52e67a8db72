# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Merge flat islands into fewer and larger ones, where less is lost to stretch than seams cost.

Unwrappers end an island where the surface has turned by some 70 degrees, although a sheet that is bent
further flattens as well: around a rounded edge, along a tube, over a fold. So all islands that hang together
are flattened as one first, and what stays apart then in rounds: neighbours with much border in common, all
pairs of a round at once.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...bake.progress import relayed
from ...core.arrays import Bools, Floats, Ints
from ...core.islands import (
    components,
    coverage_depth,
    signed_areas,
    split_corners,
    surface_areas,
    triangle_islands,
    weld,
)
from ...core.surface import stretches
from .blender_unwrap import Way, unwrapped_by_blender

_SQUEEZED = (
    0.45  # times as long as on the surface: an island has hardly more parts so short along some direction
)
_WORST = 0.02  # share of an island's area that may be shorter
_FLIPPED = 1e-3  # share of an island's area that may lie upside down
_OVERLAP = 1e-3  # share of an island's covered area that may be covered twice
_SEAM = 4.0  # texels lost along a border between two islands, two on either side, where a seam may show
_LARGE = 200_000  # triangles: more are flattened by least squares, as angles take too long
_AT_ONCE = 10_000  # triangles flattened between two reports of progress, if islands are smaller
_FINE = 96  # sample points across an island, to find overlaps by
_MOST_POINTS = 6144  # across all islands


@dataclass(frozen=True, eq=False)
class Seamed:
    """A mesh, V points (V, 3) and triangles (F, 3), and its inner edges that islands may cross.

    `sides` (E, 2) are the triangles on both sides of each of these edges, `length` (E,) their lengths.
    `texel` is about how wide a texel will be on the surface, in the units of the points.
    """

    points: Floats
    triangles: Ints
    sides: Ints
    length: Floats
    texel: float


def merged(
    mesh: Seamed, uv: Floats, island: Ints, rounds: int
) -> Generator[float, None, list[tuple[Floats, Ints]]]:
    """Merge islands, round after round: the uv (F, 3, 2), to scale, and island numbers (F,), after each.

    An `island` of -1 is none. It ends when nothing more can be merged, or after so many `rounds`. Yields how
    much of them is done, 0 to 1.
    """
    area = surface_areas(mesh.points[mesh.triangles])
    uv, island = uv.copy(), island.copy()
    found: list[tuple[Floats, Ints]] = []
    group = _openable(mesh, island, _together(_Neighbours.of(mesh, island)))
    first = int(group.max(initial=-1) >= 0)  # nothing hangs together that can be flattened: no round is spent
    if first:
        merging = _merge(mesh, area, uv, island, group)
        fine = yield from relayed(merging, partial(_in_round, 0, rounds))
        if fine.any():
            found.append((uv.copy(), _connected(mesh.triangles, island)))
    apart: set[tuple[int, int]] = set()  # pairs that do not merge, until one of them does with another
    for number in range(first, rounds):
        near = _Neighbours.of(mesh, island)
        pairs = _pairs(near, area, island, apart)
        if not len(pairs):
            break
        group = np.full(near.count, -1)
        group[pairs] = np.arange(len(pairs))[:, None]
        merging = _merge(mesh, area, uv, island, group)
        fine = yield from relayed(merging, partial(_in_round, number, rounds))
        apart |= {(int(one), int(other)) for one, other in pairs[~fine]}
        grown = set(pairs[fine].ravel().tolist())
        apart = {pair for pair in apart if not grown & set(pair)}
        if fine.any():
            found.append((uv.copy(), _connected(mesh.triangles, island)))
    return found


def _in_round(number: int, rounds: int, share: float) -> float:
    return (number + share) / rounds


@dataclass(frozen=True, eq=False)
class _Neighbours:
    """Of `count` islands those with a border in common, `pairs` (P, 2), and how long it is, `shared` (P,)."""

    count: int
    pairs: Ints
    shared: Floats

    @classmethod
    def of(cls, mesh: Seamed, island: Ints) -> _Neighbours:
        count = int(island.max(initial=-1)) + 1
        sides = np.sort(island[mesh.sides], axis=1)
        between = (sides[:, 0] >= 0) & (sides[:, 0] != sides[:, 1])
        key, edge = np.unique(sides[between] @ [count, 1], return_inverse=True)
        shared = np.bincount(edge, mesh.length[between], minlength=len(key)).astype(np.float64)
        return cls(count, np.stack([key // max(count, 1), key % max(count, 1)], axis=1), shared)


def _together(near: _Neighbours) -> Ints:
    """Groups of islands that hang together: each island's group (I,), -1 if it has no neighbour."""
    label = components(near.pairs, near.count)
    found = np.full(near.count, -1)
    some = np.bincount(label)[label] > 1
    found[some] = np.unique(label[some], return_inverse=True)[1]
    return found


def _openable(mesh: Seamed, island: Ints, group: Ints) -> Ints:
    """The groups (I,) without those that are closed all round, which become -1."""
    count = int(group.max(initial=-1)) + 1
    of_triangle = np.where(island >= 0, group[island], -1) if count else np.full(len(island), -1)
    some = of_triangle >= 0
    owner = of_triangle[some]
    fine = _open(split_corners(mesh.triangles[some], owner), owner, count)
    numbers = np.where(fine, np.cumsum(fine) - 1, -1)
    found: Ints = np.where(group >= 0, np.append(numbers, -1)[group], -1)
    return found


def _pairs(near: _Neighbours, area: Floats, island: Ints, apart: set[tuple[int, int]]) -> Ints:
    """Pairs of neighbours (P, 2), no island twice, those with most border in common for their size first."""
    size = np.bincount(island[island >= 0], area[island >= 0], minlength=near.count)
    worth = near.shared / np.sqrt(np.maximum(size[near.pairs].min(axis=1), 1e-30))
    taken = np.zeros(near.count, dtype=bool)
    chosen = []
    for one, other in near.pairs[np.argsort(-worth, kind="stable")].tolist():
        if not (taken[one] or taken[other] or (one, other) in apart):
            taken[[one, other]] = True
            chosen.append((one, other))
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _merge(
    mesh: Seamed, area: Floats, uv: Floats, island: Ints, group: Ints
) -> Generator[float, None, Bools]:
    """Flatten the islands of each `group` (I,), if not -1, as one: which of them (G,) are better so.

    Of these `uv` and `island` are written. Yields how much is done, 0 to 1.
    """
    count = int(group.max()) + 1
    of_triangle = np.where(island >= 0, group[island], -1)
    some = np.flatnonzero(of_triangle >= 0)
    owner = of_triangle[some]
    fine = _open(split_corners(mesh.triangles[some], owner), owner, count)
    kept = fine[owner]
    some, owner = some[kept], owner[kept]
    if not len(some):
        return fine
    flat = yield from _flattened(mesh, some, owner)
    flat = _to_scale(flat, area[some], owner)
    corners = mesh.points[mesh.triangles[some]]
    lost = _lost(corners, area[some], uv[some], flat, owner, count)
    fine &= lost <= _SEAM * mesh.texel * _inner_border(mesh, island, group)
    fine &= _sound(corners, area[some], flat, owner, count)
    fine[fine] = apart_from_itself(flat, owner, fine, _OVERLAP)
    good = fine[owner]
    uv[some[good]] = flat[good]
    lowest = np.full(count, len(group))
    np.minimum.at(lowest, group[group >= 0], np.flatnonzero(group >= 0))
    island[some[good]] = lowest[owner[good]]
    return fine


def _flattened(mesh: Seamed, some: Ints, owner: Ints) -> Generator[float, None, Floats]:
    """Flatten the triangles `some` (T,) of islands `owner` (T,), each by itself: (T, 3, 2), not to scale."""
    way = Way.ANGLES if len(some) <= _LARGE else Way.CONFORMAL
    flat = np.empty((len(some), 3, 2))
    order = np.argsort(owner, kind="stable")
    ends = np.flatnonzero(np.diff(owner[order], append=-1)) + 1  # of the islands
    begin = 0
    while begin < len(order):
        several = np.searchsorted(ends, begin + _AT_ONCE, side="right") - 1
        one = np.searchsorted(ends, begin, side="right")
        end = int(ends[max(several, one)])
        part = order[begin:end]
        corner = split_corners(mesh.triangles[some[part]], owner[part])
        _, first = np.unique(corner, return_index=True)
        points = mesh.points[mesh.triangles[some[part]].ravel()[first]]
        flat[part] = unwrapped_by_blender(points, corner, way)
        begin = end
        yield begin / len(order)
    return flat


def _inner_border(mesh: Seamed, island: Ints, group: Ints) -> Floats:
    """Length of the borders between islands of one group: (G,)."""
    one, other = island[mesh.sides].T
    inner = (one >= 0) & (other >= 0) & (one != other) & (group[one] >= 0) & (group[one] == group[other])
    length = np.bincount(group[one[inner]], mesh.length[inner], minlength=int(group.max()) + 1)
    return length.astype(np.float64)


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


def _lost(corners: Floats, area: Floats, before: Floats, flat: Floats, owner: Ints, count: int) -> Floats:
    """Area of each group (G,) that is no longer resolved, as it is squeezed in `flat`, not `before`."""
    was, now = (np.minimum(stretches(corners, uv)[:, 1], 1) ** 2 for uv in (before, flat))
    return np.bincount(owner, area * (was - now), minlength=count).astype(np.float64)


def _sound(corners: Floats, area: Floats, flat: Floats, owner: Ints, count: int) -> Bools:
    """Which of the groups are flat, and squeezed much nowhere: (G,)."""
    whole = np.maximum(np.bincount(owner, area, minlength=count), 1e-30)
    short = stretches(corners, flat)[:, 1] < _SQUEEZED
    fine: Bools = np.bincount(owner, area * short, minlength=count) <= _WORST * whole
    up = np.bincount(owner, area * (signed_areas(flat) > 0), minlength=count)
    fine &= np.minimum(up, whole - up) <= _FLIPPED * whole
    fine &= np.isfinite(np.bincount(owner, flat.sum(axis=(1, 2)), minlength=count))
    return fine


def apart_from_itself(flat: Floats, owner: Ints, chosen: Bools, most: float) -> Bools:
    """Which of the `chosen` islands (G,) have at most that share of their covered area covered twice.

    `flat` (F, 3, 2) are triangles, `owner` (F,) their islands.
    """
    kept = chosen[owner]
    number = (np.cumsum(chosen) - 1)[owner[kept]]
    return _overlaps(flat[kept], number, int(np.count_nonzero(chosen))) <= most


def _overlaps(flat: Floats, owner: Ints, count: int) -> Floats:
    """For each of `count` islands the share of its area that is covered twice: (count,).

    `flat` (F, 3, 2) are triangles, `owner` (F,) their islands.
    """
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
