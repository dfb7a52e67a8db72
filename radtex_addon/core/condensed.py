# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The condensed form of the shared layout: a cluster of similar texels shares a few buckets, which they mix.

    bucket(texel) = base[cluster(texel), 0] + sum over k of  weight(texel, k) base[cluster(texel), k]

Shift, spread, gain and rest use the same clusters and weights. Lookups blend buckets linearly, so a lookup in
a condensed atlas gives the same result as one in the expanded atlas.
Sloan et al., "Clustered Principal Components for Precomputed Radiance Transfer" (2003).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Floats, Ints
from .errors import ShapeError
from .shared import Axis, Lobe, SharedAtlas


@dataclass(frozen=True, eq=False)
class CondensedLobe:
    """A lobe whose texels belong to C clusters of 1 + r buckets each.

    `cluster` (H, W) int32, 0 to C - 1; `weights` (H, W, r) float32. `ends` (C, 1 + r, n, n, 4), `gain` and
    `rest` (C, 1 + r, n, n, 3) float32; the first bucket of each cluster always has the weight 1. Raises
    ShapeError if shapes do not fit, or a value of `cluster` is out of range.
    """

    axis: Axis
    cluster: Ints
    weights: Floats
    ends: Floats
    gain: Floats
    rest: Floats

    def __post_init__(self) -> None:
        if self.weights.shape != (*self.cluster.shape, self.rank) or self.cluster.ndim != 2:
            expected = f"(H, W) and (H, W, {self.rank})"
            found = f"{self.cluster.shape} and {self.weights.shape}"
            raise ShapeError(f"{self.axis} cluster and weights: expected shapes {expected}, got {found}")
        base = self.ends.shape[:-1]
        square = len(base) == 4 and base[2] == base[3]
        for name, channels in (("ends", 4), ("gain", 3), ("rest", 3)):
            shape = getattr(self, name).shape
            if not square or shape != (*base, channels):
                raise ShapeError(
                    f"{self.axis} {name}: expected shape (C, 1 + r, n, n, {channels}), got {shape}"
                )
        if self.cluster.size and not 0 <= int(self.cluster.min()) <= int(self.cluster.max()) < len(self.ends):
            raise ShapeError(f"{self.axis} cluster: expected 0 to {len(self.ends) - 1}")

    @property
    def rank(self) -> int:
        """Number of weights of a texel."""
        return int(self.ends.shape[1]) - 1

    def expanded(self) -> Lobe:
        """The lobe in the dense form: each texel with its own buckets."""
        return Lobe(self.axis, *(self._mixed(part) for part in (self.ends, self.gain, self.rest)))

    def _mixed(self, base: Floats) -> Floats:
        height, width = self.cluster.shape
        flat = base.reshape(*base.shape[:2], -1)
        own, weights = self.cluster.ravel(), self.weights.reshape(height * width, -1)
        mixed = np.empty((height * width, flat.shape[2]), dtype=np.float32)
        for number, buckets in enumerate(flat):
            texels = np.flatnonzero(own == number)
            mixed[texels] = buckets[0] + weights[texels] @ buckets[1:]
        return mixed.reshape(height, width, *base.shape[2:])


@dataclass(frozen=True, eq=False)
class CondensedAtlas:
    """Like `SharedAtlas`, but with condensed lobes."""

    colour: Floats
    irradiance: Floats
    falloff: Floats
    surroundings: tuple[Floats, ...]
    sharpest: float
    lobes: tuple[CondensedLobe, ...]

    def expanded(self) -> SharedAtlas:
        """The atlas in the dense form: each texel with its own buckets.

        Raises ShapeError if shapes do not fit.
        """
        return SharedAtlas(
            self.colour,
            self.irradiance,
            self.falloff,
            self.surroundings,
            self.sharpest,
            tuple(lobe.expanded() for lobe in self.lobes),
        )
