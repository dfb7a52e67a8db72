# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The G-buffer of a baked mesh: what a shader would know where a camera's rays meet it.

Row 0 is at the top; rays are ordered by (row, column, subsample's row, subsample's column).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ..core.arrays import Ints
from ..core.fragments import Fragments
from ..core.frame import orthonormal_frame, to_frame
from ..core.uv_map import UvMap
from ..scene.mesh.backs import fronts, twin_numbers
from ..scene.mesh.copy import NORMAL, SIGN, TANGENT, material_numbers
from .metrics import Mask, Picture

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CameraRays:
    """A camera's rays: N = `pixels`² `subsamples`² of them, for a square picture.

    They start at `origin` (3,), or (N, 3) if each has its own, as mirrored rays have; `away` (N, 3) are their
    unit directions. All in world space.
    """

    pixels: int
    subsamples: int
    origin: Array
    away: Array

    @classmethod
    def of_camera(
        cls, place: npt.ArrayLike, turn: npt.ArrayLike, half: float, pixels: int, subsamples: int
    ) -> CameraRays:
        """Rays through the centres of each pixel's subsamples.

        `place` (3,) and the rotation `turn` (3, 3) are the camera's, which looks along its own −z; `half` is
        the tangent of half its angle of view.
        """
        count = pixels * subsamples
        steps = ((np.arange(count) + 0.5) / count * 2 - 1) * half
        x, y = np.meshgrid(steps, -steps)
        local = np.stack([x, y, -np.ones_like(x)], axis=2)
        local = local.reshape(pixels, subsamples, pixels, subsamples, 3).swapaxes(1, 2).reshape(-1, 3)
        away = local @ np.array(turn, dtype=np.float64).T
        unit = away / np.linalg.norm(away, axis=1, keepdims=True)
        return cls(pixels, subsamples, np.array(place, dtype=np.float64), unit)


@dataclass(frozen=True, eq=False)
class GBuffer:
    """The mesh's surface where N rays first meet it; zeros where they do not.

    `hit` (N,) bool; `position` (N, 3), in world space; `normal`, `tangent`, `bitangent` (N, 3), the
    orthonormal frame that the preview makes there, in world space; `sign` (N,), the bitangent's, ±1; `uv`
    (N, 2), of the baked layer; `incoming` (N, 3), unit, towards the viewer in world space; `triangle` (N,),
    of the baked mesh, `barycentric` (N, 3) in it, and `material` (N,), its material's number. `pixels` is the
    side of the picture.
    """

    pixels: int
    hit: npt.NDArray[np.bool_]
    position: Array
    normal: Array
    tangent: Array
    bitangent: Array
    sign: Array
    uv: Array
    incoming: Array
    triangle: Indices
    barycentric: Array
    material: Ints

    @cached_property
    def incidence(self) -> Array:
        """`incoming` in the frame (T, Bt, N): (N, 3)."""
        incidence = to_frame(self.incoming, self.tangent, self.bitangent, self.normal)
        return incidence.astype(np.float64, copy=False)

    @property
    def fragments(self) -> Fragments:
        """Where the rays hit, for lookups."""
        hit = self.hit
        return Fragments(
            uv=self.uv[hit],
            normal=self.normal[hit],
            viewer=self.incoming[hit],
            position=self.position[hit],
            material=self.material[hit],
            tangent=self.tangent[hit],
            bitangent=self.bitangent[hit],
        )

    @property
    def inside(self) -> Mask:
        """Pixels that the mesh covers wholly, (pixels, pixels)."""
        covered: Mask = self.hit.reshape(self.pixels, self.pixels, -1).all(axis=2)
        return covered

    @property
    def eroded(self) -> Mask:
        """`inside` without its outermost pixels."""
        return eroded(self.inside)

    def spread(self, values: npt.NDArray[np.floating[Any]]) -> Array:
        """Expand values (hits, C) of the rays that hit to all rays: (N, C), zero for those that miss."""
        return _spreader(self.hit)(values)

    def resolve(self, radiance: Array) -> Picture:
        """The picture of radiance (N, 3) along the rays: each pixel's mean over those that hit."""
        seen = self.hit.reshape(self.pixels, self.pixels, -1, 1)
        total = np.where(seen, radiance.reshape(self.pixels, self.pixels, -1, 3), 0).sum(axis=2)
        picture: Picture = total / np.maximum(seen.sum(axis=2), 1)
        return picture


