# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object shows of itself, computed: along rays that meet it, by what the fit says of that place.

No light is traced for it, so there is no noise; light that was mirrored more often comes in with each turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np

from ....bake.plan import CapturePlan
from ....bake.pooling import Neighbours, corner_cells, corners
from ....core.arrays import Floats, Ints
from ....core.octahedron import direction_to_octahedron
from ..lookup.atlas import mirrored_light
from ..lookup.environment import Around
from ..lookup.falloffs import falloff_at
from ..lookup.lobes import Material
from ..samples import OwnRays

_TURNS = 2
_GRAZING = 0.02  # N.V, below which a texel does not face a ray
_NEAR = 0.25  # how much rays of neighbouring texels count for against the texel's own
_PRIOR = 1e-3  # rays that the wider neighbourhood's mean counts for
_AT_ONCE = 1 << 17


@dataclass(frozen=True, eq=False)
class Surface:
    """What the fit says of the plan's texels so far.

    `normal` (K, 3), the shading normals; `diffuse` (K, 3), along the normal, and its `falloff` by material;
    `tint` (K, 3), `width` (K,), what lobes' width² is multiplied by; `material` (K,); `free` (1, K, n*n), the
    kept mask.
    """

    plan: CapturePlan
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
    def cells(self) -> int:
        return math.isqrt(self.free.shape[2])


def own_light(surface: Surface, own: OwnRays, neighbours: Neighbours) -> Floats:
    """The light that comes from the object itself, by texel and direction: (3, K, n*n)."""
    texels, cells = surface.free.shape[1:]
    texel, axis, place = _rays_that_hit(own)
    if not len(texel):
        return np.zeros((3, texels, cells), dtype=np.float32)
    met = own.met
    faces = -(surface.normal[met] * axis).sum(axis=1) > _GRAZING
    seen = _Seen.of(surface, own.place, axis, met)
    corner, weights = corners(place, surface.cells)
    cell = corner_cells(surface.cells).take(corner, axis=1) + texel * cells
    weights = weights * faces

    def sums(values: Floats) -> Floats:
        flat = np.bincount(cell.ravel(), (weights * values).ravel(), texels * cells)
        return cast(Floats, flat.reshape(texels, cells).astype(np.float32))

    count = sums(np.ones(len(texel), dtype=np.float32))
    light = np.zeros((3, texels, cells), dtype=np.float32)
    for turn in range(_TURNS):
        arriving = seen.light(light if turn else None)
        table = np.stack([*(sums(channel) for channel in arriving), count])
        near, wide = neighbours.pool(table), neighbours.pool(table, True)
        prior = wide[:3] / np.maximum(wide[3], 1e-6)
        light = (table[:3] + _NEAR * near[:3] + _PRIOR * prior) / (count + _NEAR * near[3] + _PRIOR)
    return light.astype(np.float32)


def _rays_that_hit(own: OwnRays) -> tuple[Ints, Floats, Floats]:
    """Texels (P,), axes (P, 3) and places on the octahedron (2, P) of the rays that hit."""
    texel, number = np.nonzero(own.hit)
    axis, place = np.empty((len(texel), 3), np.float32), np.empty((2, len(texel)), np.float32)
    step = 256
    cuts = np.searchsorted(texel, np.arange(0, len(own.hit) + step, step))
    for block, first in enumerate(range(0, len(own.hit), step)):
        some = slice(cuts[block], cuts[block + 1])
        if some.start < some.stop:
            axes, places = own.rays.along(slice(first, min(first + step, len(own.hit))))
            axis[some] = axes[:, texel[some] - first, number[some]].T
            place[:, some] = places[:, texel[some] - first, number[some]]
    return texel, axis, place


@dataclass(frozen=True, eq=False)
class _Seen:
    """What rays see where they meet texels: `direct` light (3, P), and the `share` (3, P) of own light.

    `met` (P,) are the texels, `cells` (4, P) and `weights` (4, P) tell where in their buckets they are seen.
    """

    direct: Floats
    share: Floats
    met: Ints
    cells: Ints
    weights: Floats

    @classmethod
    def of(cls, surface: Surface, place: Floats, axis: Floats, met: Ints) -> _Seen:
        normal = surface.normal[met]
        cosine = -(normal * axis).sum(axis=1)
        mirrored = (axis + 2 * cosine[:, None] * normal).astype(np.float32)
        cosine = np.clip(cosine, 1e-3, 1)
        corner, weights = corners(direction_to_octahedron(mirrored).T, surface.cells)
        cells = corner_cells(surface.cells).take(corner, axis=1)
        free = (surface.free[0][met[None], cells] * weights).sum(axis=0)
        direct = (surface.diffuse[met] * falloff_at(surface.falloff, surface.material[met], cosine)).T
        share = np.empty_like(direct)
        for first in range(0, len(met), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            offset = place[some] - surface.around.middle
            shown, share[:, some] = mirrored_light(
                surface.around, surface.materials, offset, mirrored[some], normal[some], cosine[some],
                surface.material[met[some]], surface.width[met[some]], free[some], surface.cells,
            )  # fmt: skip
            direct[:, some] += shown * surface.tint[met[some]].T
            share[:, some] *= surface.tint[met[some]].T
        return cls(direct, share, met, cells, weights)

    def light(self, own: Floats | None) -> Floats:
        """What the rays bring, (3, P), if texels see `own` (3, K, n*n) of the object."""
        if own is None:
            return self.direct
        again = (own[:, self.met[None], self.cells] * self.weights).sum(axis=1)
        return cast(Floats, self.direct + self.share * again)
