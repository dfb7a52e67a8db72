# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting the shared layout to single paths: least squares, in turns, over all texels together.

A texel sees a direction once; all texels together see it thousands of times. First the diffuse light is
estimated from every direction of a texel at once. What is left is glossy (`gloss.py`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.gutter import dilate, nearest_covered
from ..core.hemisphere import square_to_direction
from ..core.octahedron import direction_to_octahedron, octahedron_cell
from ..core.shared import SharedAtlas, sample_falloff
from .gloss import LUMINANCE, Gloss, sums
from .light_samples import LightSamples, mirrored
from .plan import CapturePlan

NEARNESS_SIZE = 64
FALLOFF_SIZE = 16
FAR = 100.0  # of the object's size: where the world is
GRAZING = 0.1  # N.I below which a sample is not fitted: the facet's own horizon is near


@dataclass(frozen=True)
class Fitted:
    """An atlas, and the share of the samples' energy that was cut off as fireflies."""

    atlas: SharedAtlas
    fireflies: float


def fit_shared(
    samples: LightSamples, meetings, colour: Floats, cells: int = 16, size: int = 192
) -> Fitted:
    """Fit the shared layout to samples: buckets of cells x cells, surroundings of size x size.

    `colour` (H', W', 3) is the diffuse colour pass along the normal, gutter filled.
    """
    plan = samples.plan
    places = plan.position.reshape(-1, 3)[: len(plan.texel)]
    low, high = places.min(axis=0), places.max(axis=0)
    middle = ((low + high) / 2).astype(np.float32)
    nearness = fit_nearness(meetings, plan, middle, FAR * float(np.linalg.norm(high - low)))
    facing = square_to_direction(samples.square)[..., 2].astype(np.float32)
    used = np.flatnonzero((samples.seen & (facing > GRAZING)).ravel())
    owner = (used // samples.square.shape[1]).astype(np.int32)
    falloff, diffuse = fit_diffuse(samples, facing, used, owner)
    irradiance = _divide_out(diffuse, samples, facing, falloff)
    glossy = samples.radiance.reshape(-1, 3)[used].astype(np.float32)
    glossy -= samples.diffuse.reshape(-1, 3)[used]
    light = np.maximum(glossy, 0)
    gloss = Gloss.prepare(samples, used, owner, light, nearness, middle, cells, size).fit()
    layout = plan.layout
    shape = (layout.height, layout.width)
    atlas = SharedAtlas(
        rest=_placed(gloss.own, plan).reshape(*shape, *gloss.own.shape[1:]),
        surroundings=gloss.surroundings,
        nearness=nearness,
        middle=middle,
        colour=colour.astype(np.float32),
        irradiance=_placed(irradiance, plan).reshape(*shape, 3),
        falloff=falloff,
    )
    return Fitted(atlas, gloss.fireflies)


def fit_nearness(meetings, plan: CapturePlan, middle: Floats, far: float) -> Floats:
    """One over the distance from `middle` of what lies in each direction, the median: (D, D) float32."""
    away = mirrored(plan, meetings.square)
    towards = np.where(meetings.nothing[..., None], far * away, meetings.point - middle)[~meetings.itself]
    distance = np.sqrt(np.sum(towards * towards, axis=-1))
    cell = octahedron_cell(direction_to_octahedron(towards), NEARNESS_SIZE)
    order = np.lexsort((distance, cell))
    first, last = (
        np.searchsorted(cell[order], np.arange(NEARNESS_SIZE**2), side=side) for side in ("left", "right")
    )
    known = last > first
    nearness = np.zeros(NEARNESS_SIZE**2, dtype=np.float32)
    if not known.any():  # the object sees nothing but itself
        return np.full((NEARNESS_SIZE, NEARNESS_SIZE), 1 / far, dtype=np.float32)
    nearness[known] = 1 / np.maximum(distance[order][(first + last - 1)[known] // 2], 1e-6)
    image = nearness.reshape(NEARNESS_SIZE, NEARNESS_SIZE)
    return dilate(image, nearest_covered(known.reshape(image.shape)))


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


def _placed(values: Floats, plan: CapturePlan) -> Floats:
    """Values of the plan's texels (K, ...) in the atlas (H*W, -1) float32, its gutter filled."""
    layout = plan.layout
    flat = np.zeros((layout.height * layout.width, values[0].size), dtype=np.float32)
    flat[plan.texel] = values.reshape(len(values), -1)
    covered = np.zeros(len(flat), dtype=bool)
    covered[plan.texel] = True
    image = flat.reshape(layout.height, layout.width, -1)
    dilate(image, nearest_covered(covered.reshape(image.shape[:2])))
    return flat