def eroded(mask: Mask) -> Mask:
    """A mask (H, W) without the pixels that have one of their four neighbours outside it or the picture."""
    inner = np.zeros_like(mask)
    middle = mask[1:-1, 1:-1] & mask[:-2, 1:-1] & mask[2:, 1:-1] & mask[1:-1, :-2] & mask[1:-1, 2:]
    inner[1:-1, 1:-1] = middle
    return inner


class BakedSurface:
    """A baked copy's mesh, ready for ray casting; keeps no references to Blender's data."""

    def __init__(self, mesh: bpy.types.Mesh, matrix_world: npt.ArrayLike, uv_layer: str) -> None:
        """Copy the triangles, frame and UVs of a `mesh` of `baked_mesh`, placed by `matrix_world` (4, 4)."""
        matrix = np.array(matrix_world, dtype=np.float64)
        self._matrix = matrix[:3, :3]
        self.place = _values(mesh.vertices, "co", 3) @ self._matrix.T + matrix[:3, 3]
        self._corner = _values(mesh.loops, "vertex_index", 1).astype(np.int64).reshape(-1, 3)
        self._twin = twin_numbers(mesh)
        # of several objects that were joined, each has its twins behind its own triangles
        self._met = np.arange(len(self._corner)) if self._twin is None else np.flatnonzero(fronts(self._twin))
        met = self._corner[self._met].tolist()
        tree = BVHTree.FromPolygons(self.place.tolist(), met, all_triangles=True)
        self._tree = cast(BVHTree, tree)
        fields = {NORMAL: ("vector", 3), TANGENT: ("vector", 3), SIGN: ("value", 1), uv_layer: ("vector", 2)}
        attributes = cast(Any, mesh).attributes
        normal, tangent, sign, uv = (
            _values(attributes[name].data, field, width).reshape(-1, 3, width)
            for name, (field, width) in fields.items()
        )
        self._material = material_numbers(mesh)
        self._normal, self._tangent, self._sign, self._uv = normal, tangent, sign, uv

    def uv_map(self, width: int, height: int) -> UvMap:
        """The map of all triangles on an atlas of so many texels."""
        return UvMap(self.place[self._corner], self._uv, width, height)

    def gbuffer(self, rays: CameraRays, blocked: Array) -> GBuffer:
        """The G-buffer of rays that meet the mesh before the distances (N,) where they are `blocked`."""
        place, corner = self.place, self._corner
        near = self._around(rays)
        triangle = np.full(len(rays.away), -1, dtype=np.int64)
        origin = np.broadcast_to(rays.origin, rays.away.shape)
        triangle[near] = _first_met(self._tree, origin[near], rays.away[near])
        hit = triangle >= 0
        triangle[hit] = self._met[triangle[hit]]
        if self._twin is not None:
            triangle[hit] = self._facing(triangle[hit], rays.away[hit], self._twin)
        distance, weights = _meet(origin[hit], rays.away[hit], place[corner[triangle[hit]]])
        kept = distance < blocked[hit]
        hit[hit] = kept
        triangle[~hit] = 0
        distance, weights = distance[kept], weights[kept]

        def at_hits(values: Array) -> Array:
            mixed: Array = np.einsum("kc,kcw->kw", weights, values[triangle[hit]])
            return mixed

        mirrored = -1.0 if np.linalg.det(self._matrix) < 0 else 1.0
        sign = np.sign(at_hits(self._sign)[:, 0]) * mirrored
        tangent, bitangent, normal = orthonormal_frame(
            at_hits(self._normal) @ np.linalg.inv(self._matrix), at_hits(self._tangent) @ self._matrix.T, sign
        )
        spread = _spreader(hit)
        return GBuffer(
            pixels=rays.pixels,
            hit=hit,
            position=spread(origin[hit] + rays.away[hit] * distance[:, None]),
            normal=spread(normal),
            tangent=spread(tangent),
            bitangent=spread(bitangent),
            sign=spread(sign[:, None])[:, 0],
            uv=spread(at_hits(self._uv)),
            incoming=spread(-rays.away[hit]),
            triangle=triangle,
            barycentric=spread(weights),
            material=np.where(hit, self._material[triangle], 0).astype(np.int32),
        )

    def _facing(self, triangle: Indices, away: Array, twin: Ints) -> Indices:
        """Replace triangles (K,) that rays meet from behind by their twins, where they have one."""
        behind = self._behind(triangle, away) & (twin[triangle] >= 0)
        return np.where(behind, twin[triangle], triangle)

    def culled(self, triangle: Indices, away: Array) -> npt.NDArray[np.bool_]:
        """Which triangles (K,) engines do not draw along rays `away` (K, 3), as only fronts are drawn."""
        if self._twin is None:
            return np.zeros(len(triangle), dtype=bool)
        return self._behind(triangle, away)

    def _behind(self, triangle: Indices, away: Array) -> npt.NDArray[np.bool_]:
        """Which triangles (K,) rays meet from behind."""
        first, second, third = self.place[self._corner[triangle]].transpose(1, 0, 2)
        normal = np.cross(second - first, third - first)
        if np.linalg.det(self._matrix) < 0:
            normal = -normal
        behind: npt.NDArray[np.bool_] = np.einsum("ki,ki->k", normal, away) > 0
        return behind

    def _around(self, rays: CameraRays) -> npt.NDArray[np.bool_]:
        """Which rays can meet the mesh: those within the cone of its vertices, if they have one origin."""
        if rays.origin.ndim > 1:
            return np.ones(len(rays.away), dtype=bool)
        towards = self.place - rays.origin
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        axis = towards.mean(axis=0)
        within: npt.NDArray[np.bool_] = rays.away @ axis >= (towards @ axis).min() - 1e-4
        return within


