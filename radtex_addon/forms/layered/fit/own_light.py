# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object shows of itself, computed: along rays that meet it, by what the fit says of that place.

No light is traced for it, so there is no noise; light that was mirrored more often comes in with each turn.
Where rays meet parts of a split object that have other atlases, traced light is all that is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.light_samples import mirrored
from ....bake.plan import CapturePlan
from ....core.arrays import Floats, Ints
from ....core.octahedron import direction_to_octahedron
from ..lookup.atlas import mirrored_light
from ..lookup.environment import Around
from ..lookup.falloffs import falloff_at
from ..lookup.lobes import Material
from ..samples import OwnRays
from .bucket_grid import Block, BucketGrid

_TURNS = 2
_GRAZING = 0.02  # N.V, below which a texel does not face a ray
_PRIOR = 1e-3  # rays that the wider neighbourhood's mean counts for


@dataclass(frozen=True, eq=False)
class Surface:
    """What the fit says of the plan's texels so far.

    `normal` (K, 3), the shading normals; `diffuse` (K, 3), along the normal, and its `falloff` by material;
    `tint` (K, 3), `width` (K,), what lobes' width² is multiplied by; `material` (K,); `free` (1, B, n*n), the
    kept mask, of the `grid`'s buckets.
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

    @property
    def plan(self) -> CapturePlan:
        return self.grid.plan

    @property
    def cells(self) -> int:
        return math.isqrt(self.free.shape[2])


def own_light(surface: Surface, own: OwnRays) -> Floats:
    """The light that comes from the object itself, by bucket and direction: (3, B, n*n)."""
    grid, cells = surface.grid, surface.free.shape[2]
    light = np.zeros((3, len(grid), cells), dtype=np.float32)
    if not len(own.met):
        return light
    seen = _Seen.of(surface, own)
    for turn in range(_TURNS):
        table = np.empty((4, len(grid), cells), dtype=np.float32)

        def sum_up(block: Block, turn: int = turn, table: Floats = table, light: Floats = light) -> None:
            hits = seen.hits(block.texels)
            arriving = seen.light(hits, light if turn else None)
            own = Block(block.buckets, block.texels[hits.row], block.bucket[hits.row])
            columns = [*(hits.faces * channel for channel in arriving), hits.faces]
            table[:, block.buckets] = own.scatter(hits.place, surface.cells, columns)

        grid.in_blocks(sum_up, own.hit.shape[1])
        light = grid.pool(table, grid.neighbours.pool_further, _mean_light)
    return light.copy()


def _mean_light(own: Floats, wide: Floats) -> Floats:
    """The light (3, B, m) of sums of light and of rays, (4, B, m)."""
    prior = wide[:3] / np.maximum(wide[3], 1e-6)
    found: Floats = (own[:3] + _PRIOR * prior) / (own[3] + _PRIOR)
    return found


@dataclass(frozen=True, eq=False)
class _Hits:
    """The rays of some texels that meet the object, Q of them.

    `row` (Q,): of which of these texels; `ray` (Q,): its number among all P; `axis` (Q, 3); `place` (2, Q),
    on the octahedron's square; `faces` (Q,): 1 where what is met faces the ray, else 0.
    """

    row: Ints
    ray: Ints
    axis: Floats
    place: Floats
    faces: Floats


@dataclass(frozen=True, eq=False)
class _Seen:
    """What rays see where they meet texels: `direct` light (3, P), and the `share` (3, P) of own light.

    The texels' rays begin at `start` (K,).
    """

    surface: Surface
    own: OwnRays
    start: Ints
    direct: Floats
    share: Floats

    @classmethod
    def of(cls, surface: Surface, own: OwnRays) -> _Seen:
        start = np.cumsum(np.count_nonzero(own.hit, axis=1))
        start = np.concatenate([[0], start[:-1]]).astype(np.int64)
        direct, share = (np.zeros((3, len(own.met)), dtype=np.float32) for _ in range(2))
        seen = cls(surface, own, start, direct, share)
        in_blocks(seen._look, *own.hit.shape)
        if own.light is not None:
            apart = own.met < 0
            direct[:, apart], share[:, apart] = own.light[apart].T, 0
        return seen

    def hits(self, texels: Ints) -> _Hits:
        """The rays of some texels (k,) that meet the object."""
        row, number = np.nonzero(self.own.hit[texels])
        first = np.searchsorted(row, np.arange(len(texels)))
        ray = self.start[texels[row]] + np.arange(len(row)) - first[row]
        square = self.own.rays.square[texels][row, number][:, None]
        axis = mirrored(self.surface.plan, square, texels[row])[:, 0]
        met = self.own.met[ray]
        facing = (-(self.surface.normal[met] * axis).sum(axis=1) > _GRAZING) | (met < 0)
        faces = facing.astype(np.float32)
        return _Hits(row, ray, axis, direction_to_octahedron(axis).T, faces)

    def light(self, hits: _Hits, own: Floats | None) -> Floats:
        """What rays bring, (3, Q), if buckets see `own` (3, B, n*n) of the object."""
        direct = self.direct[:, hits.ray]
        if own is None:
            return direct
        met = self.own.met[hits.ray]
        again = self._at(own, met, self._mirrored(hits, met)[0])
        return cast(Floats, direct + self.share[:, hits.ray] * again)

    def _look(self, some: slice) -> None:
        surface, around = self.surface, self.surface.around
        hits = self.hits(np.arange(some.start, some.stop))
        if not len(hits.ray):
            return
        rays = slice(int(hits.ray[0]), int(hits.ray[-1]) + 1)
        met = self.own.met[rays]
        mirrored, cosine = self._mirrored(hits, met)
        cosine = np.clip(cosine, 1e-3, 1)
        free = self._at(surface.free, met, mirrored)[0]
        shown, share = mirrored_light(
            around, surface.materials, self.own.place[rays] - around.middle, mirrored, surface.normal[met],
            cosine, surface.material[met], surface.width[met], free, surface.cells,
        )  # fmt: skip
        diffuse = surface.diffuse[met] * falloff_at(surface.falloff, surface.material[met], cosine)
        self.direct[:, rays] = diffuse.T + shown * surface.tint[met].T
        self.share[:, rays] = share * surface.tint[met].T

    def _mirrored(self, hits: _Hits, met: Ints) -> tuple[Floats, Floats]:
        """The mirror directions (Q, 3) where rays meet texels, and N.V there (Q,)."""
        normal = self.surface.normal[met]
        cosine: Floats = -(normal * hits.axis).sum(axis=1)
        return (hits.axis + 2 * cosine[:, None] * normal).astype(np.float32), cosine

    def _at(self, table: Floats, texels: Ints, axis: Floats) -> Floats:
        """Look a table (C, B, n*n) up at texels and axes: (C, Q)."""
        place = direction_to_octahedron(axis).T[..., None]
        return self.surface.grid.gather(table, place, texels)[..., 0]
