# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object shows of itself, computed: along rays that meet it, by what the fit says of that place.

No light is traced for it, so there is no noise. What is mirrored by the place that is met comes by what the
object shows there of itself, in buckets of light that was mirrored once.
Where rays meet parts of a split object that have other atlases, traced light is all that is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ....bake.blocks import SAMPLES_AT_ONCE, in_blocks, planes
from ....bake.light_samples import Some, mirrored
from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints
from ..lookup.atlas import mirrored_light
from ..lookup.environment import Around, Lit
from ..lookup.lobes import Material, falloff_at, shown_at
from ..lookup.ray_ends import lamp_light, light_of
from ..samples import OwnRays
from .bucket_grid import Block, BucketGrid
from .rows import Places
from .turned import octahedral

_GRAZING = 0.02  # N.V, below which a texel does not face a ray
_SHARP = 2e-3  # width², radians²: what cells do not tell from none
_PRIOR = 1e-3  # rays that the wider neighbourhood's mean counts for
_ASKED_AT_ONCE = 1 << 18  # rays, of which few may meet the object


@dataclass(frozen=True, eq=False)
class Surface:
    """What the fit says of the plan's texels so far.

    `normal` (K, 3), the shading normals; `diffuse` (K, 3), before the `falloff`, which is by material;
    `tint` (K, 3), `width` (K,), what lobes' width² is multiplied by; `material` (K,); `free` (1, B, n*n), the
    kept mask, of the `grid`'s buckets. `lit`: by how much light falls on the texels, None for any. `tangent`
    (K, 3): along what they are brushed, None if none is.
    """

    grid: BucketGrid
    normal: Floats
    diffuse: Floats
    falloff: Floats
    tint: Floats
    width: Floats
    material: Ints
    materials: tuple[Material, ...]
    around: Around
    free: Floats
    lit: Lit | None = None
    tangent: Floats | None = None

    @property
    def plan(self) -> CapturePlan:
        return self.grid.plan

    @property
    def cells(self) -> int:
        return math.isqrt(self.free.shape[2])

    def lit_at(self, texels: Ints) -> Lit | None:
        """`lit` at some texels."""
        return None if self.lit is None else self.lit.some(texels)

    def tangent_at(self, texels: Ints) -> Floats | None:
        """`tangent` at some texels."""
        return None if self.tangent is None else self.tangent[texels]


