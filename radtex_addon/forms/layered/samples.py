# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the layered layout is fitted to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...bake.light_samples import EndSamples, LightSamples, LobeSamples
from ...bake.plan import CapturePlan
from ...core.arrays import Bools, Floats, Ints
from .lookup.environment import Around


@dataclass(frozen=True, eq=False)
class ExitSamples:
    """Paths seen in the middles of the plan's cells, S of each: K texels, n * n cells.

    `weight` (S, K, n*n), luminance: how much a path lets through, 0 where it does not enter or is lost.
    `direction` (S, K, n*n, 3), unit: in which it leaves; `place` (S, K, n*n, 3): of all points on the line
    that it leaves along the nearest to the texel, from there. Both in the texel's frame: what is round or
    straight has nearly the same in all texels. `colour` (K, 3): of the paths that get through a texel, with
    a luminance of 1.
    """

    plan: CapturePlan
    weight: Floats
    direction: Floats
    place: Floats
    colour: Floats


@dataclass(frozen=True, eq=False)
class OwnRays:
    """Mirror rays of a plan's texels: which `hit` the object, (K, S).

    Of the P rays that do, in the order of `np.nonzero(hit)`: the texel that they have `met` (P,), and the
    `place` where, (P, 3), in world space. Rays that meet a part without texels in this atlas have met -1, and
    bring the `light` (P, 3), one path's; None where there are none.
    """

    rays: LobeSamples
    hit: Bools
    met: Ints
    place: Floats
    light: Floats | None = None

    @property
    def traced(self) -> int:
        """How many paths were traced for `light`: one in each cell of the texels that have such rays."""
        if self.light is None:
            return 0
        row, _ = np.nonzero(self.hit)
        return len(np.unique(row[self.met < 0])) * int(self.hit.shape[1])


@dataclass(frozen=True, eq=False)
class LayeredSamples:
    """What the layered layout is fitted to.

    `light`: single paths. `alone`: paths through the object in an empty world. `own`: mirror rays that meet
    the object itself. `fine` and `coarse`: maps of the diffuse colour, the glossy colour and the shading
    normal, "diffuse", "glossy", "normal", (H', W', 3) and (H, W, 3); where roughness may vary, "width", log2
    of its lobe's width², one channel, NaN where it is not known; and in `fine` their "material"'s number,
    (H', W', 1). `material` (K,): of the texels.
    `exits`: for objects that let light through, the rays in which paths leave them. Both are None where the
    samples are for a bake that is there.
    `alpha` (H', W', 1): by which the maps in `fine` are multiplied, and all else is divided; None if it is 1.
    """

    light: LightSamples
    alone: EndSamples | None
    own: OwnRays
    around: Around
    fine: dict[str, Floats]
    coarse: dict[str, Floats]
    material: Ints
    exits: ExitSamples | None = None
    alpha: Floats | None = None
