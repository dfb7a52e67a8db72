# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Noisy diffuse light, as indoors, and its edges: where it needs more paths, and what the denoiser is worth.

All paths of a texel are parted into two halves. What is denoised of one half is compared with the other,
whose noise is another: that tells, around each texel, whether the denoiser took noise away or an edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import LightSamples
from ....bake.pooling import Neighbours
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints
from ....core.colour_spaces import LUMINANCE
from ....settings.rays import MORE_LIGHT
from .diffuse import DARK, estimate_frontal, facing_of, fit_falloffs

_QUIET = 0.08  # of the light that is seen: noise of a texel's diffuse light that smoothing alone takes away
_DIM = 0.05  # of the mean light, that is added to a texel's own: noise in the dark is not seen
_STEPS = (0.5, MORE_LIGHT)  # times the samples that are there, that are traced as well
# Where in a texel, from its middle, paths begin: 16 points, no two of them in a row or column (Hammersley).
PLACES = tuple((n / 16 - 15 / 32, int(f"{n:04b}"[::-1], 2) / 16 - 15 / 32) for n in range(16))
_LEAST = 2 * len(PLACES)  # paths: two halves of one from each place
_EDGE = 0.15  # of the light that is seen: how much a texel differs from those around it, if an edge is near
_SURE = 4.0  # times the noise
_BESIDE = 0.02  # share of the weight around a texel that such texels have, for it to be traced, too
_FAR_OFF = 4.0  # times the usual difference of the halves: single bright paths tell no more than that
_DOUBTED = 0.2  # share of what the halves tell that is their noise
_FEW = 64  # texels: of so few is half believed of how bright they are along the normal
_ROWS = 1 << 12  # texels whose samples are in hand at once
_MOST = 1.5  # times too bright that samples are taken to be along the normal


@dataclass(frozen=True, eq=False)
class LightMap:
    """Diffuse light over its colour, along the normal, that was traced anew.

    `light` (K, 3) float32: of the plan's texels, NaN where it is smooth. `falloff` (M, B, 3): the
    materials' that it goes with. `edge` (K,): which texels may be crossed by an edge of light, where samples
    at their points tell other light. `paths`: how many it took.
    """

    light: Floats
    falloff: Floats
    edge: Bools
    paths: int

    def onto(self, irradiance: Floats, falloff: Floats, material: Ints) -> Floats:
        """The light, and where there is none the `irradiance` (K, 3), to go with a `falloff` (M, B, 3)."""
        ratio = self.falloff.mean(axis=1) / np.maximum(falloff[: len(self.falloff)].mean(axis=1), 1e-6)
        light = self.light * ratio[np.minimum(material, len(ratio) - 1)]
        found: Floats = np.where(np.isfinite(self.light), light, irradiance).astype(np.float32)
        return found


@dataclass(frozen=True, eq=False)
class RoughLight:
    """Irradiance that needs more paths, as it is noisy or has edges, which points do not tell.

    `halves` (2, K, 3): two independent means of its samples; `falloff` (M, B, 3) as in `LightMap`;
    `samples`: of a texel, in both halves; `wanted` (K,): how many more paths each texel needs, multiples of
    2 * len(PLACES); `edge` (K,): which texels may be crossed by an edge.
    """

    halves: Floats
    falloff: Floats
    samples: int
    wanted: Ints
    edge: Bools

    @classmethod
    def of(
        cls, light: LightSamples, colour: Floats, material: Ints, neighbours: Neighbours
    ) -> RoughLight | None:
        """Of samples of texels of a diffuse `colour` (K, 3) and a `material` (K,); None if all is smooth."""
        facing = facing_of(light)
        falloff, _ = fit_falloffs(light, facing, material)
        frontal, variance = estimate_frontal(light, facing, falloff, material)
        level = _level(light, facing, frontal, neighbours)
        edge = _edges(frontal, variance, colour, level, neighbours)
        wanted = _paths_wanted(variance, level, edge, facing.shape[1], neighbours)
        if not wanted.any():
            return None
        side = round(facing.shape[1] ** 0.5)
        row, column = np.divmod(np.arange(facing.shape[1]), side)
        first = ((row + column) % 2 == 0).astype(np.float32)

        def estimate(half: Floats) -> Floats:
            part = large_arrays.from_blocks(len(facing), lambda some: facing[some] * half, _ROWS)
            found: Floats = estimate_frontal(light, part, falloff, material)[0].T
            return found

        halves = [estimate(half) for half in (first, 1 - first)]
        told = np.where(colour > DARK, np.stack(halves) / np.maximum(colour, DARK), 0)
        return cls(told.astype(np.float32), falloff, facing.shape[1], wanted, edge)

    def with_more(self, more: Floats, material: Ints) -> tuple[Floats, Floats]:
        """The halves with the irradiance `more` (2, K, 3) of the paths that are wanted; falloffs (M, B, 3).

        `more` is NaN where there is none. Of texels with an edge only these paths count. What is noisy in the
        falloffs is how bright they are along the normal: that is as these paths have it.
        """
        ratio = self._too_bright(more, material)
        samples = self.halves / ratio[material]
        own = np.where(self.edge, 0, self.samples)[:, None]
        both = (own * samples + self.wanted[:, None] * more) / np.maximum(own + self.wanted[:, None], 1)
        found: Floats = np.where(np.isfinite(more), both, samples).astype(np.float32)
        return found, (self.falloff * ratio[:, None]).astype(np.float32)

    def _too_bright(self, more: Floats, material: Ints) -> Floats:
        """Times that samples are brighter along the normal than `more` paths, in each material: (M, 3)."""
        ratio = np.ones((len(self.falloff), 3))
        for number in np.unique(material):
            own = (material == number)[:, None] & np.isfinite(more).all(axis=0) & ~self.edge[:, None]
            ours, theirs = (
                np.where(own, part, 0).sum(axis=(0, 1), dtype=np.float64) for part in (self.halves, more)
            )
            np.divide(ours, theirs, out=ratio[number], where=theirs > 0)
            count = np.count_nonzero(own.any(axis=1))
            ratio[number] = 1 + (ratio[number] - 1) * count / (count + _FEW)
        limited: Floats = np.clip(ratio, 1 / _MOST, _MOST)
        return limited


