# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting the shared layout to single paths.

A texel sees a direction once; all texels together see it thousands of times. The diffuse light is estimated
from every direction of a texel at once; each lobe of the rest from where its paths end (`ends.py`) and from
how much of the surroundings it shows (`gloss.py`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.hemisphere import square_to_direction
from ..core.shared import Axis, Lobe, SharedAtlas, sample_falloff
from .ends import LobePaths, fit_ends, parallax
from .gloss import LUMINANCE, fit_gain, fit_gloss, weight_of_ending
from .light_samples import EndSamples, LightSamples, SurroundingsSamples, mirrored, straight_through
from .plan import CapturePlan
from .pooling import Neighbours, sums
from .surroundings import Surroundings, nearness_map

FALLOFF_SIZE = 16
FAR = 100.0  # of the object's size: where the world is
GRAZING = 0.1  # N.I below which a sample is not fitted: the facet's own horizon is near
_FAINT = 1e-3  # of all light: a lobe with less is left out
_OUTLIER = 1.5  # length of an end: there, paths' weights differed too much to tell a direction
_WEIGHT_LIMIT = 4.0  # times the mean weight: a path counts for no more


@dataclass(frozen=True)
class Fitted:
    """An atlas, and the share of the samples' energy that was cut off as fireflies."""

    atlas: SharedAtlas
    fireflies: float


def fit_shared(
    light: LightSamples,
    ends: EndSamples,
    surroundings: SurroundingsSamples,
    colour: Floats,
    cells: int = 16,
    size: int = 256,
) -> Fitted:
    """Fit the shared layout to samples: buckets of cells x cells, surroundings of size x size.

    `light` and `ends` are of the same texels. `colour` (H', W', 3) is the diffuse colour pass along the
    normal, gutter filled.
    """
    plan = light.plan
    facing = square_to_direction(light.square)[..., 2].astype(np.float32)
    used = np.flatnonzero((light.seen & (facing > GRAZING)).ravel())
    owner = (used // light.square.shape[1]).astype(np.int32)
    falloff, diffuse = fit_diffuse(light, facing, used, owner)
    irradiance = _divide_out(diffuse, light, facing, falloff)
    around = Surroundings.of(surroundings, size)
    fit = _LobeFit(light, ends, used, owner, around, Neighbours(plan), cells)
    lobes, lost = [], 0.0
    brightness = {axis: _sum_of(_lobe_light(light, axis), used) for axis in Axis}
    total = sum(brightness.values()) + _sum_of(light.diffuse, used)
    for axis in Axis:
        if brightness[axis] > _FAINT * total:
            start = _parallax(plan, surroundings, cells) if axis is Axis.MIRROR else None
            lobe, cut = fit.lobe(axis, start)
            lobes.append(lobe)
            lost += cut
    atlas = SharedAtlas(
        colour=colour.astype(np.float32),
        irradiance=plan.placed(irradiance, gutter=True),
        falloff=falloff,
        surroundings=around.levels,
        sharpest=around.sharpest,
        lobes=tuple(lobes),
    )
    return Fitted(atlas, lost / max(total, 1e-12))


@dataclass(frozen=True, eq=False)
class _LobeFit:
    """What the lobes' fits have in common.

    `used` (P,) are flat indices of samples, `owner` (P,) their texels.
    """

    light: LightSamples
    ends: EndSamples
    used: Ints
    owner: Ints
    around: Surroundings
    neighbours: Neighbours
    cells: int

    def lobe(self, axis: Axis, start: Floats | None) -> tuple[Lobe, float]:
        """The lobe of an axis, and the light that was cut off; `start` (K*n*n, 3) is a first shift."""
        plan, n = self.light.plan, self.cells
        paths, white = self._traced(axis)
        if start is None:
            start = np.zeros((len(plan.texel) * n * n, 3), dtype=np.float32)
        told = (paths.weight > 0) & (np.sum(paths.end * paths.end, axis=1) < _OUTLIER**2)
        ends = fit_ends(paths.only(told), self.neighbours, n, start)
        gain = fit_gain(paths, white, self.neighbours, n)
        away = _axes(plan, self.light.square, axis).reshape(-1, 3)[self.used]
        light = _lobe_light(self.light, axis).reshape(-1, 3)[self.used].astype(np.float32)
        gain, rest, cut = fit_gloss(
            away,
            self.owner,
            np.maximum(light, 0),
            ends,
            gain,
            weight_of_ending(white),
            self.around,
            self.neighbours,
        )
        buckets = (part.reshape(len(plan.texel), n, n, -1) for part in (ends, gain, rest))
        return Lobe(axis, *(plan.placed(part, gutter=True) for part in buckets)), cut

    def _traced(self, axis: Axis) -> tuple[LobePaths, Floats]:
        """The paths of a lobe, those too that end nowhere, and how much they let through (P, 3)."""
        ends, mirror = self.ends, axis is Axis.MIRROR
        used = np.flatnonzero((square_to_direction(ends.square)[..., 2] > GRAZING).ravel())
        white, end, away = (
            part.reshape(-1, 3)[used].astype(np.float32)
            for part in (
                ends.mirrored_weight if mirror else ends.through_weight,
                ends.mirrored_end if mirror else ends.through_end,
                _axes(ends.plan, ends.square, axis),
            )
        )
        weight = white @ LUMINANCE
        weight = np.minimum(weight, _WEIGHT_LIMIT * float(weight.mean())) if len(weight) else weight
        owner = (used // ends.square.shape[1]).astype(np.int32)
        return LobePaths(away, end, owner, weight), white


def _lobe_light(light: LightSamples, axis: Axis) -> Floats:
    return light.mirrored if axis is Axis.MIRROR else light.through


def _sum_of(values: Floats, used: Ints) -> float:
    """The sum of some of the samples (K, S, 3), by flat index."""
    return float(values.reshape(-1, 3)[used].sum(dtype=np.float64))


def _axes(plan: CapturePlan, square: Floats, axis: Axis) -> Floats:
    return mirrored(plan, square) if axis is Axis.MIRROR else straight_through(plan, square)


def _parallax(plan: CapturePlan, surroundings: SurroundingsSamples, cells: int) -> Floats:
    size = float(np.linalg.norm(plan.points.max(axis=0) - plan.points.min(axis=0)))
    nearness = nearness_map(surroundings, FAR * max(size, 1e-6))
    return parallax(nearness, surroundings.middle, plan.points, cells)


def fit_diffuse(samples: LightSamples, facing: Floats, used: Ints, owner: Ints) -> tuple[Floats, Floats]:
    """Diffuse radiance along the normal (K, 3), from all of a texel's samples, and its falloff (B, 3)."""
    count = len(samples.square)
    light = samples.diffuse.reshape(-1, 3)[used].astype(np.float32)
    cosine = facing.ravel()[used]
    mean = sums(owner, light, count) / np.maximum(np.bincount(owner, minlength=count), 1)[:, None]
    if not mean.any():
        return np.ones((FALLOFF_SIZE, 3), dtype=np.float32), np.zeros((count, 3), dtype=np.float32)
    step = np.minimum((cosine * FALLOFF_SIZE).astype(np.int32), FALLOFF_SIZE - 1)
    level = mean @ LUMINANCE
    weight = (1 / (level + level.mean() / 4))[owner][:, None].astype(np.float32)
    seen = sums(step, weight * mean[owner].astype(np.float32), FALLOFF_SIZE)
    curve = np.divide(sums(step, weight * light, FALLOFF_SIZE), seen, where=seen > 0, out=np.ones_like(seen))
    known = np.flatnonzero((seen >= 1e-3 * seen.max(axis=0)).all(axis=1))
    for channel in range(3):
        curve[:, channel] = np.interp(np.arange(FALLOFF_SIZE), known, curve[known, channel])
    curve = (curve / np.maximum(curve[-1], 1e-6)).astype(np.float32)
    part = sample_falloff(curve, cosine)
    against = sums(owner, part * part, count)
    frontal = sums(owner, part * light, count) / np.maximum(against, 1e-6)
    return curve, frontal.astype(np.float32)


def _divide_out(diffuse: Floats, samples: LightSamples, facing: Floats, falloff: Floats) -> Floats:
    """Irradiance, the diffuse light over its colour: the texels' own colour, at their own points."""
    in_the_mean = sample_falloff(falloff, facing[:: max(1, len(facing) // 256)].ravel()).mean(axis=0)
    colour = samples.colour / np.maximum(in_the_mean, 1e-6)
    divided: Floats = np.divide(diffuse, colour, out=np.zeros_like(diffuse), where=colour > 1e-3)
    return divided