def _spreader(hit: npt.NDArray[np.bool_]) -> Callable[[npt.NDArray[np.floating[Any]]], Array]:
    def spread(values: npt.NDArray[np.floating[Any]]) -> Array:
        every = np.zeros((len(hit), values.shape[1]))
        every[hit] = values
        return every

    return spread


def _values(items: Any, field: str, width: int) -> Array:
    values = np.empty(len(items) * width, dtype=np.float32 if field != "vertex_index" else np.int32)
    items.foreach_get(field, values)
    return values.reshape(-1, width).astype(np.float64)


def _first_met(tree: BVHTree, origin: Array, away: Array) -> Indices:
    cast_ray = tree.ray_cast
    starts = map(Vector, origin.tolist())
    met = (cast_ray(start, direction)[2] for start, direction in zip(starts, away.tolist(), strict=True))
    return np.fromiter((-1 if index is None else index for index in met), np.int64, len(away))


def _meet(origin: Array, away: Array, corners: Array) -> tuple[Array, Array]:
    """Distances (K,) and barycentric weights (K, 3) where rays meet the triangles (K, 3, 3) they hit."""
    first, second, third = corners[:, 0], corners[:, 1], corners[:, 2]
    along, across = second - first, third - first
    normal = np.cross(away, across)
    scale = 1 / np.einsum("ki,ki->k", along, normal)
    offset = origin - first
    u = np.einsum("ki,ki->k", offset, normal) * scale
    turned = np.cross(offset, along)
    v = np.einsum("ki,ki->k", away, turned) * scale
    distance = np.einsum("ki,ki->k", across, turned) * scale
    weights = np.clip(np.stack([1 - u - v, u, v], axis=1), 0, 1)  # float32 rounds some below 0
    return distance, weights / weights.sum(axis=1, keepdims=True)