def _level(light: LightSamples, facing: Floats, frontal: Floats, neighbours: Neighbours) -> Floats:
    """The luminance that is seen of texels and what is around them: (K,); `frontal` (3, K) is diffuse."""

    def mirrored(some: slice) -> Floats:
        used = facing[some] > 0
        number = np.maximum(np.count_nonzero(used, axis=1), 1)
        mean: Floats = (np.tensordot(LUMINANCE, planes(light.mirrored[some]), 1) * used).sum(axis=1) / number
        return mean

    seen = LUMINANCE @ frontal + np.concatenate(in_blocks(mirrored, *facing.shape))
    level: Floats = _around(seen, neighbours, wide=False) + _DIM * max(float(seen.mean()), 1e-9)
    return level


def _around(values: Floats, neighbours: Neighbours, wide: bool) -> Floats:
    """The weighted mean of values (K,) around each texel: (K,)."""
    table = np.stack([values, np.ones_like(values)])[..., None].astype(np.float32)
    total, weight = neighbours.pool(table, wide)[..., 0]
    return cast(Floats, total / weight)


def _edges(frontal: Floats, variance: Floats, colour: Floats, level: Floats, neighbours: Neighbours) -> Bools:
    """Which texels may be crossed by an edge of light, by the diffuse light (3, K) and its `variance`.

    A texel's irradiance differs from that around it by more than noise does, and by a share of the `level`
    (K,) that is seen.
    """
    shade = np.maximum(LUMINANCE @ colour.T, DARK)
    irradiance = LUMINANCE @ frontal / shade
    off = np.abs(irradiance - _around(irradiance, neighbours, wide=False)) * shade
    noise = np.sqrt(LUMINANCE**2 @ variance)
    marked = (off > _EDGE * level) & (off > _SURE * noise)
    found: Bools = _around(marked.astype(np.float32), neighbours, wide=False) > _BESIDE
    return found


def _paths_wanted(variance: Floats, level: Floats, edge: Bools, samples: int, neighbours: Neighbours) -> Ints:
    """As in `RoughLight`, by the variance (3, K) of the diffuse light."""
    noise = _around(LUMINANCE**2 @ variance, neighbours, wide=True)
    needed = noise / (_QUIET * level) ** 2 - 1  # times the samples that are there
    few, many = (_LEAST * max(1, int(samples * step / _LEAST)) for step in _STEPS)
    number = np.where(needed > _STEPS[0], many, few)
    return cast(Ints, np.where((needed > 0) | edge, number, 0).astype(np.int64))


def filled(values: Floats, colour: Floats, neighbours: Neighbours) -> Floats:
    """Irradiance (K, 3) with that around it where the `colour` (K, 3) is too dark to tell it: float32."""
    lit = (colour > DARK).T[..., None].astype(np.float32)
    if lit.all():
        return values
    around = neighbours.pool(np.concatenate([lit * _table(values), lit]), wide=True)
    near = (around[:3] / np.maximum(around[3:], 1e-6))[..., 0].T
    found: Floats = np.where(colour > DARK, values, near).astype(np.float32)
    return found


def nearer(halves: Floats, denoised: Floats, smooth: Floats, edge: Bools, neighbours: Neighbours) -> Floats:
    """The mean of two `halves` (2, K, 3), or what is denoised of it, `smooth` (K, 3), or between: (K, 3).

    Whichever is nearest to the light: what is `denoised` (2, K, 3) of each half is compared with the other
    half, around each texel, among those with an `edge` (K,) and among the others.
    """
    mean = halves.mean(axis=0)
    level = np.maximum(_around(mean @ LUMINANCE, neighbours, wide=False), 1e-6)[:, None]
    apart = np.abs(halves[1] - halves[0]) / level
    far = np.maximum(_FAR_OFF * _around(apart.mean(axis=1), neighbours, wide=True), 1e-6)[:, None]
    step, other = (
        np.clip(values / level, -far, far) for values in (denoised - halves, halves[::-1] - halves)
    )
    gained = (other * step).sum(axis=(0, 2))
    length = (step**2).sum(axis=(0, 2))
    share = np.zeros(len(edge))
    for own in (edge, ~edge):
        table = np.stack([gained, length])[..., None] * own[:, None]
        towards, whole = neighbours.pool(table.astype(np.float32), wide=True)[..., 0]
        share[own] = (towards / np.maximum(whole, 1e-20))[own]
    share = np.clip(share / (1 - _DOUBTED), 0, 1)[:, None]
    found: Floats = mean + share * (smooth - mean)
    return found.astype(np.float32)


def _table(values: Floats) -> Floats:
    return values.T[..., None].astype(np.float32)
