# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting the shared layout to single paths: least squares, in turns, over all texels together.

A texel sees a direction once; all texels together see it thousands of times. First the diffuse light is
estimated from every direction of a texel at once. What is left is glossy: the surroundings that most samples
agree on, then each texel's gain and rest, then the surroundings again. Errors count as the eye sees them,
relative to the light there is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..core.arrays import Bools, Floats, Ints
from ..core.gutter import dilate, nearest_covered
from ..core.hemisphere import square_to_direction
from ..core.octahedron import direction_to_octahedron, octahedron_cell, octahedron_taps, sample_octahedron
from ..core.shared import SharedAtlas, meet_surroundings, sample_falloff
from .light_samples import LightSamples, Meetings, mirrored
from .plan import CapturePlan

NEARNESS_SIZE = 64
FALLOFF_SIZE = 16
FAR = 100.0  # of the object's size: where the world is
GRAZING = 0.1  # N.I below which a sample is not fitted: the facet's own horizon is near

_ROUNDS = 3
_JUDGES = 1 / 8  # share of the samples that are not fitted, but judge the fit
_AGREEMENT_ROUNDS = 4
_DISAGREES = 0.1  # in display values: a sample that far off counts half
_GAMMA = 2.2
_PRIOR = 0.02  # of a cell's mean weight: pulls gain to 1 and rest to 0 where a cell saw little
_EYE = 1.1  # power of the brightness that an error is relative to
_BRIGHTEST = 12.0  # times the mean luminance: a brighter sample is limited while fits are made
_FEW = 2  # samples: that many may all be fireflies
_HIGHLIGHT = 0.08  # share of the samples of a direction that must be as bright for it to be a highlight
_BLUR = np.array([0.054489, 0.244201, 0.402620, 0.244201, 0.054489], dtype=np.float32)  # sigma 1 texel
_CHUNK = 1 << 18  # samples in hand at once
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)


@dataclass(frozen=True)
class Fitted:
    """An atlas, and the share of the samples' energy that was cut off as fireflies."""

    atlas: SharedAtlas
    fireflies: float


