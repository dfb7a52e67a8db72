# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit the shared layout to single paths.

One texel sees a direction once; all texels together see it thousands of times. The diffuse light is estimated
from all directions of a texel at once; all other light for each lobe, from where its paths end (`ends.py`)
and how much of the surroundings it shows (`gloss.py`).
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ..core.arrays import Bools, Floats
from ..core.hemisphere import square_to_direction
from ..core.shared import Axis, Lobe, SharedAtlas, bilinear, sample_falloff
from . import ends as ends_fit
from . import gloss as gloss_fit
from .blocks import in_blocks, planes
from .ends import LobePaths, fit_ends, parallax
from .gloss import LUMINANCE, LobeSamples, fit_gain, fit_gloss
from .light_samples import EndSamples, LightSamples, SurroundingsSamples
from .plan import CapturePlan
from .pooling import Neighbours
from .progress import Progress, Stage
from .surroundings import Surroundings, nearness_map

FALLOFF_SIZE = 16
FAR = 100.0  # distance of the world, in object sizes
GRAZING = 0.1  # N.I below which a sample is not fitted: the facet's own horizon is near
_BLACK = 1e-3  # colour channels darker than this are not divided by
_FAINT = 1e-3  # share of all light: a lobe with less is left out
_OUTLIER = 1.5  # longest end: a longer vector is no direction, as its paths' weights differed too much
_FEW = 0.25  # samples per cell and texel: with fewer, pool widely, as near neighbours do not fill a bucket
_WEIGHT_LIMIT = 4.0  # times the mean weight: no path counts for more

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class Fitted:
    """An atlas, and the share of the samples' light that is lost because no other paths confirm it."""

    atlas: SharedAtlas
    fireflies: float


def fit_shared(
    light: LightSamples,
    ends: EndSamples,
    surroundings: SurroundingsSamples,
    colour: Floats,
    cells: int = 16,
    size: int = 256,
) -> Generator[Progress, None, Fitted]:
    """Fit the shared layout to samples: buckets of cells x cells, surroundings of size x size.

    `light` and `ends` have the same texels. `colour` (H', W', 3) is the diffuse colour pass along the
    normal, gutter filled. Yields progress in the stages of the lobes' fits.
    """
    yield Progress(Stage.FIT, 0, 1)
    plan = light.plan
    facing = facing_of(light)
    used = facing > 0
    falloff, diffuse = fit_diffuse(light, facing)
    del facing
    few = light.square.shape[1] < _FEW * cells * cells
    neighbours = Neighbours(plan, few)
    own = frontal_colour(light, falloff, _at_texels(colour, plan), neighbours)
    irradiance = np.divide(diffuse, own, out=np.zeros_like(diffuse), where=own > _BLACK)
    around = Surroundings.of(surroundings, size)
    fit = _LobeFit(light, ends, used, around, neighbours, cells)
    parts: dict[Axis, list[Floats]] = {}
    lost = 0.0
    brightness = {axis: _sum_of(_lobe_light(light, axis), used) for axis in Axis}
    total = sum(brightness.values()) + _sum_of(light.diffuse, used)
    bright = [axis for axis in Axis if brightness[axis] > _FAINT * total]
    stages = len(ends_fit.stages(cells)) + len(gloss_fit.stages(cells))
    for number, axis in enumerate(bright):
        steps = fit.lobe(axis, surroundings)
        parts[axis], lost_of_axis = yield from _told(steps, number * stages, len(bright) * stages)
        lost += lost_of_axis
    atlas = SharedAtlas(
        colour=colour.astype(np.float32),
        irradiance=plan.placed(irradiance, gutter=True),
        falloff=falloff,
        surroundings=around.levels,
        sharpest=around.sharpest,
        lobes=tuple(_placed(plan, axis, parts[axis]) for axis in bright),
    )
    return Fitted(atlas, lost / max(total, 1e-12))


def _told(steps: Generator[None, None, _Result], done: int, total: int) -> Generator[Progress, None, _Result]:
    """Run `steps`, which come after `done` others, and yield progress before each; returns their value.

    Closing this generator closes `steps`.
    """
    with closing(steps):
        while True:
            yield Progress(Stage.FIT, done, total)
            try:
                next(steps)
            except StopIteration as stop:
                result: _Result = stop.value
                return result
            done += 1


