# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Islands of a UV layer: which triangles are connected, which overlap, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .arrays import Bools, Floats, Ints, blocks, ranks
from .errors import ShapeError

ROWS_AT_ONCE = 1 << 18  # rows of triangles that the overlap raster holds in memory at a time
EDGE_MARGIN = 1e-6  # in grid cells: a sample this close to an edge counts as inside neither triangle


@dataclass(frozen=True)
class Overlap:
    """How much of a UV layer is covered more than once.

    `fraction` is the share of the covered area that has more than one triangle. `worst_uv` is the point with
    the most triangles, `depth` the number of triangles there.
    """

    fraction: float
    worst_uv: tuple[float, float]
    depth: int


def weld(rows: Floats | Ints) -> Ints:
    """Label the rows of (N, C) so that equal rows get equal labels: (N,) int64; 0 and -0 are equal.

    Labels 0, 1, … ascend with the rows' bytes, as stored by a little-endian machine.
    """
    table: npt.NDArray[Any] = np.asarray(rows)
    if table.ndim != 2:
        raise ShapeError(f"weld: expected shape (N, C), got {table.shape}")
    label = np.zeros(len(table), dtype=np.uint32)
    for number in range(table.shape[1]):
        column = _in_order_of_bytes(table[:, number])
        label = column if number == 0 else ranks(label.astype(np.uint64) << np.uint64(32) | column)
    if table.shape[1] == 1:
        label = ranks(label.astype(np.uint64))
    return label.astype(np.int64)


def _in_order_of_bytes(column: npt.NDArray[Any]) -> npt.NDArray[np.uint32]:
    """Numbers (N,), in the order of the values' bytes, of values (N,) of four or eight bytes."""
    clean = np.ascontiguousarray(column + column.dtype.type(0))  # -0 + 0 is 0
    if clean.dtype.itemsize == 4:
        return clean.view(np.uint32).byteswap()
    if clean.dtype.itemsize != 8:
        raise ShapeError(f"weld: expected values of 4 or 8 bytes, got {clean.dtype}")
    words = clean.view(np.uint64)
    words.byteswap(inplace=True)
    if np.bitwise_or.reduce(words).astype(np.uint32) == 0:  # whole numbers of 32 bits
        return (words >> np.uint64(32)).astype(np.uint32)
    return ranks(words)


def first_and_index(labels: Ints) -> tuple[Ints, Ints]:
    """Of labels (...), none below 0, where each first stands, (L,), and the labels without gaps, (...).

    Both are flat, and as `np.unique` returns them as index and inverse; but nothing is sorted, so labels must
    not be much larger than their count.
    """
    flat = labels.reshape(-1)
    first = np.full(int(flat.max(initial=-1)) + 1, -1, dtype=np.int64)
    first[flat[::-1]] = np.arange(len(flat) - 1, -1, -1)  # the last one that is written stays
    there = first >= 0
    return first[there], (np.cumsum(there) - 1)[flat]


def split_corners(triangles: Ints, owner: Ints) -> Ints:
    """Corner numbers (F, 3), equal for the same vertex of `triangles` (F, 3) and the same `owner` (F,)."""
    return weld(np.column_stack([triangles.ravel(), np.repeat(owner, 3)])).reshape(-1, 3)


def components(pairs: Ints, count: int) -> Ints:
    """Connected components of `count` nodes joined by `pairs` (M, 2): (count,) labels 0, 1, … without gaps.

    Minimum labels spread along the pairs, with pointer jumping, until nothing changes: O(log count) sweeps.
    A component's label is the number of components whose least node is less than its own.
    """
    small = np.int32 if count <= np.iinfo(np.int32).max else np.int64
    label: Ints = np.arange(count, dtype=small)
    first, second = np.asarray(pairs).reshape(-1, 2).T.astype(small)
    while len(first):
        one, other = label[first], label[second]
        lowest = np.minimum(one, other)
        np.minimum.at(label, one, lowest)
        np.minimum.at(label, other, lowest)
        label = _roots(label)
        apart = np.flatnonzero(label[first] != label[second])
        first, second = first[apart], second[apart]
    number = np.cumsum(label == np.arange(count, dtype=small), dtype=np.int64) - 1
    found: Ints = number[label]
    return found


def _roots(label: Ints) -> Ints:
    """Follow labels (N,), each at most its own index, to those that label themselves."""
    while True:
        following = label[label]
        if np.array_equal(following, label):
            return following
        label = following


def triangle_islands(corners: Ints) -> Ints:
    """Islands of triangles that share a corner number, `corners` (F, 3): (F,) labels 0, 1, … without gaps."""
    corners = np.asarray(corners)
    count = int(corners.max(initial=-1)) + 1
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]])
    return np.unique(components(pairs, count)[corners[:, 0]], return_inverse=True)[1].reshape(-1)


def uv_corners(triangles: Ints, uv: Floats) -> Ints:
    """Corner numbers (F, 3), equal where triangles (F, 3) share a vertex and there the same uv (F, 3, 2)."""
    vertex = np.asarray(triangles).reshape(-1, 1)
    texture = weld(np.asarray(uv).reshape(-1, 2)).reshape(-1, 1)
    return weld(np.concatenate([vertex, texture], axis=1)).reshape(-1, 3)