@dataclass(frozen=True, eq=False)
class OwnLight:
    """What rays that meet the object bring, P of them, by their `place` on the octahedron: `light` (3, P).

    Each of the plan's K texels has `count` (K,) rays, from `start` (K,) on. `faces` (P,): 1 where what is met
    faces the ray, else 0; such rays tell nothing.
    """

    start: Ints
    count: Ints
    place: Places
    faces: Floats
    light: Floats

    def buckets(self, grid: BucketGrid, cells: int) -> Floats:
        """The light that comes from the object itself, by bucket and direction: (3, B, cells * cells)."""
        table = large_arrays.empty((4, len(grid), cells * cells))

        def sum_up(block: Block) -> None:
            row, ray = self._rays(block.texels)
            faces = self.faces[ray]
            columns = [*(faces * channel for channel in self.light.take(ray, axis=1)), faces]
            rays = Block(block.buckets, block.texels[row], block.bucket[row])
            table[:, block.buckets] = rays.scatter(self.place[ray], cells, columns)

        each = max(cells * cells // 2, len(self.faces) // len(self.count))  # few rays take cells nonetheless
        grid.in_blocks(sum_up, each)
        return large_arrays.copied(grid.pool(table, grid.neighbours.pool_further, _mean_light))

    def _rays(self, texels: Ints) -> tuple[Ints, Ints]:
        """The rays of some texels (k,): of which of these they are, and their numbers, both (Q,)."""
        count = self.count[texels]
        row = np.arange(len(texels)).repeat(count)
        first = self.start[texels] - (np.cumsum(count) - count)
        return row, np.arange(len(row)) + first[row]


def own_light(surface: Surface, own: OwnRays) -> OwnLight | None:
    """What rays that meet the object bring, as the fit knows its surface so far; None where none does."""
    if not len(own.met):
        return None
    met = _Met.of(surface, own)
    met.in_blocks(met.look)
    once = OwnLight(met.start, met.count, met.place, met.faces, met.light)
    by_bucket = once.buckets(surface.grid, surface.cells)
    met.in_blocks(lambda some: met.add(some, by_bucket))
    return once


def _mean_light(own: Floats, wide: Floats) -> Floats:
    """The light (3, B, m) of sums of light and of rays, (4, B, m)."""
    prior = wide[:3] / np.maximum(wide[3], 1e-6)
    found: Floats = (own[:3] + _PRIOR * prior) / (own[3] + _PRIOR)
    return found


@dataclass(frozen=True, eq=False)
class _Met:
    """The places that rays meet; fields as in `OwnLight`. `share` (3, P): what they mirror of the object."""

    surface: Surface
    own: OwnRays
    start: Ints
    count: Ints
    place: Places
    faces: Floats
    light: Floats
    share: Floats

    @classmethod
    def of(cls, surface: Surface, own: OwnRays) -> _Met:
        """With nothing looked up yet."""
        count = np.count_nonzero(own.hit, axis=1)
        start = np.cumsum(count) - count
        rays = len(own.met)
        light, share = (large_arrays.zeros((3, rays)) for _ in range(2))
        return cls(surface, own, start, count, Places((rays,)), large_arrays.zeros(rays), light, share)

    def in_blocks(self, function: Callable[[slice], None]) -> None:
        """Run the function on blocks of texels that have enough rays."""
        asked = SAMPLES_AT_ONCE * self.own.hit.size // len(self.own.met)
        texels, rays = self.own.hit.shape
        in_blocks(function, texels, rays, min(asked, _ASKED_AT_ONCE))

    def look(self, some: slice) -> None:
        """Look the light at the places up, without what the object mirrors there of itself."""
        rays = self._rays(some)
        if rays.start == rays.stop:
            return
        axis, met = self._axis(some), self.own.met[rays]
        self.place.keep(rays, octahedral(axis))
        if self.own.light is None:
            self.faces[rays], self.light[:, rays], self.share[:, rays] = self._shown(rays, axis, met)
            return
        there, light = np.flatnonzero(met >= 0), self._apart(some, rays, axis)
        told = np.isfinite(light[0])
        self.faces[rays], self.light[:, rays] = told, np.where(told, light, 0)
        if len(there):
            found = self._shown(rays.start + there, axis[:, there], met[there])
            for kept, shown in zip((self.faces, self.light, self.share), found, strict=True):
                kept[..., rays.start + there] = shown

    def _shown(self, rays: Some, axis: Floats, met: Ints) -> tuple[Bools, Floats, Floats]:
        """Of rays along axes (3, Q) that meet texels (Q,): `faces`, `light` and `share`."""
        surface, around = self.surface, self.surface.around
        mirrored, normal, cosine = self._mirrored(axis, met)
        faces = cosine > _GRAZING
        cosine = np.clip(cosine, 1e-3, 1)
        free = self._at(surface.free, met, mirrored)[0]
        offset = planes(self.own.place[rays] - around.middle)
        shown, share = mirrored_light(
            around, surface.materials, offset.T, mirrored.T, normal.T,
            cosine, surface.material[met], surface.width[met], free, surface.cells,
            surface.lit_at(met), tangent=surface.tangent_at(met),
        )  # fmt: skip
        diffuse = surface.diffuse[met] * falloff_at(surface.falloff, surface.material[met], cosine)
        tint = shown_at(
            surface.materials, surface.material[met], cosine, surface.tint[met], surface.width[met]
        ).T
        return faces, diffuse.T + shown * tint, share * tint

    def _apart(self, some: slice, rays: slice, axis: Floats) -> Floats:
        """The light (3, Q) of some texels' rays that meet no texel, NaN where nothing tells it."""
        assert self.own.light is not None
        light = self.own.light[rays].T.copy()
        if self.own.misled is None:
            return light
        around, surface = self.surface.around, self.surface
        row, number = np.nonzero(self.own.hit[some])
        misled = self.own.misled[some][row, number]
        texels = some.start + row[misled]
        offset = (surface.plan.points[texels] - around.middle).astype(np.float32)
        place = (self.own.place[rays][misled] - around.middle).astype(np.float32)
        about = axis[:, misled].T.astype(np.float32)
        variance = self._variance(texels, about)
        shown, known = light_of(around, offset, about, place, variance)
        lamps, met = lamp_light(around, offset, about, place, variance, surface.lit_at(texels))
        traced = np.where(met, np.float32(np.nan), light[:, misled])  # lamps are added, without their noise
        light[:, misled] = np.where(known, shown, traced) + lamps
        return light

    def _variance(self, texels: Ints, axis: Floats) -> Floats:
        """The lobes' mean variances (M,) where texels (M,) mirror what lies along axes (M, 3)."""
        surface = self.surface
        cosine = np.clip((surface.normal[texels] * axis).sum(axis=1), 1e-3, 1)
        variance = np.empty(len(texels), dtype=np.float32)
        for number, material in enumerate(surface.materials):
            some = surface.material[texels] == number
            if some.any():
                variance[some] = material.mean_variance(cosine[some])
        found: Floats = np.maximum(variance * surface.width[texels], _SHARP).astype(np.float32)
        return found

    def add(self, some: slice, by_bucket: Floats) -> None:
        """Add what the places mirror of the object, which its buckets (3, B, n*n) show."""
        rays = self._rays(some)
        if rays.start == rays.stop:
            return
        met = self.own.met[rays]
        mirrored, *_ = self._mirrored(self._axis(some), met)
        self.light[:, rays] += self.share[:, rays] * self._at(by_bucket, met, mirrored)

    def _rays(self, some: slice) -> slice:
        last = some.stop - 1
        return slice(int(self.start[some.start]), int(self.start[last] + self.count[last]))

    def _axis(self, some: slice) -> Floats:
        """The axes (3, Q) of some texels' rays."""
        row, number = np.nonzero(self.own.hit[some])
        square = self.own.rays.square[some][row, number][:, None]
        return planes(mirrored(self.surface.plan, square, some.start + row)[:, 0])

    def _mirrored(self, axis: Floats, met: Ints) -> tuple[Floats, Floats, Floats]:
        """Mirror directions (3, Q) where rays meet texels, the normals (3, Q) and N.V there (Q,)."""
        normal = planes(self.surface.normal[met])
        cosine: Floats = -(normal * axis).sum(axis=0)
        return (axis + 2 * cosine * normal).astype(np.float32, copy=False), normal, cosine

    def _at(self, table: Floats, texels: Ints, axis: Floats) -> Floats:
        """Look a table (C, B, n*n) up at texels and axes (3, Q): (C, Q)."""
        place = octahedral(axis)[..., None]
        return self.surface.grid.gather(table, place, texels)[..., 0]