@dataclass(frozen=True, eq=False)
class _LobeFit:
    """The fit of each lobe; `used` (K, S): which samples of the light count."""

    light: LightSamples
    ends: EndSamples
    used: Bools
    around: Surroundings
    neighbours: Neighbours
    cells: int

    def lobe(
        self, axis: Axis, surroundings: SurroundingsSamples
    ) -> Generator[None, None, tuple[list[Floats], float]]:
        """Fit a lobe's ends, gain and rest, (C, K, n*n) each; returns them and the sum of the light lost."""
        plan, n = self.light.plan, self.cells
        white, single = self._white(axis)
        paths = self._traced(white)
        start = (
            _parallax(plan, surroundings, n)
            if axis is Axis.MIRROR
            else np.zeros((3, len(plan.texel), n * n), dtype=np.float32)
        )
        ends = yield from fit_ends(paths, self.neighbours, n, start)
        gain = fit_gain(paths.place, white, single, self.neighbours, n)
        del paths, start
        samples = LobeSamples(plan, axis, self.light.square, _lobe_light(self.light, axis), self.used)
        gain, rest, lost = yield from fit_gloss(samples, ends, gain, single, self.around, self.neighbours)
        return [ends, gain, rest], lost

    def _white(self, axis: Axis) -> tuple[LobeSamples, Floats]:
        """The weights of a lobe's paths (what the object lets through), and their mean (3,) where not 0."""
        ends, mirror = self.ends, axis is Axis.MIRROR
        values = ends.mirrored_weight if mirror else ends.through_weight
        used = np.empty(ends.square.shape[:2], dtype=bool)
        white = LobeSamples(ends.plan, axis, ends.square, values, used)

        def look(some: slice) -> tuple[Floats, int]:
            used[some] = _cosine(ends.square[some]) > GRAZING
            seen = white.seen(some)
            return seen.sum(axis=(1, 2), dtype=np.float64), int(seen.any(axis=0).sum())

        totals, counts = zip(*in_blocks(look, *used.shape), strict=True)
        return white, (sum(totals) / max(sum(counts), 1)).astype(np.float32)

    def _traced(self, white: LobeSamples) -> LobePaths:
        """The paths of a lobe; those that end nowhere have weight 0."""
        end = self.ends.mirrored_end if white.axis is Axis.MIRROR else self.ends.through_end
        shape = white.used.shape
        place, moved, weight = (np.empty((*c, *shape), dtype=np.float32) for c in ((2,), (3,), ()))

        def look(some: slice) -> None:
            axis, place[:, some] = white.along(some)
            moved[:, some] = planes(end[some]) - axis
            weight[some] = np.tensordot(LUMINANCE, white.seen(some), axes=1)

        in_blocks(look, *shape)
        mean = float(weight.sum(dtype=np.float64)) / max(int(white.used.sum()), 1)
        np.minimum(weight, _WEIGHT_LIMIT * mean, out=weight)

        def drop(some: slice) -> None:
            weight[some] *= (planes(end[some]) ** 2).sum(axis=0) < _OUTLIER**2

        in_blocks(drop, *shape)
        return LobePaths(place, moved, weight)


def _placed(plan: CapturePlan, axis: Axis, parts: list[Floats]) -> Lobe:
    """The lobe of ends, gain and rest, (C, K, n*n); takes them out of the list to free their memory."""
    n, placed = round(parts[0].shape[2] ** 0.5), []
    while parts:
        part = np.moveaxis(parts.pop(0), 0, -1)
        placed.append(plan.placed(part.reshape(len(part), n, n, -1), gutter=True))
    return Lobe(axis, *placed)


def _lobe_light(light: LightSamples, axis: Axis) -> Floats:
    return light.mirrored if axis is Axis.MIRROR else light.through


def _sum_of(values: Floats, used: Bools) -> float:
    """The sum of the samples (K, S, 3) that are `used` (K, S)."""

    def add(some: slice) -> float:
        return float((planes(values[some]) * used[some]).sum(dtype=np.float64))

    return sum(in_blocks(add, *used.shape))


def _parallax(plan: CapturePlan, surroundings: SurroundingsSamples, cells: int) -> Floats:
    size = float(np.linalg.norm(plan.points.max(axis=0) - plan.points.min(axis=0)))
    nearness = nearness_map(surroundings, FAR * max(size, 1e-6))
    return parallax(nearness, surroundings.middle, plan.points, cells)


def _cosine(square: Floats) -> Floats:
    """N.I of viewers at bucket coordinates (..., 2): (...) float32."""
    return square_to_direction(square)[..., 2].astype(np.float32)