def uv_islands(triangles: Ints, uv: Floats) -> Ints:
    """Islands of triangles (F, 3) that share a vertex and, there, the same uv (F, 3, 2): (F,) labels."""
    return triangle_islands(uv_corners(triangles, uv))


def border_edges(corners: Ints) -> Ints:
    """The edges that only one triangle has: (B, 2), the triangle and its edge, which begins at that corner.

    `corners` (F, 3) are corner numbers; edge k joins corners k and k + 1.
    """
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, first, count = np.unique(
        low * (int(high.max(initial=0)) + 1) + high, return_index=True, return_counts=True
    )
    return np.stack(np.divmod(first[count == 1], 3), axis=1)


def signed_areas(uv: Floats) -> Floats:
    """Areas of uv triangles (F, 3, 2), negative where mirrored: (F,)."""
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    areas: Floats = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return areas


def surface_areas(corners: Floats) -> Floats:
    """Areas of triangles in space, corners (F, 3, 3): (F,)."""
    areas = np.empty(len(corners), dtype=corners.dtype)
    for some in blocks(len(corners)):
        a, b, c = corners[some].transpose(1, 0, 2)
        cross = np.cross(b - a, c - a)
        areas[some] = 0.5 * np.sqrt(np.sum(cross * cross, axis=-1))
    return areas


def areas_on_surface(position: Floats, triangles: Ints) -> Floats:
    """Areas of triangles (F, 3) with vertices at `position` (V, 3): (F,) float64."""
    areas = np.empty(len(triangles))
    for some in blocks(len(triangles)):
        areas[some] = surface_areas(position[triangles[some]].astype(np.float64))
    return areas


def find_overlap(uv: Floats, resolution: int = 1024) -> Overlap:
    """Overlap of uv triangles (F, 3, 2) within the unit square, found at resolution² sample points.

    A point on an edge lies in no triangle, so triangles that share an edge do not count as overlapping.
    """
    depth = coverage_depth(uv, resolution)
    covered = int(np.count_nonzero(depth))
    doubled = int(np.count_nonzero(depth > 1))
    row, column = np.unravel_index(int(np.argmax(depth)), depth.shape)
    worst = ((float(column) + 0.5) / resolution, (float(row) + 0.5) / resolution)
    return Overlap(doubled / max(covered, 1), worst, int(depth.max(initial=0)))


def coverage_depth(uv: Floats, resolution: int) -> Ints:
    """How many triangles contain each sample point strictly: (resolution, resolution) int32.

    Points lie at the centres of a grid over the unit square, row 0 at the bottom. Each triangle adds one
    span to each row that it crosses.
    """
    steps = np.zeros((resolution, resolution + 1), dtype=np.int32)
    for some in blocks(len(uv)):
        # Sample points have whole coordinates.
        grid = np.asarray(uv[some], dtype=np.float64) * resolution - 0.5
        low = np.clip(np.ceil(grid[..., 1].min(axis=1)), 0, resolution).astype(np.int64)
        high = np.clip(np.floor(grid[..., 1].max(axis=1)), -1, resolution - 1).astype(np.int64)
        rows = np.maximum(high - low + 1, 0)
        ends = np.cumsum(rows)
        start = 0
        while start < len(rows):
            base = ends[start] - rows[start]
            stop = max(int(np.searchsorted(ends, base + ROWS_AT_ONCE, side="right")), start + 1)
            _add_spans(steps, grid[start:stop], low[start:stop], rows[start:stop])
            start = stop
    return np.cumsum(steps[:, :-1], axis=1, dtype=np.int32)


def _add_spans(steps: Ints, grid: Floats, low: Ints, rows: Ints) -> None:
    """Add +1 to `steps` where a triangle's span in a row begins, and -1 after its end."""
    triangle = np.repeat(np.arange(len(rows)), rows)
    row = np.arange(len(triangle)) - np.repeat(np.cumsum(rows) - rows, rows) + low[triangle]
    left = np.full(len(row), -np.inf)
    right = np.full(len(row), np.inf)
    turn = np.where(signed_areas(grid) < 0, -1.0, 1.0)[triangle]
    inside: Bools = np.ones(len(row), dtype=bool)
    for corner in range(3):
        ax, ay = grid[triangle, corner].T
        bx, by = grid[triangle, (corner + 1) % 3].T
        rise = (by - ay) * turn
        level = rise == 0
        with np.errstate(divide="ignore", invalid="ignore"):
            x = ax + (bx - ax) * ((row - ay) / (by - ay))
        # Inside lies left of a rising edge and right of a falling one (the triangle turned anticlockwise).
        right = np.where(~level & (rise > 0), np.minimum(right, x), right)
        left = np.where(~level & (rise < 0), np.maximum(left, x), left)
        inside &= ~level | (np.abs(row - ay) > EDGE_MARGIN)
    width = steps.shape[1] - 1
    begin = np.clip(np.ceil(left + EDGE_MARGIN), 0, width)
    end = np.clip(np.floor(right - EDGE_MARGIN) + 1, 0, width)
    inside &= end > begin
    np.add.at(steps, (row[inside], begin[inside].astype(np.int64)), 1)
    np.add.at(steps, (row[inside], end[inside].astype(np.int64)), -1)
