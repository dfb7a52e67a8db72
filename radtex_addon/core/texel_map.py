# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The texel map: the surface point and the frame of every texel of the baked UV layer.

The rasterisation is conservative: every point of an island lies in a covered texel. It works in float64 and
texel units, texel (i, j) being the square [i, i + 1] x [j, j + 1], and uses elementwise operations only, so
that its result does not depend on how the work is cut into chunks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import large_arrays
from .arrays import Bools, Floats, Ints
from .errors import ShapeError
from .frame import normalised, orthonormal_frame
from .surface import SurfaceMesh

_CHUNK = 1 << 18  # triangles, (triangle, row) or (triangle, texel) pairs, or texels processed at once
_SLACK = 1e-6  # texels: a square that a triangle misses by less counts as touched
_BROKEN = 1e60  # texels: larger than any float32 UV, small enough that its square is finite
_FLAT = 1e-6  # doubled area over longest edge squared: a triangle below this has no usable normal


@dataclass(frozen=True)
class TexelMap:
    """The surface at every texel, row 0 at v = 0; float32 unless stated, zero where no island touches.

    `position` (H, W, 3) in world space; `normal` and `tangent` (H, W, 3) unit and orthogonal, and the
    bitangent's `sign` (H, W), +1 or -1; `facet` (H, W, 3) unit normal of the triangle itself, on the
    shading normal's side; `triangle` (H, W) int32, -1 where no island touches; `inside` (H, W) bool, True
    where the texel's centre lies in an island (elsewhere its point is the island's nearest to the centre,
    or one beyond a seam). `offset` (H, W) is the distance from the surface at which rays start, in scene
    units; None if it is the same for all texels. `touching` (H, W) is the triangle of the texel's own
    island, where that may be another than the point's `triangle`; None if it is the same everywhere.
    """

    position: Floats
    normal: Floats
    tangent: Floats
    sign: Floats
    facet: Floats
    triangle: Ints
    inside: Bools
    offset: Floats | None = None
    touching: Ints | None = None

    @property
    def own_triangle(self) -> Ints:
        """The triangle of the island that touches the texel, -1 where none does: (H, W) int32."""
        return self.triangle if self.touching is None else self.touching

    @property
    def covered(self) -> Bools:
        """True where an island touches the texel: (H, W)."""
        return self.triangle >= 0


def rasterise(
    surface: SurfaceMesh, width: int, height: int, reach: float = 0.5, chunk: int = _CHUNK
) -> TexelMap:
    """Find the point and the frame of every texel that an island touches.

    A texel whose centre lies in a triangle takes the point at the centre; any other takes the nearest point
    of the nearest triangle that touches it. Between equally near triangles the smallest index wins. Texels
    outside UV 0..1 are left out; triangles without area in UV, or with UVs that are not finite, are skipped.

    `reach` is half the side, in texels, of the square around the centre that a triangle must touch: 0.5 is
    the texel itself, 1 is all that a bilinear lookup reads. `chunk` limits the memory without changing the
    result. Raises ShapeError for arrays that do not fit together or a size below 1 x 1.
    """
    _check(surface, width, height)
    triangle = _nearest_triangle(surface.uv, width, height, reach, chunk)
    texels = _empty_map(width, height)
    texels.triangle.ravel()[:] = triangle
    covered = np.flatnonzero(triangle >= 0)
    for start in range(0, len(covered), chunk):
        _fill(texels, surface, covered[start : start + chunk])
    return texels


def covered_texels(surface: SurfaceMesh, width: int, height: int) -> Bools:
    """True where an island touches the texel (H, W): `TexelMap.covered` of `rasterise`, in less memory."""
    return triangle_of_texels(surface.uv, width, height) >= 0


def triangle_of_texels(uv: Floats, width: int, height: int) -> Ints:
    """The triangle of `uv` (F, 3, 2) that each texel shows, (H, W) int32, as in `rasterise`; -1 for none."""
    return _nearest_triangle(uv, width, height, 0.5, _CHUNK).reshape(height, width)