def facing_of(light: LightSamples) -> Floats:
    """N.I of the samples, (K, S); 0 for those that do not count."""
    facing = np.empty(light.seen.shape, dtype=np.float32)

    def look(some: slice) -> None:
        cosine = _cosine(light.square[some])
        facing[some] = np.where(light.seen[some] & (cosine > GRAZING), cosine, 0)

    in_blocks(look, *facing.shape)
    return facing


def fit_diffuse(samples: LightSamples, facing: Floats) -> tuple[Floats, Floats]:
    """Fit the falloff (B, 3) of diffuse light, and each texel's diffuse radiance along the normal (K, 3).

    `facing` (K, S): N.I of the samples, 0 for those that do not count. Returns the falloff first.
    """
    count = len(facing)

    def light(some: slice) -> Floats:
        return np.where(facing[some] > 0, planes(samples.diffuse[some]), np.float32(0))

    def average(some: slice) -> Floats:
        number = np.maximum(np.count_nonzero(facing[some], axis=1), 1)
        found: Floats = light(some).sum(axis=2, dtype=np.float64) / number
        return found

    mean = np.concatenate(in_blocks(average, *facing.shape), axis=1)
    if not mean.any():
        return np.ones((FALLOFF_SIZE, 3), dtype=np.float32), np.zeros((count, 3), dtype=np.float32)
    level = LUMINANCE @ mean
    weight = 1 / (level + level.mean() / 4)

    def sum_up(some: slice) -> Floats:
        step = np.minimum((facing[some] * FALLOFF_SIZE).astype(np.intp), FALLOFF_SIZE - 1).ravel()
        texel = (weight * mean)[:, some, None] * (facing[some] > 0)
        columns = [*texel, *(weight[some, None] * light(some))]
        return np.stack([np.bincount(step, column.ravel(), FALLOFF_SIZE) for column in columns])

    seen, shown = np.split(sum(in_blocks(sum_up, *facing.shape), np.zeros((6, FALLOFF_SIZE))), 2)
    curve = np.divide(shown, seen, where=seen > 0, out=np.ones_like(seen))
    known = np.flatnonzero((seen >= 1e-3 * seen.max(axis=1, keepdims=True)).all(axis=0))
    for channel in curve:
        channel[:] = np.interp(np.arange(FALLOFF_SIZE), known, channel[known])
    falloff = (curve / np.maximum(curve[:, -1:], 1e-6)).T.astype(np.float32)

    def fit(some: slice) -> Floats:
        part = planes(sample_falloff(falloff, facing[some].ravel())).reshape(3, *facing[some].shape)
        part *= facing[some] > 0
        against = (part * part).sum(axis=2, dtype=np.float64)
        found: Floats = (part * light(some)).sum(axis=2, dtype=np.float64) / np.maximum(against, 1e-6)
        return found

    frontal = np.concatenate(in_blocks(fit, *facing.shape), axis=1)
    return falloff, frontal.T.astype(np.float32)


def frontal_colour(samples: LightSamples, falloff: Floats, frontal: Floats, neighbours: Neighbours) -> Floats:
    """The texels' diffuse colour along the normal, (K, 3): light divided by it is irradiance.

    The mean over viewers has the least noise, but its falloff depends on the material: a coat darkens the
    rim, subsurface scattering does not. So it is scaled to the brightness that `frontal` (K, 3), the colour
    pass along the normal, has around each texel; not over the whole surface, as materials differ.
    """
    cosine = _cosine(samples.square[:: max(1, len(samples.square) // 256)])
    in_the_mean = sample_falloff(falloff, cosine.ravel()).mean(axis=0)
    colour: Floats = (samples.colour / np.maximum(in_the_mean, 1e-6)).astype(np.float32)
    both = np.concatenate([frontal, colour], axis=1).T[..., None].astype(np.float32)
    seen, told = np.split(neighbours.pool(np.ascontiguousarray(both))[..., 0].T, 2, axis=1)
    colour *= np.divide(seen, told, out=np.ones_like(told), where=told > _BLACK)
    return colour


def _at_texels(image: Floats, plan: CapturePlan) -> Floats:
    """Sample a finer image (H', W', 3) at the middles of the plan's texels: (K, 3)."""
    size = (plan.layout.width, plan.layout.height)
    j, i = np.divmod(plan.texel, size[0])
    uv = (np.stack([i, j], axis=1) + 0.5) / size
    found: Floats = bilinear(image, uv.astype(np.float32))
    return found
