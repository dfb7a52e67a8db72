# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give texels on an island's border the point of the surface beyond the seam.

The centre of such a texel lies outside its island. With the island's nearest point instead, what a bilinear
lookup finds at the seam would be of up to half a texel farther inside. Where the surface goes on smoothly
across the seam, the point is as far beyond it as the centre is outside the island, so that lookups on both
sides of the seam meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .arrays import Bools, Floats, Ints
from .frame import normalised, orthonormal_frame
from .islands import signed_areas, weld
from .surface import SurfaceMesh, edge_keys
from .texel_map import TexelMap

_SMOOTH = math.cos(math.radians(10))  # of the angle between two normals at one place, to be one surface
_STEPS = 64  # triangles crossed at most
_FLAT = 1e-9  # square texels: triangles with less area lead nowhere
_SLACK = 1e-9  # of a triangle's doubled area: a point this close to an edge is inside


@dataclass(frozen=True, eq=False)
class Seams:
    """What lies on the other side of each triangle's edges; edge 3 f + k runs from corner k of f to k + 1.

    `beyond` (3F,) is the same edge of the only other triangle that has it, -1 if there is none. `seam` (3F,)
    marks those where an island ends, but the surface goes on: the normals are alike, and the material is one.
    """

    beyond: Ints
    seam: Bools

    @classmethod
    def of(cls, surface: SurfaceMesh) -> Seams:
        """Pair the edges of a surface; triangles meet where their corners have one position."""
        place = weld(surface.position)[surface.triangles].ravel()
        start = np.arange(place.size)
        end = np.roll(start.reshape(-1, 3), -1, axis=1).ravel()
        keys = edge_keys(place.reshape(-1, 3))
        order = np.argsort(keys, kind="stable")
        alike = keys[order][1:] == keys[order][:-1]
        alone = ~np.append(False, alike[:-1]) & ~np.append(alike[1:], False)  # two triangles, not more
        first = np.flatnonzero(alike & alone & (place[start] != place[end])[order][1:])
        one, other = order[first], order[first + 1]
        beyond = np.full(place.size, -1)
        beyond[one], beyond[other] = other, one
        turned = place[one] != place[other]
        ends = (np.where(turned, end[other], other), np.where(turned, other, end[other]))
        uv, normal = surface.uv.reshape(-1, 2), normalised(surface.normal.reshape(-1, 3))
        split = np.zeros(len(one), dtype=bool)
        smooth = surface.material_numbers[one // 3] == surface.material_numbers[other // 3]
        for mine, theirs in zip((one, end[one]), ends, strict=True):
            split |= (uv[mine] != uv[theirs]).any(axis=1)
            smooth &= np.sum(normal[mine] * normal[theirs], axis=1) >= _SMOOTH
        seam = np.zeros(place.size, dtype=bool)
        seam[one] = seam[other] = split & smooth
        beyond[np.concatenate([one[split & ~smooth], other[split & ~smooth]])] = -1
        return cls(beyond, seam)


def beyond_seams(texels: TexelMap, surface: SurfaceMesh, seams: Seams) -> TexelMap:
    """The texel map of `surface` with the points beyond seams, and their frames and triangles.

    A frame there is the island's own, turned to the normal that is met. Texels beside other borders, and
    those whose centres lie in their islands, stay as they are.
    """
    height, width = texels.triangle.shape
    texel = np.flatnonzero(texels.covered & ~texels.inside)
    uv = surface.uv.astype(np.float64) * (width, height)
    centre = np.stack([texel % width, texel // width], axis=1) + 0.5
    edge, along = _nearest_edge(uv, texels.triangle.ravel()[texel], centre)
    some = seams.seam[edge] & np.isfinite(along)
    texel, edge, along, centre = texel[some], edge[some], along[some], centre[some]
    triangle, point, target, fine = _across(surface, uv, seams, edge, along, centre)
    texel, edge, along = texel[fine], edge[fine], along[fine]
    triangle, weight = _walk(uv, seams, triangle[fine], point[fine], target[fine])
    met = weight.any(axis=1)
    return _with_points(texels, surface, texel[met], triangle[met], weight[met])


def _nearest_edge(uv: Floats, triangle: Ints, centre: Floats) -> tuple[Ints, Floats]:
    """Each triangle's edge (K,) that is nearest to a place (K, 2), and how far along it, 0 to 1, that is."""
    corner = uv[triangle]
    side = np.roll(corner, -1, axis=1) - corner
    away = centre[:, None] - corner
    length = np.sum(side**2, axis=-1)
    along = np.clip(
        np.divide(np.sum(away * side, axis=-1), length, out=np.zeros_like(length), where=length > 0), 0, 1
    )
    apart = np.sum((away - along[..., None] * side) ** 2, axis=-1)
    nearest = apart.argmin(axis=1)
    everyone = np.arange(len(triangle))
    return 3 * triangle.astype(np.int64) + nearest, along[everyone, nearest]


def _across(
    surface: SurfaceMesh, uv: Floats, seams: Seams, edge: Ints, along: Floats, centre: Floats
) -> tuple[Ints, Floats, Floats, Bools]:
    """The triangles beyond the edges, where one enters them, and where the centre lies in their own UVs.

    The way from the edge to the centre is unfolded about the edge into the plane of the triangle beyond it.
    The last result marks (K,) those that can be: neither triangle is without area.
    """
    other = seams.beyond[edge]
    place = surface.corner_position.astype(np.float64)
    flat = uv.reshape(-1, 2)
    mine, theirs = edge // 3, other // 3
    flat_ones = _without_area(uv)
    following = 3 * mine + (edge + 1) % 3
    after = 3 * theirs + (other + 1) % 3
    spot = place.reshape(-1, 3)
    turned = np.sum((spot[edge] - spot[other]) ** 2, axis=1) > np.sum((spot[edge] - spot[after]) ** 2, axis=1)
    share = np.where(turned, 1 - along, along)[:, None]
    start = flat[edge] + along[:, None] * (flat[following] - flat[edge])
    entry = flat[other] + share * (flat[after] - flat[other])
    way = np.einsum("kxu,ku->kx", _slopes(place[mine], uv[mine]), centre - start)
    line = normalised(spot[following] - spot[edge])
    ahead = np.sum(way * line, axis=1, keepdims=True)
    out = np.linalg.norm(way - ahead * line, axis=1, keepdims=True)
    third = place[theirs].sum(axis=1) - spot[other] - spot[after]
    inwards = third - spot[other]
    inwards = normalised(inwards - np.sum(inwards * line, axis=1, keepdims=True) * line)
    target = entry + np.einsum(
        "kux,kx->ku", _slopes_back(place[theirs], uv[theirs]), ahead * line + out * inwards
    )
    fine: Bools = np.isfinite(target).all(axis=1) & ~flat_ones[mine] & ~flat_ones[theirs]
    return theirs, entry, target, fine


def _without_area(uv: Floats) -> Bools:
    """Which triangles (F, 3, 2) have no area to speak of, in texels: (F,)."""
    flat: Bools = ~(np.abs(signed_areas(uv)) > _FLAT)
    return flat


def _slopes(place: Floats, uv: Floats) -> Floats:
    """How positions change with UV in triangles (K, 3, 3) of uv (K, 3, 2): (K, 3, 2), NaN without area."""
    one, two = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    inverse = np.stack(
        [np.stack([two[:, 1], -two[:, 0]], axis=1), np.stack([-one[:, 1], one[:, 0]], axis=1)], axis=1
    )
    inverse /= np.where(area == 0, np.nan, area)[:, None, None]
    found: Floats = np.stack([place[:, 1] - place[:, 0], place[:, 2] - place[:, 0]], axis=2) @ inverse
    return found


def _slopes_back(place: Floats, uv: Floats) -> Floats:
    """How UV changes with positions in the triangles' planes: (K, 2, 3), NaN without area."""
    slopes = _slopes(place, uv)
    square = slopes.transpose(0, 2, 1) @ slopes
    (a, b), (_, d) = square.transpose(1, 2, 0)
    determinant = a * d - b * b
    adjoint = np.stack([np.stack([d, -b], axis=1), np.stack([-b, a], axis=1)], axis=1)
    found: Floats = adjoint @ slopes.transpose(0, 2, 1)
    found /= np.where(determinant > 0, determinant, np.nan)[:, None, None]
    return found


def _walk(uv: Floats, seams: Seams, triangle: Ints, point: Floats, target: Floats) -> tuple[Ints, Floats]:
    """Go straight from points to targets (K, 2) within an island: the triangles reached, and weights (K, 3).

    Where the island ends before, the way ends there, too.
    """
    triangle, point = triangle.copy(), point.copy()
    flat = _without_area(uv)
    walking = np.arange(len(triangle))
    for _ in range(_STEPS):
        corner = uv[triangle[walking]]
        ends = _sides(corner, target[walking])
        outside = ends < -_SLACK * np.abs(ends.sum(axis=1, keepdims=True))
        left = outside.any(axis=1)
        point[walking[~left]] = target[walking[~left]]
        walking, ends, outside, corner = walking[left], ends[left], outside[left], corner[left]
        if not len(walking):
            break
        begins = np.maximum(_sides(corner, point[walking]), 0)
        share = np.where(outside, begins / np.where(outside, begins - ends, 1), np.inf)
        leaving = share.argmin(axis=1)
        point[walking] += share.min(axis=1)[:, None] * (target[walking] - point[walking])
        edge = 3 * triangle[walking] + leaving
        inner = (seams.beyond[edge] >= 0) & ~seams.seam[edge] & ~flat[seams.beyond[edge] // 3]
        walking = walking[inner]
        triangle[walking] = seams.beyond[edge[inner]] // 3
    sides = np.maximum(_sides(uv[triangle], point), 0)
    weight = np.roll(sides, -1, axis=1)
    return triangle, weight / np.maximum(weight.sum(axis=1, keepdims=True), 1e-300)


def _sides(corner: Floats, point: Floats) -> Floats:
    """Twice the area between each edge and the point, positive within the triangle: (K, 3)."""
    side, away = np.roll(corner, -1, axis=1) - corner, point[:, None] - corner
    area = side[..., 0] * away[..., 1] - side[..., 1] * away[..., 0]
    found: Floats = area * np.sign(area.sum(axis=1, keepdims=True))
    return found


def _with_points(
    texels: TexelMap, surface: SurfaceMesh, texel: Ints, triangle: Ints, weight: Floats
) -> TexelMap:
    """The texel map with the points of `weight` (K, 3) in triangles (K,) in the texels (K,)."""
    position, normal, tangent, facet = (
        field.reshape(-1, 3).copy()
        for field in (texels.position, texels.normal, texels.tangent, texels.facet)
    )
    owner = texels.triangle.copy()
    met = normalised(np.einsum("kc,kcx->kx", weight, surface.normal[triangle]))
    met = np.where(met.any(axis=1, keepdims=True), met, normal[texel])
    carried = _turned(tangent[texel].astype(np.float64), normal[texel].astype(np.float64), met)
    sign = texels.sign.ravel()[texel]
    corner = surface.corner_position[triangle].astype(np.float64)
    position[texel] = np.einsum("kc,kcx->kx", weight, corner)
    tangent[texel], _, normal[texel] = orthonormal_frame(met, carried, sign)
    own = normalised(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    own = np.where(own.any(axis=1, keepdims=True), own, met)
    facet[texel] = np.where(np.sum(own * met, axis=1, keepdims=True) < 0, -own, own)
    owner.ravel()[texel] = triangle
    shape = texels.position.shape
    return replace(
        texels,
        position=position.reshape(shape),
        normal=normal.reshape(shape),
        tangent=tangent.reshape(shape),
        facet=facet.reshape(shape),
        triangle=owner,
        touching=texels.triangle,
    )


def _turned(vector: Floats, before: Floats, after: Floats) -> Floats:
    """Vectors (K, 3) turned by the least rotation from unit vectors `before` to `after` (K, 3).

    Rodrigues's rotation formula, with the sine in the axis's length; for angles below 180 degrees.
    """
    axis = np.cross(before, after)
    cosine = np.sum(before * after, axis=1, keepdims=True)
    along = np.sum(axis * vector, axis=1, keepdims=True) / np.maximum(1 + cosine, 1e-6)
    turned: Floats = cosine * vector + np.cross(axis, vector) + along * axis
    return turned