def _nearest_triangle(uv: Floats, width: int, height: int, reach: float, chunk: int) -> Ints:
    """Index of each texel's triangle (H * W,), chosen as in `rasterise`; -1 for none."""
    distance = large_arrays.empty(width * height, np.float64)
    triangle = large_arrays.empty(width * height, np.int32)
    distance[:], triangle[:] = np.inf, -1
    for first in range(0, len(uv), chunk):
        edges, owner = _edges_in_texels(uv[first : first + chunk], width, height)
        for local, i, j in _touched(edges, width, height, reach, chunk):
            _keep_nearest(distance, triangle, j * width + i, edges.take(local), owner[local] + first, i, j)
    return triangle


@dataclass(frozen=True)
class _Edges:
    """Edges of F triangles, each array (3, F): edge k joins corners k and k + 1.

    `a` is always the lower end (of equally low ones the left). So two triangles that share an edge compute
    exactly the same numbers: no centre falls between them, and equal distances are equal to the bit.
    """

    ax: Floats
    ay: Floats
    dx: Floats
    dy: Floats
    turn: Floats  # +1 where the triangle lies to the left of a -> b, else -1
    swapped: Bools  # True where a is corner k + 1

    def take(self, index: Ints) -> _Edges:
        part = (slice(None), index)
        return _Edges(
            self.ax[part], self.ay[part], self.dx[part], self.dy[part], self.turn[part], self.swapped[part]
        )

    def sides(self, x: Floats, y: Floats) -> Floats:
        """Twice the signed area of (a, b, point), positive on the triangle's side: (3, F)."""
        side: Floats = self.turn * (self.dx * (y - self.ay) - self.dy * (x - self.ax))
        return side

    def nearest(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Nearest point of each edge to (x, y), as a fraction from 0 at a to 1 at b; its squared distance."""
        px, py = x - self.ax, y - self.ay
        length = self.dx * self.dx + self.dy * self.dy
        unbounded = np.divide(px * self.dx + py * self.dy, length, out=np.zeros_like(px), where=length > 0)
        along: Floats = np.clip(unbounded, 0.0, 1.0)
        qx: Floats = px - along * self.dx
        qy: Floats = py - along * self.dy
        return along, qx * qx + qy * qy


def _check(surface: SurfaceMesh, width: int, height: int) -> None:
    if min(width, height) < 1:
        raise ShapeError(f"a texel map of {width} x {height} texels has no texel")
    count = len(surface.triangles)
    shapes = {"triangles": (3,), "normal": (3, 3), "tangent": (3, 3), "sign": (3,), "uv": (3, 2)}
    for name, shape in shapes.items():
        actual = getattr(surface, name).shape
        if actual != (count, *shape):
            raise ShapeError(f"surface {name}: expected shape {(count, *shape)}, got {actual}")


def _edges_in_texels(uv: Floats, width: int, height: int) -> tuple[_Edges, Ints]:
    """Edges of the finite triangles with an area in UV, and the indices of these triangles."""
    corner = uv.astype(np.float64) * (width, height)
    owner = np.flatnonzero((np.abs(corner) < _BROKEN).all(axis=(1, 2)))
    (x0, y0), (x1, y1), (x2, y2) = corner[owner].transpose(1, 2, 0)
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    owner, area = owner[area != 0], area[area != 0]
    a = corner[owner].transpose(2, 1, 0)
    b = np.roll(a, -1, axis=1)
    swapped = (b[1] < a[1]) | ((b[1] == a[1]) & (b[0] < a[0]))
    a, b = np.where(swapped, b, a), np.where(swapped, a, b)
    turn = np.where(swapped, -1.0, 1.0) * np.sign(area)
    return _Edges(a[0], a[1], b[0] - a[0], b[1] - a[1], turn, swapped), owner


def _runs(counts: Ints, limit: int) -> Iterator[tuple[Ints, Ints]]:
    """Yield (run, index in the run) for the members of all runs, in order, at most `limit` at a time.

    Run r has counts[r] members, which may be spread over several yields.
    """
    ends = np.cumsum(counts, dtype=np.int64)
    total = int(ends[-1]) if len(ends) else 0
    for start in range(0, total, limit):
        stop = min(start + limit, total)
        first, last = np.searchsorted(ends, (start, stop - 1), side="right")
        run = slice(first, last + 1)
        begins = ends[run] - counts[run]
        length = np.minimum(ends[run], stop) - np.maximum(begins, start)
        place = np.arange(start, stop) - np.repeat(begins, length)
        yield np.repeat(np.arange(first, last + 1), length), place


def _between(low: Floats, high: Floats, reach: float, count: int) -> tuple[Ints, Ints]:
    """First index and number of the texels, in a row of `count` texels, whose squares meet low..high."""
    reach += _SLACK
    first = np.ceil(np.clip(low - 0.5 - reach, 0, count)).astype(np.int64)
    last = np.floor(np.clip(high - 0.5 + reach, -1, count - 1)).astype(np.int64)
    return first, np.maximum(last - first + 1, 0)


def _touched(
    edges: _Edges, width: int, height: int, reach: float, chunk: int
) -> Iterator[tuple[Ints, Ints, Ints]]:
    """All (triangle, i, j) whose square and triangle meet, by triangle, then row, then column.

    The intersection of a triangle with a row of squares is convex: a square of the row meets it exactly if
    their x intervals meet. So the cost of a long thin triangle grows only with the squares that it touches.
    """
    low, high = edges.ay.min(axis=0, initial=np.inf), (edges.ay + edges.dy).max(axis=0, initial=-np.inf)
    first_row, rows = _between(low, high, reach, height)
    for local, row in _runs(rows, chunk):
        j = first_row[local] + row
        left, right = _span(edges.take(local), j + 0.5, reach + _SLACK)
        first_column, columns = _between(left, right, reach, width)
        for pair, column in _runs(columns, chunk):
            yield local[pair], first_column[pair] + column, j[pair]


def _span(edges: _Edges, centre: Floats, half: float) -> tuple[Floats, Floats]:
    """Least and largest x of each triangle in the band y = centre - half .. centre + half: both (F,)."""
    below, above = centre - half - edges.ay, centre + half - edges.ay
    meets = (above >= 0) & (below <= edges.dy)
    steep = edges.dy > 0
    with np.errstate(over="ignore"):  # infinities are clipped too
        enter = np.clip(np.divide(below, edges.dy, out=np.zeros_like(below), where=steep), 0.0, 1.0)
        leave = np.clip(np.divide(above, edges.dy, out=np.ones_like(above), where=steep), 0.0, 1.0)
    x, other = edges.ax + enter * edges.dx, edges.ax + leave * edges.dx
    left = np.where(meets, np.minimum(x, other), np.inf).min(axis=0)
    right = np.where(meets, np.maximum(x, other), -np.inf).max(axis=0)
    return left, right


def _keep_nearest(
    distance: Floats, triangle: Ints, texel: Ints, edges: _Edges, index: Ints, i: Ints, j: Ints
) -> None:
    """Store the triangle of each pair in its texel if it is nearer than the stored one.

    `index`, the triangles' indices, must ascend.
    """
    x, y = i + 0.5, j + 0.5
    outside = np.flatnonzero((edges.sides(x, y) < 0).any(axis=0))
    squared = np.zeros(len(texel))
    to_edge = edges.take(outside).nearest(x[outside], y[outside])[1]
    squared[outside] = np.maximum(to_edge.min(axis=0), np.finfo(np.float64).tiny)  # 0 means inside
    nearer = np.flatnonzero(squared < distance[texel])
    texel, squared, index = texel[nearer], squared[nearer], index[nearer]
    np.minimum.at(distance, texel, squared)
    winner = np.flatnonzero(squared == distance[texel])[::-1]  # numpy keeps the last of repeated texels
    triangle[texel[winner]] = index[winner]


def _empty_map(width: int, height: int) -> TexelMap:
    def zeros(*shape: int, dtype: npt.DTypeLike = np.float32) -> npt.NDArray[Any]:
        return large_arrays.zeros((height, width, *shape), dtype)

    triangle, inside = zeros(dtype=np.int32), zeros(dtype=np.bool_)
    return TexelMap(zeros(3), zeros(3), zeros(3), zeros(), zeros(3), triangle, inside)


def _fill(texels: TexelMap, surface: SurfaceMesh, texel: Ints) -> None:
    """Interpolate the surface at the covered texels with flat indices `texel` (K,)."""
    height, width = texels.triangle.shape
    triangle = texels.triangle.ravel()[texel]
    edges, _ = _edges_in_texels(surface.uv[triangle], width, height)
    weight, inside = _weights(edges, texel % width + 0.5, texel // width + 0.5)
    corner = surface.position[surface.triangles[triangle]].astype(np.float64)
    own = _facet(corner)
    normal = normalised(_blend(weight, surface.normal[triangle]))
    missing = ~normal.any(axis=-1, keepdims=True)
    normal = np.where(missing, np.where(own.any(axis=-1, keepdims=True), own, (0.0, 0.0, 1.0)), normal)
    sign = np.where(_blend(weight, surface.sign[triangle][..., None])[..., 0] < 0, -1.0, 1.0)
    tangent, _, normal = orthonormal_frame(normal, _blend(weight, surface.tangent[triangle]), sign)
    facing = np.where(np.sum(own * normal, axis=-1, keepdims=True) < 0, -own, own)
    facet = np.where(own.any(axis=-1, keepdims=True), facing, normal)
    values = _blend(weight, corner), normal, tangent, sign, facet, inside
    fields = texels.position, texels.normal, texels.tangent, texels.sign, texels.facet, texels.inside
    for field, value in zip(fields, values, strict=True):
        field.reshape(height * width, *field.shape[2:])[texel] = value


def _weights(edges: _Edges, x: Floats, y: Floats) -> tuple[Floats, Bools]:
    """Barycentric weights (K, 3) of each triangle's nearest point to (x, y), and whether (x, y) is inside."""
    sides = edges.sides(x, y)
    inside: Bools = (sides >= 0).all(axis=0)
    total = sides.sum(axis=0)
    within = inside & (total > 0)
    weight = np.divide(np.roll(sides, -1, axis=0), total, out=np.zeros_like(sides), where=within)
    along, squared = edges.nearest(x, y)
    edge, everyone = squared.argmin(axis=0), np.arange(len(x))
    along = np.where(edges.swapped, 1.0 - along, along)[edge, everyone]
    outer = np.flatnonzero(~within)
    weight[edge[outer], outer] = 1.0 - along[outer]
    weight[(edge[outer] + 1) % 3, outer] = along[outer]
    return weight.T, inside


def _blend(weight: Floats, corner: Floats) -> Floats:
    """Sum of corner values (K, 3, C) by weights (K, 3): (K, C)."""
    shares: list[Floats] = [weight[:, k, None] * corner[:, k] for k in range(3)]
    return shares[0] + shares[1] + shares[2]


def _facet(corner: Floats) -> Floats:
    """Unit normals of triangles (K, 3, 3), oriented by the corners' order; zero if they have no area."""
    one, two = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    three = two - one
    area = np.cross(one, two)
    longest = np.max([np.sum(edge * edge, axis=-1) for edge in (one, two, three)], axis=0)
    flat = np.sum(area * area, axis=-1) <= (_FLAT * longest) ** 2
    return np.where(flat[:, None], 0.0, normalised(area))
