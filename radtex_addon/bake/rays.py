# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of paths in the shared layout."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

FINER = 4  # times as many texels along each side for the diffuse colour, as it needs no light
PROBE_CELLS = 4  # cells along a side of the buckets for finding hidden directions
CLEAR_SAMPLES = 16  # rays that vote on a shadow's bit where a material may let some of them through
PROBES = 2  # rays per cell of these buckets; a cell is hidden if all of its rays meet back faces

WORLD_WIDTH = 1280  # of a layered bake's panorama of the world in pixels, one ray each: it is free of noise
NEAR_WIDTH, NEAR_SAMPLES = 896, 3  # of those of near things, which are denoised; one more ray tells where

_SAMPLES = 16  # samples of a plain bake with 8 x 8 cells that costs as much as the default `Rays`
_FEWEST = {"light": 4, "ends": 2, "around": 2, "panorama": 1}  # with fewer there is nothing to fit
_LARGEST_PANORAMA = 64  # paths per cell, a render of 2048 x 2048: beyond that the texels' own noise is larger


@dataclass(frozen=True)
class Rays:
    """Numbers of paths: `light`² per texel, `ends`² and `around`² per texel twice, `panorama` per cell twice.

    The panorama has `size` x `size` cells, for all texels together.
    """

    light: int = 23
    ends: int = 10
    around: int = 5
    panorama: int = 9
    size: int = 256

    @classmethod
    def of(cls, samples: int) -> Rays:
        """About as many paths as a plain bake with 8 x 8 cells takes: 64 times `samples` per texel."""
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
        """Paths of one texel, without its share of the panorama."""
        return self.light**2 + 2 * self.ends**2 + 2 * self.around**2

    @property
    def of_panorama(self) -> int:
        """Paths of both panoramas; the number per cell is rounded up to a square."""
        return 2 * self.size**2 * ceil(sqrt(self.panorama)) ** 2

    def most(self, texels: int) -> int:
        """All paths of a bake that covers `texels` texels, if none of them is hidden."""
        return texels * (self.of_texel + FINER**2 + PROBES * PROBE_CELLS**2) + self.of_panorama


@dataclass(frozen=True)
class LayeredRays:
    """Paths of a texel in the layered layout: `light`², `ends`² twice, and `exits` in each cell of them."""

    light: int = 16
    ends: int = 10
    exits: int = 2

    @classmethod
    def of(cls, samples: int) -> LayeredRays:
        """At most as many paths as a plain bake of so many samples in each of 8 x 8 cells takes."""
        share = sqrt(samples / _SAMPLES)
        return cls(max(4, round(cls.light * share)), max(4, round(cls.ends * share)))

    @property
    def of_texel(self) -> int:
        """Paths of one texel, without those of what surrounds the object, and of what comes through it."""
        return self.light**2 + 2 * self.ends**2

    def most(self, texels: int) -> int:
        """All paths of a bake of an opaque object that covers `texels` texels, if none of them is hidden."""
        return texels * (self.of_texel + 1 + FINER**2 + PROBES * PROBE_CELLS**2) + panorama_paths(2)


def panorama_paths(layers: int, world: int = WORLD_WIDTH, near: int = NEAR_WIDTH) -> int:
    """Paths of a layered bake's panoramas, of the world and of so many layers, of these widths in pixels."""
    return world**2 // 2 + layers * (NEAR_SAMPLES + 1) * near**2 // 2
