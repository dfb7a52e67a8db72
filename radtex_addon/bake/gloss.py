# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting glossy light: the surroundings that all texels share, and each texel's gain and rest.

First the surroundings that most samples agree on, then each texel's gain and rest, then the surroundings
again. Errors count as the eye sees them, relative to the light there is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..core.arrays import Bools, Floats, Ints
from ..core.gutter import dilate, nearest_covered
from ..core.octahedron import direction_to_octahedron, octahedron_cell, octahedron_taps, sample_octahedron
from ..core.shared import meet_surroundings
from .light_samples import LightSamples, mirrored
from .plan import CapturePlan

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)  # of Rec.709

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


@dataclass(frozen=True, eq=False)
class GlossFit:
    """Surroundings (M, M, 3), rest and gain (K, n, n, 4), the share of fireflies."""

    surroundings: Floats
    own: Floats
    fireflies: float


@dataclass
class Gloss:
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
    ) -> Gloss:
        """Sort the `used` samples (P,), flat indices, whose texels are `owner` (P,) and glossy light `light`.

        The other arguments are those of `fit_shared` and parts of `SharedAtlas`.
        """
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
        bright = samples.radiance.reshape(-1, 3)[used].astype(np.float32) @ LUMINANCE
        level = max(float(bright.mean()), 1e-6) if len(bright) else 1e-6
        return cls(plan, light, fitted, met, cell, judged_place, judged_met, cells, size, level)

    def fit(self) -> GlossFit:
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
        return GlossFit(surroundings.reshape(self.size, -1, 3), own.reshape(-1, n, n, 4), fireflies)

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
            picture = (sums(self.met, trust[:, None] * self.light, self.size**2) / total).astype(np.float32)
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
        kept = np.where(agreed[:, None], sums(self.met, excess, self.size**2) / gain, 0)
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
        total = sums(self.met, pull[:, None] * (self.light - mine[:, :3]), self.size**2)
        return np.maximum((total + prior * last) / (against + prior), 0).astype(np.float32)

    def _own(self, shared: Floats, weight: Floats, count: int) -> Floats:
        """Rest and gain of each cell by weighted least squares, its neighbours' samples counted in."""
        columns = [weight, weight * np.sum(shared**2, axis=1), weight * np.sum(shared * self.light, axis=1)]
        columns += [weight * part[:, c] for part in (shared, self.light) for c in range(3)]
        totals = [self._blurred(np.bincount(self.cell, column, count)) for column in columns]
        w, ss, sy = totals[:3]
        s: Floats = np.stack(totals[3:6], axis=-1)
        y: Floats = np.stack(totals[6:], axis=-1)
        usual = max(_PRIOR * float(w.mean()), 1e-12)
        mean = self._of_texel(y - s) / np.maximum(self._of_texel(w[:, None]), 1e-12)
        w, prior, y = w[:, None] + usual, usual * self.level**2, y + usual * mean
        gain = (sy - np.sum(s * y / w, axis=1) + prior) / (ss - np.sum(s * s / w, axis=1) + prior)
        gain = np.clip(gain, 0, 1.5)[:, None]
        own: Floats = np.concatenate([(y - gain * s) / w, gain], axis=1)
        return own

    def _of_texel(self, totals: Floats) -> Floats:
        """Each cell's sums (K*n*n, C) exchanged for its whole texel's."""
        whole = totals.reshape(len(self.plan.texel), self.cells**2, -1).sum(axis=1)
        return np.repeat(whole, self.cells**2, axis=0)

    def _blurred(self, totals: npt.NDArray[Any]) -> Floats:
        """Sums of cells (K*n*n,), each with its neighbours' in the atlas, at the same R."""
        layout, n = self.plan.layout, self.cells
        image = np.zeros((layout.height * layout.width, n * n), dtype=np.float32)
        image[self.plan.texel] = totals.reshape(-1, n * n)
        blurred = _convolved(_convolved(image.reshape(layout.height, layout.width, n * n), 0), 1)
        return blurred.reshape(-1, n * n)[self.plan.texel].ravel()

    def _weights(self, expected: Floats) -> Floats:
        bright = np.maximum(expected @ LUMINANCE, 0)
        weight: Floats = (self.fitted / (1 + 3 * bright / self.level) ** _EYE).astype(np.float32)
        return weight

    def _display(self, light: Floats) -> Floats:
        shown: Floats = np.clip(light / (3 * self.level), 0, 1) ** np.float32(1 / _GAMMA)
        return shown


def sums(index: Ints, values: npt.NDArray[Any], count: int) -> Floats:
    """Sums of values (P, 3) by index: (count, 3) float64."""
    columns = [np.bincount(index, values[:, c], count) for c in range(values.shape[1])]
    total: Floats = np.stack(columns, axis=-1).astype(np.float64)
    return total


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
