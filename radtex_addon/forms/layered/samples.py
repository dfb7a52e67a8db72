# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the layered layout is fitted to."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...bake.light_samples import EndSamples, LightSamples, LobeSamples
from ...bake.plan import CapturePlan
from ...core import large_arrays
from ...core.arrays import Bools, Floats, Ints
from .fit.light_map import LightMap
from .lookup.distance_field import DistanceField
from .lookup.environment import Around


@dataclass(frozen=True, eq=False)
class ExitSamples:
    """Paths seen in the middles of the plan's cells, S of each: K texels, n * n cells.

    `weight` (S, K, n*n), luminance: how much a path lets through, 0 where it does not enter or is lost.
    `direction` (S, K, n*n, 3), unit: in which it leaves; `place` (S, K, n*n, 3): of all points on the line
    that it leaves along the nearest to the texel, from there. Both in the texel's frame: what is round or
    straight has nearly the same in all texels. `colour` (K, 3): of the paths that get through a texel, with
    a luminance of 1. `field`: the object's own, if rays can be followed through it.
    """

    plan: CapturePlan
    weight: Floats
    direction: Floats
    place: Floats
    colour: Floats
    field: DistanceField | None = None


@dataclass(frozen=True, eq=False)
class OwnRays:
    """Mirror rays of a plan's texels: which `hit` the object, (K, S).

    Of the P rays that do, in the order of `np.nonzero(hit)`: the texel that they have `met` (P,), and the
    `place` where, (P, 3), in world space. Rays that meet a part without texels in this atlas have met -1, and
    bring the `light` (P, 3), one path's; None where there are none.
    `misled` (K, S): which of the rays that hit do not meet the object, but what the layers of surroundings
    would show wrongly; None where none is. They have met -1, and their place is NaN where they end in the
    world. Their light is NaN where no path was traced along them. `asked` (K,): the texels along whose rays
    paths were traced to find that out; None where none were.
    """

    rays: LobeSamples
    hit: Bools
    met: Ints
    place: Floats
    light: Floats | None = None
    misled: Bools | None = None
    asked: Bools | None = None

    @property
    def traced(self) -> int:
        """How many paths were traced: one in each cell of the texels that were `asked` or have `light`."""
        texels = np.zeros(len(self.hit), dtype=bool) if self.asked is None else self.asked.copy()
        if self.light is not None:
            row, _ = np.nonzero(self.hit)
            texels[row[(self.met < 0) & np.isfinite(self.light[:, 0])]] = True
        return int(texels.sum()) * int(self.hit.shape[1])

    @property
    def meets(self) -> Bools:
        """Which rays meet the object, (K, S)."""
        return self.hit if self.misled is None else self.hit & ~self.misled

    def without(self, some: Bools) -> OwnRays:
        """Count `some` (K, S) of the rays that hit as free: the surroundings show what they meet."""
        left = np.flatnonzero(~some[self.hit])
        met, place = large_arrays.taken(self.met, left), large_arrays.taken(self.place, left)
        light = None if self.light is None else large_arrays.taken(self.light, left)
        return replace(self, hit=self.hit & ~some, met=met, place=place, light=light)

    def with_misled(self, misled: Bools, place: Floats, light: Floats, asked: Bools | None) -> OwnRays:
        """Add rays (K, S) that are misled, M of them, each one's `place` (M, 3) and `light`; and `asked`."""
        hit = self.hit | misled
        was = self.hit[hit]
        met = large_arrays.empty(len(was), np.int32)
        places, lights = (large_arrays.zeros((len(was), 3)) for _ in range(2))
        met[:] = -1
        met[was], places[was], places[~was], lights[~was] = self.met, self.place, place, light
        if self.light is not None:
            lights[was] = self.light
        return OwnRays(self.rays, hit, met, places, lights, misled, asked)


@dataclass(frozen=True, eq=False)
class LayeredSamples:
    """What the layered layout is fitted to.

    `light`: single paths. `alone`: paths through the object in an empty world. `own`: mirror rays that meet
    the object itself. `fine` and `coarse`: maps of the diffuse colour, the glossy colour and the shading
    normal, "diffuse", "glossy", "normal", (H', W', 3) and (H, W, 3); where the surface may glow, "emission",
    the light that it emits along the normal, likewise; where roughness may vary, "width", log2
    of its lobe's width², one channel, NaN where it is not known; and in `fine` their "material"'s number,
    (H', W', 1). `material` (K,): of the texels.
    `exits`: for objects that let light through, the rays in which paths leave them. Both are None where the
    samples are for a bake that is there.
    `light_map`: diffuse light that was traced anew where it is noisy or has edges; None if nowhere.
    `alpha` (H', W', 1): by which the maps in `fine` are multiplied, and all else is divided; None if it is 1.
    `materials`: how many the surface has, those of which no texel shows anything included.
    `passing`: the paths of `alone` pass the object where they would meet it after it has mirrored them.
    """

    light: LightSamples
    alone: EndSamples | None
    own: OwnRays
    around: Around
    fine: dict[str, Floats]
    coarse: dict[str, Floats]
    material: Ints
    exits: ExitSamples | None = None
    light_map: LightMap | None = None
    alpha: Floats | None = None
    passing: bool = False
    materials: int = 1

    @property
    def material_count(self) -> int:
        """How many materials there are by the surface, the texels, and the maps."""
        found = (int(self.material.max()), int(self.fine["material"].max()))
        return max(self.materials, *(number + 1 for number in found))