def fit_shared(
    samples: LightSamples, meetings: Meetings, colour: Floats, cells: int = 16, size: int = 192
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
    gloss = _Gloss.prepare(samples, used, owner, light, nearness, middle, cells, size).fit()
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


def fit_nearness(meetings: Meetings, plan: CapturePlan, middle: Floats, far: float) -> Floats:
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
    mean = _sums(owner, light, count) / np.maximum(np.bincount(owner, minlength=count), 1)[:, None]
    if not mean.any():
        return np.ones((FALLOFF_SIZE, 3), dtype=np.float32), np.zeros((count, 3), dtype=np.float32)
    step = np.minimum((cosine * FALLOFF_SIZE).astype(np.int32), FALLOFF_SIZE - 1)
    level = mean @ _LUMINANCE
    weight = (1 / (level + level.mean() / 4))[owner][:, None].astype(np.float32)
    seen = _sums(step, weight * mean[owner].astype(np.float32), FALLOFF_SIZE)
    curve = np.divide(_sums(step, weight * light, FALLOFF_SIZE), seen, where=seen > 0, out=np.ones_like(seen))
    known = np.flatnonzero((seen >= 1e-3 * seen.max(axis=0)).all(axis=1))
    for channel in range(3):
        curve[:, channel] = np.interp(np.arange(FALLOFF_SIZE), known, curve[known, channel])
    curve = (curve / np.maximum(curve[-1], 1e-6)).astype(np.float32)
    part = sample_falloff(curve, cosine)
    against = _sums(owner, part * part, count)
    frontal = _sums(owner, part * light, count) / np.maximum(against, 1e-6)
    return curve, frontal.astype(np.float32)


def _divide_out(diffuse: Floats, samples: LightSamples, facing: Floats, falloff: Floats) -> Floats:
    """Irradiance, the diffuse light over its colour: the texels' own colour, at their own points."""
    in_the_mean = sample_falloff(falloff, facing[:: max(1, len(facing) // 256)].ravel()).mean(axis=0)
    colour = samples.colour / np.maximum(in_the_mean, 1e-6)
    divided: Floats = np.divide(diffuse, colour, out=np.zeros_like(diffuse), where=colour > 1e-3)
    return divided


@dataclass(frozen=True, eq=False)
class _GlossFit:
    """Surroundings (M, M, 3), rest and gain (K, n, n, 4), the share of fireflies."""

    surroundings: Floats
    own: Floats
    fireflies: float


@dataclass
class _Gloss:
    """The glossy samples (P,), the cell of R of each, by texel, and the cell of the surroundings it met."""

    plan: CapturePlan
    light: Floats
    fitted: Bools
    met: Ints
    cell: Ints
    judged_place: Floats
    judged_met: Floats
    cells: int
    size: int
    level: float

    @classmethod
    def prepare(
        cls,
        samples: LightSamples,
        used: Ints,
        owner: Ints,
        light: Floats,
        nearness: Floats,
        middle: Floats,
        cells: int,
        size: int,
    ) -> _Gloss:
        plan = samples.plan
        places = plan.position.reshape(-1, 3)
        away = mirrored(plan, samples.square).reshape(-1, 3)
        met, cell = (np.empty(len(used), dtype=np.int32) for _ in range(2))
        fitted = np.random.default_rng(0).random(len(used)) >= _JUDGES
        judged = []
        for first in range(0, len(used), _CHUNK):
            part = slice(first, first + _CHUNK)
            direction = away[used[part]]
            found = meet_surroundings(nearness, middle, places[owner[part]], direction)
            place, there = direction_to_octahedron(direction), direction_to_octahedron(found)
            met[part], cell[part] = octahedron_cell(there, size), octahedron_cell(place, cells)
            judges = ~fitted[part]
            judged.append(np.stack([place[judges], there[judges]]))
        cell += owner * np.int32(cells * cells)
        judged_place, judged_met = np.concatenate([np.zeros((2, 0, 2), np.float32), *judged], axis=1)
        bright = samples.radiance.reshape(-1, 3)[used].astype(np.float32) @ _LUMINANCE
        level = max(float(bright.mean()), 1e-6) if len(bright) else 1e-6
        return cls(plan, light, fitted, met, cell, judged_place, judged_met, cells, size, level)

    def fit(self) -> _GlossFit:
        """Find the surroundings, and each texel's rest and gain.

        Every eighth sample stays out of the fit and judges it: where texels see nothing in common, as through
        glass, a fit without surroundings is the better one.
        """
        excess = self._cut_bright()
        count = len(self.plan.texel) * self.cells**2
        alone = np.zeros((self.size**2, 3), dtype=np.float32)
        flat = self.fitted.astype(np.float32)
        own_alone = self._own(alone[self.met], flat, count)
        surroundings = self._agree()
        own = np.zeros((count, 4), dtype=np.float32)
        own[:, 3] = 1
        for turn in range(_ROUNDS):
            shared, mine = surroundings[self.met], own[self.cell]
            weight = self._weights(mine[:, 3:] * shared + mine[:, :3])
            if turn:
                surroundings = self._surroundings(surroundings, mine, weight)
                shared = surroundings[self.met]
            own = self._own(shared, weight, count)
        if self._error(alone, own_alone) < self._error(surroundings, own):
            surroundings, own = alone, own_alone
            own[:, 3] = 0
        surroundings, fireflies = self._restore_highlights(surroundings, own, excess)
        n = self.cells
        return _GlossFit(surroundings.reshape(self.size, -1, 3), own.reshape(-1, n, n, 4), fireflies)

    def _error(self, surroundings: Floats, own: Floats) -> float:
        """Mean error of the judges in display values, looked up as a fragment at the texel's centre is."""
        judges = np.flatnonzero(~self.fitted)
        if not len(judges):
            return 0.0
        first = self.cell[judges] // self.cells**2 * self.cells**2
        mine = np.zeros((len(judges), 4), dtype=np.float32)
        for cell, weight in octahedron_taps(self.judged_place, self.cells):
            mine += weight[:, None] * own[first + cell]
        shared = sample_octahedron(surroundings.reshape(self.size, self.size, 3), self.judged_met)
        found = np.maximum(mine[:, 3:] * shared + mine[:, :3], 0)
        return float(np.abs(self._display(found) - self._display(self.light[judges])).mean())

    def _agree(self) -> Floats:
        """What most samples see in each direction: a mean without those that disagree, self-reflections."""
        shown = self._display(self.light)
        trust = self.fitted.astype(np.float32)
        picture: Floats = np.zeros((self.size**2, 3), dtype=np.float32)
        for _ in range(_AGREEMENT_ROUNDS):
            total = np.bincount(self.met, trust, self.size**2)[:, None] + 1e-6
            picture = (_sums(self.met, trust[:, None] * self.light, self.size**2) / total).astype(np.float32)
            off = np.abs(self._display(picture)[self.met] - shown).max(axis=1)
            trust = (self.fitted / (1 + (off / _DISAGREES) ** 2)).astype(np.float32)
        return picture

    def _cut_bright(self) -> Floats:
        """Limit samples, lest the few brightest decide every fit; returns what was cut off (P, 3)."""
        limited = np.minimum(self.light, np.float32(_BRIGHTEST * self.level))
        excess = self.light - limited
        self.light = limited
        return excess

    def _restore_highlights(self, surroundings: Floats, own: Floats, excess: Floats) -> tuple[Floats, float]:
        """Give back what was cut off where many samples agree; return the share of the rest, fireflies."""
        cut = excess.any(axis=1)
        seen = np.maximum(np.bincount(self.met, minlength=self.size**2), 1)
        shown = cut & (own[self.cell, 3] > 0)
        agreeing = np.bincount(self.met, shown.astype(np.float32), self.size**2)
        agreed = agreeing > np.maximum(_HIGHLIGHT * seen, _FEW)
        gain = np.maximum(np.bincount(self.met, own[self.cell, 3], self.size**2), 1)[:, None]
        kept = np.where(agreed[:, None], _sums(self.met, excess, self.size**2) / gain, 0)
        total = float(self.light.sum(dtype=np.float64)) + float(excess.sum(dtype=np.float64))
        lost = float(excess[~agreed[self.met]].sum(dtype=np.float64))
        restored = (surroundings + kept).astype(np.float32)
        met = np.bincount(self.met, self.fitted, self.size**2) > 0
        if met.any():
            dilate(restored.reshape(self.size, self.size, 3), nearest_covered(met.reshape(self.size, -1)))
        return restored, lost / max(total, 1e-12)

    def _surroundings(self, last: Floats, mine: Floats, weight: Floats) -> Floats:
        pull = weight * mine[:, 3]
        against = np.bincount(self.met, pull * mine[:, 3], self.size**2)[:, None]
        prior = max(1e-3 * float(against.mean()), 1e-12)
        total = _sums(self.met, pull[:, None] * (self.light - mine[:, :3]), self.size**2)
        return np.maximum((total + prior * last) / (against + prior), 0).astype(np.float32)

    def _own(self, shared: Floats, weight: Floats, count: int) -> Floats:
        """Rest and gain of each cell by weighted least squares, its neighbours' samples counted in."""
        columns = [weight, weight * np.sum(shared**2, axis=1), weight * np.sum(shared * self.light, axis=1)]
        columns += [weight * part[:, c] for part in (shared, self.light) for c in range(3)]
        sums = [self._blurred(np.bincount(self.cell, column, count)) for column in columns]
        w, ss, sy = sums[:3]
        s: Floats = np.stack(sums[3:6], axis=-1)
        y: Floats = np.stack(sums[6:], axis=-1)
        usual = max(_PRIOR * float(w.mean()), 1e-12)
        mean = self._of_texel(y - s) / np.maximum(self._of_texel(w[:, None]), 1e-12)
        w, prior, y = w[:, None] + usual, usual * self.level**2, y + usual * mean
        gain = (sy - np.sum(s * y / w, axis=1) + prior) / (ss - np.sum(s * s / w, axis=1) + prior)
        gain = np.clip(gain, 0, 1.5)[:, None]
        own: Floats = np.concatenate([(y - gain * s) / w, gain], axis=1)
        return own

    def _of_texel(self, sums: Floats) -> Floats:
        """Each cell's sums (K*n*n, C) exchanged for its whole texel's."""
        whole = sums.reshape(len(self.plan.texel), self.cells**2, -1).sum(axis=1)
        return np.repeat(whole, self.cells**2, axis=0)

    def _blurred(self, sums: npt.NDArray[Any]) -> Floats:
        """Sums of cells (K*n*n,), each with its neighbours' in the atlas, at the same R."""
        layout, n = self.plan.layout, self.cells
        image = np.zeros((layout.height * layout.width, n * n), dtype=np.float32)
        image[self.plan.texel] = sums.reshape(-1, n * n)
        blurred = _convolved(_convolved(image.reshape(layout.height, layout.width, n * n), 0), 1)
        return blurred.reshape(-1, n * n)[self.plan.texel].ravel()

    def _weights(self, expected: Floats) -> Floats:
        bright = np.maximum(expected @ _LUMINANCE, 0)
        weight: Floats = (self.fitted / (1 + 3 * bright / self.level) ** _EYE).astype(np.float32)
        return weight

    def _display(self, light: Floats) -> Floats:
        shown: Floats = np.clip(light / (3 * self.level), 0, 1) ** np.float32(1 / _GAMMA)
        return shown


def _convolved(image: Floats, axis: int) -> Floats:
    reach = len(_BLUR) // 2
    total: Floats = _BLUR[reach] * image
    for step in range(1, reach + 1):
        ahead = [slice(None)] * 3
        behind = [slice(None)] * 3
        ahead[axis], behind[axis] = slice(step, None), slice(None, -step)
        total[tuple(behind)] += _BLUR[reach + step] * image[tuple(ahead)]
        total[tuple(ahead)] += _BLUR[reach - step] * image[tuple(behind)]
    return total


def _sums(index: Ints, values: npt.NDArray[Any], count: int) -> Floats:
    """Sums of values (P, 3) by index: (count, 3) float64."""
    columns = [np.bincount(index, values[:, c], count) for c in range(values.shape[1])]
    total: Floats = np.stack(columns, axis=-1).astype(np.float64)
    return total


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
