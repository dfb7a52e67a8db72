# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Options and result of an unwrap."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ...core.arrays import Floats
from ...core.errors import InputError
from ...settings.texel_density import MOST_TEXELS

_CHAOTIC = 8_000  # triangles: above, one try may make too many islands; up to 2.5 times that, two are made
_MANY = 30_000  # triangles above which island size is limited; without a limit xatlas takes minutes
_MERGED = 400_000  # triangles flattened anew while islands are merged, all rounds together
_MOST_ROUNDS = 8
_HUGE = 1_000_000  # triangles: Blender's edit mode needs about a kilobyte for each


@dataclass(frozen=True)
class UnwrapOptions:
    """How islands are shaped, how far apart they lie, and how large they are.

    At least `padding` free texels lie between islands. `density`, if given, sets the texels per scene
    unit, and the atlas is as large as it needs, but has at most `most` texels along a side. Edges whose
    corner normals differ by more than `seam_angle` degrees (sharp edges, creases) become borders of islands,
    so that no texel lies across them.
    `max_cost`, `normal_deviation_weight`, `roundness_weight` and `straightness_weight` are xatlas's own,
    at their defaults: its bound of 75 degrees from an island's mean normal is what ends islands in
    practice. `max_island_share` limits an island's share of the surface; smaller islands take far less
    time. Each of `iterations` (rounds of xatlas's seeding) is a try, of which the best is used. If these
    two are left empty, they depend on the number of triangles. `blender_angle` (degrees) is Smart UV
    Project's. Where so much `room`, in scene units, is free, a camera can be.
    """

    padding: int = 2
    density: float | None = None
    most: int = MOST_TEXELS
    seam_angle: float = 45.0
    max_cost: float = 2.0
    normal_deviation_weight: float = 2.0
    roundness_weight: float = 0.01
    straightness_weight: float = 6.0
    max_island_share: float | None = None
    iterations: tuple[int, ...] = ()
    blender_angle: float = 66.0
    room: float = math.inf

    def __post_init__(self) -> None:
        if self.padding < 0:
            raise InputError(f"padding must be 0 texels or more, not {self.padding}")
        if self.density is not None and not (math.isfinite(self.density) and self.density > 0):
            raise InputError(f"texel density must be above 0 texels per unit, not {self.density}")
        if any(rounds < 1 for rounds in self.iterations):
            raise InputError(f"xatlas iterations must be 1 or more, not {self.iterations}")

    @staticmethod
    def rounds_of_merging(triangles: int) -> int:
        """In how many rounds islands may be merged: as many as take seconds; none if it takes gigabytes."""
        if triangles > _HUGE:
            return 0
        return max(min(_MERGED // max(triangles, 1), _MOST_ROUNDS), 1)

    def for_size(self, triangles: int) -> UnwrapOptions:
        """These options, with empty ones chosen for a mesh of so many triangles."""
        iterations, share = self.iterations, self.max_island_share
        if not iterations:
            iterations = (1, 2) if _CHAOTIC < triangles <= 2.5 * _CHAOTIC else (1,)
        if share is None:
            share = 1 / 20 if triangles > _MANY else 0.0
        return replace(self, iterations=iterations, max_island_share=share)


@dataclass(frozen=True, eq=False)
class AtlasUnwrap:
    """`uv` (F, 3, 2) in 0..1, v up, for an atlas of `width` x `height` texels, and statistics.

    `utilisation` is the share of the atlas that islands cover, `density` the texels per scene unit, `overlap`
    the share of the covered area that is covered more than once. `needed` is about how many texels along the
    longer side the density that was asked for would need, if the atlas is smaller than that; else 0.
    """

    uv: Floats
    width: int
    height: int
    islands: int
    utilisation: float
    density: float
    overlap: float
    seconds: float
    needed: int = 0
