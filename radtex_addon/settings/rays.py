# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of paths, of finer texels and of buckets in the layered layout."""

from __future__ import annotations

from dataclasses import dataclass
from math import isqrt, sqrt

FINER = 4  # times as many texels along each side for the maps of the material, as they need no light …
_FINEST = 4096  # … and the most along a side that this gives
_COARSER = 2  # texels along a side of those that share a bucket …
_MOST_BUCKETS = 512  # … more where this many buckets along a side would not do
_EXACT = 1e-6  # beyond what a quotient of whole numbers lacks
PROBE_CELLS = 4  # cells along a side of the buckets for finding hidden directions
CLEAR_SAMPLES = 16  # rays that vote on a shadow's bit where a material may let some of them through
PROBES = 2  # rays per cell of these buckets; a cell is hidden if all of its rays meet back faces

WORLD_WIDTH = 1280  # of a layered bake's panorama of the world in pixels, one ray each: it is free of noise
NEAR_WIDTH, NEAR_SAMPLES = 896, 6  # of those of near things, which are denoised
ROOM_SAMPLES = 16  # of those in a room, which has little direct light

OWN_SIDE = 20  # rays along a side of a texel's hemisphere, that tell what it sees of the object itself …
OWN_RAYS = 1 << 24  # … and the most of all texels, if that leaves each a few
_LEAST_OWN_SIDE = 6

MORE_LIGHT = 2  # times the paths of light that noisy light takes besides, at most
_SAMPLES = 16  # samples of a plain bake with 8 x 8 cells that costs as much as the default `LayeredRays`


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
        """Paths of one texel, but those of noisy light, of the surroundings, and of what comes through."""
        return self.light**2 + 2 * self.ends**2

    def most(self, texels: int) -> int:
        """All paths of a bake of an opaque object that covers `texels` texels, if none of them is hidden."""
        of_texel = self.of_texel + MORE_LIGHT * self.light**2 + 1 + FINER**2 + PROBES * PROBE_CELLS**2
        return texels * of_texel + most_panorama_paths()


def own_side(texels: int) -> int:
    """Rays along a side of a texel's hemisphere that tell what it sees of the object itself."""
    return min(OWN_SIDE, max(_LEAST_OWN_SIDE, isqrt(OWN_RAYS // max(texels, 1))))


def finer(texels: int) -> float:
    """How many times as many texels the maps of the material have along each side of an atlas of `texels`."""
    return min(float(FINER), max(1.0, _FINEST / texels))


def coarser(texels: int) -> float:
    """How many texels along a side share a bucket, in an atlas of `texels` along its longer side."""
    return max(float(_COARSER), texels / _MOST_BUCKETS)


def side_in(texels: int, step: float) -> int:
    """How many texels, each `step` texels of an atlas wide, a map has along a side of `texels`; at least one.

    Of wider ones only whole ones count: what is left over belongs to the last one.
    """
    return max(1, round(texels / step) if step <= 1 else int(texels / step + _EXACT))


def step_to(shape: tuple[int, ...], whole: tuple[int, ...]) -> float:
    """How many texels of an atlas (H, W) each texel of a map (h, w) is wide: as large, or of buckets."""
    return 1.0 if shape[:2] == whole[:2] else coarser(max(whole[:2]))


def most_panorama_paths() -> int:
    """Paths of a layered bake's panoramas in the open, on a plane with other things all around.

    Of the plane there is only the half below its horizon; of other things one more path tells where they are.
    """
    return WORLD_WIDTH**2 // 2 + NEAR_SAMPLES * NEAR_WIDTH**2 // 4 + (NEAR_SAMPLES + 1) * NEAR_WIDTH**2 // 2
