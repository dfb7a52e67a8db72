# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How the shared layout spends its paths."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

FINER = 4  # times as many texels along each side has the diffuse colour, which needs no light
PROBE_CELLS = 4  # along a side of the buckets that tell hidden directions
PROBES = 2  # rays for each of their cells; one is hidden if all of them are

_SAMPLES = 16  # of a plain bake whose 8 x 8 cells cost as much as the rays below
_FEWEST = {"light": 4, "ends": 2, "around": 2, "panorama": 1}  # below, there is nothing to fit
_LARGEST_PANORAMA = 64  # a render of 2048 x 2048; more noise comes from the single texels


@dataclass(frozen=True)
class Rays:
    """How many paths a texel spends: `light`², and `ends`² and `around`² twice; `panorama` a cell, twice.

    The panorama has `size` x `size` cells, for all texels together.
    """

    light: int = 23
    ends: int = 10
    around: int = 5
    panorama: int = 9
    size: int = 256

    @classmethod
    def of(cls, samples: int) -> Rays:
        """About as many paths as a plain bake spends on 8 x 8 cells of so many samples each: 64 a texel."""
        most = cls()
        share = samples / _SAMPLES
        return cls(
            light=max(_FEWEST["light"], round(most.light * sqrt(share))),
            ends=max(_FEWEST["ends"], round(most.ends * sqrt(share))),
            around=max(_FEWEST["around"], round(most.around * sqrt(share))),
            panorama=min(_LARGEST_PANORAMA, max(_FEWEST["panorama"], round(most.panorama * share))),
        )

    @property
    def of_texel(self) -> int:
        """Paths of one texel, but for its share of the panorama."""
        return self.light**2 + 2 * self.ends**2 + 2 * self.around**2

    @property
    def of_panorama(self) -> int:
        """Paths of both panoramas; Cycles takes a cell's as a square."""
        return 2 * self.size**2 * ceil(sqrt(self.panorama)) ** 2

    def most(self, texels: int) -> int:
        """All paths of a bake that covers so many texels, if none of them is hidden."""
        return texels * (self.of_texel + FINER**2 + PROBES * PROBE_CELLS**2) + self.of_panorama
