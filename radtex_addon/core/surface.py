# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked surface as arrays: the mesh data that rasterisation needs, its edges, patches and stretch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .arrays import Floats, Ints, Keys, blocks, sorted_ranges

GRAZING = 0.01  # least cosine between a ray and the normal of the facet that it starts from
_OF_SIZE = 5e-4  # times the object's diagonal: less than a texel, more than facets lie off the smooth surface
_OF_COORDINATE = 5e-5  # times the largest coordinate: lifts a grazing ray's start by eight float32 steps
_NOTHING = 1e-30  # lengths below count as 0
_BITS = 10  # of each coordinate in a Morton number
_LEAST = 16  # a patch with `most` / _LEAST triangles or fewer is not split further
_HALF = np.uint64(32)  # bits of a key for each of an edge's vertices


@dataclass(frozen=True)
class SurfaceMesh:
    """A triangulated surface in world space, with the frame of its baked UV layer at every corner.

    V vertices, F triangles: `position` (V, 3); `triangles` (F, 3) vertex indices; `normal` and MikkTSpace's
    `tangent` (F, 3, 3), transformed by the object's matrix but not normalised: shaders interpolate before
    they normalise, and so must rasterisation; `sign` (F, 3) of the bitangent, +1 or -1, already multiplied by
    the sign of the object matrix's determinant; `uv` (F, 3, 2) with v up; `material` (F,), the number of each
    triangle's material, None if all have the first.
    """

    position: Floats
    triangles: Ints
    normal: Floats
    tangent: Floats
    sign: Floats
    uv: Floats
    material: Ints | None = None

    @property
    def material_numbers(self) -> Ints:
        """`material`, (F,) int32, 0 where it is None."""
        return np.zeros(len(self.triangles), dtype=np.int32) if self.material is None else self.material

    @property
    def corner_position(self) -> Floats:
        """Positions of the triangles' corners, (F, 3, 3)."""
        return self.position[self.triangles]


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


def is_closed(vertex: Ints) -> bool:
    """Whether triangles (F, 3) run along each edge as often one way as the other: none has an open side."""
    turns = np.where(vertex < np.roll(vertex, -1, axis=1), 1, -1).reshape(-1)
    keys = edge_keys(vertex)
    order = np.argsort(keys)
    first = np.flatnonzero(np.diff(keys[order], prepend=keys[order[0]] + np.uint64(1)))
    apart = (vertex != np.roll(vertex, -1, axis=1)).reshape(-1)
    return not np.add.reduceat((turns * apart)[order], first).any()


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


def stretches(corners: Floats, uv: Floats) -> Floats:
    """The largest and the least stretch of each triangle as it is flattened: (F, 2).

    `corners` (F, 3, 3) in space, `uv` (F, 3, 2) in the same unit: both are 1 where a triangle keeps its shape
    and size. They are the singular values of the linear map from the triangle's plane; Sander, Snyder,
    Gortler and Hoppe, "Texture Mapping Progressive Meshes" (2001), section 3. Of a triangle without area in
    space they are not meaningful, but finite.
    """
    found = np.empty((len(corners), 2))
    for some in blocks(len(corners)):
        found[some] = _stretches(corners[some], uv[some])
    return found


def _stretches(corners: Floats, uv: Floats) -> Floats:
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.maximum(np.linalg.norm(one, axis=1), _NOTHING)
    along = one / length[:, None]
    across_x = np.sum(two * along, axis=1)
    across_y = np.maximum(np.linalg.norm(two - across_x[:, None] * along, axis=1), _NOTHING)
    u = (uv[:, 1] - uv[:, 0]) / length[:, None]
    v = (uv[:, 2] - uv[:, 0] - u * across_x[:, None]) / across_y[:, None]
    uu, vv, uv_ = np.sum(u * u, axis=1), np.sum(v * v, axis=1), np.sum(u * v, axis=1)
    apart = np.sqrt((uu - vv) ** 2 + 4 * uv_ * uv_)
    found: Floats = np.sqrt(np.maximum(np.stack([uu + vv + apart, uu + vv - apart], axis=1) / 2, 0))
    return found


def ray_offset(position: Floats) -> float:
    """Distance in scene units between P and a ray's start, for surface positions (..., 3) in world space."""
    points = position.reshape(-1, 3).astype(np.float64)
    diagonal = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    return max(_OF_SIZE * diagonal, _OF_COORDINATE * float(np.abs(points).max()), 1e-9)
