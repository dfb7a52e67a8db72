# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a lobe's light comes from: each cell's shift and spread, from where single paths end.

From coarse to fine: what texels of a neighbourhood have in common in wide cells first, then what is left in
finer ones. A step counts by how far it stands out from the noise of its paths (James and Stein, "Estimation
with Quadratic Loss", 1961), so that a rough surface's cells stay together and a sharp one's do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.arrays import Bools, Floats, Ints
from ..core.octahedron import octahedron_to_direction
from .pooling import SHARE, Neighbours, Taps, upsampled
from .surroundings import meet_surroundings

_STAGES = ((2, True), (4, True), (8, True), (8, False))  # cells of a bucket, pooled widely? the finest follow
_FINEST_ROUNDS = 2
_WIDER = 0.1  # of the variance that pooling leaves: what wide pooling does
_DOUBT = 0.7  # times the variance of a cell's mean: a step no larger than that is noise
_LEAST_SCALE = 0.05  # radians: no path that near is an outlier
_SPREAD_PRIOR = 8.0  # paths that a coarser cell's spread counts for
_TRUSTED = 0.807  # of a Gaussian lobe's variance: what is left of it where paths count by their trust
_RAYLEIGH_QUARTER = 0.575  # squared lower quartile of a distance, over the variance along an axis
_TEXELS_AT_ONCE = 512


@dataclass(frozen=True, eq=False)
class LobePaths:
    """A lobe's P paths: `axis` and `end` (P, 3), directions in the world; `owner` (P,) texel numbers.

    `weight` (P,): how much of the light there the object lets through, in luminance.
    """

    axis: Floats
    end: Floats
    owner: Ints
    weight: Floats

    def only(self, some: Bools) -> LobePaths:
        """Those of the paths, (P,)."""
        return LobePaths(self.axis[some], self.end[some], self.owner[some], self.weight[some])


def fit_ends(paths: LobePaths, neighbours: Neighbours, n: int, start: Floats) -> Floats:
    """Shift and spread of each cell (K*n*n, 4), as in `core.shared.Lobe`.

    `start` (K*n*n, 3) is a first shift.
    """
    texels = len(neighbours.plan.texel)
    shift = start.astype(np.float32)
    if not len(paths.owner):
        return np.concatenate([shift, np.zeros((len(shift), 1), np.float32)], axis=1)
    moved = paths.end - paths.axis
    stages = [(cells, wide) for cells, wide in _STAGES if cells < n] + [(n, False)] * _FINEST_ROUNDS
    taps = {cells: Taps.of(paths.axis, paths.owner, texels, cells) for cells in {*dict(stages), 1, n}}
    mean_weight = max(float(paths.weight.mean()), 1e-12)
    trust, noise = _trust(moved - taps[n].gather(shift), paths.owner, neighbours)
    for cells, wide in stages:
        off = moved - taps[n].gather(shift)
        counted = paths.weight * trust
        table = neighbours.pool(taps[cells].scatter([*(counted[:, None] * off).T, counted]), wide)
        step = table[:, :3] / (table[:, 3:] + max(1e-3 * float(table[:, 3].mean()), 1e-12))
        left = SHARE * (_WIDER if wide else 1.0) * mean_weight / np.maximum(table[:, 3], 1e-12)
        doubt = _DOUBT * np.repeat(noise, cells * cells) * left
        step *= np.maximum(0, 1 - doubt / np.maximum(np.sum(step * step, axis=1), 1e-12))[:, None]
        shift += upsampled(step, texels, cells, n)
        trust, noise = _trust(moved - taps[n].gather(shift), paths.owner, neighbours)
    off = moved - taps[n].gather(shift)
    spread = _spread(np.sum(off * off, axis=1) / (2 * _TRUSTED), paths.weight * trust, taps, neighbours)
    return np.concatenate([shift, spread], axis=1)


def parallax(nearness: Floats, middle: Floats, places: Floats, n: int) -> Floats:
    """Shifts by which mirror rays from places (K, 3) find near things, (K*n*n, 3)."""
    cell = ((np.arange(n) + 0.5) / n).astype(np.float32)
    axis = octahedron_to_direction(np.stack(np.meshgrid(cell, cell), axis=-1).reshape(-1, 2))
    shift = np.empty((len(places), n * n, 3), dtype=np.float32)
    for first in range(0, len(places), _TEXELS_AT_ONCE):
        some = places[first : first + _TEXELS_AT_ONCE]
        away = np.tile(axis, (len(some), 1))
        found = meet_surroundings(nearness, middle, np.repeat(some, n * n, axis=0), away)
        shift[first : first + len(some)] = (found - away).reshape(len(some), n * n, 3)
    return shift.reshape(-1, 3)


def _trust(off: Floats, owner: Ints, neighbours: Neighbours) -> tuple[Floats, Floats]:
    """How much each path counts, (P,), less the farther it is off; and the texels' noise (K,), a variance."""
    texels = len(neighbours.plan.texel)
    distance = np.sqrt(np.sum(off * off, axis=1))
    order = np.lexsort((distance, owner))
    number = np.bincount(owner, minlength=texels)
    first = np.searchsorted(owner[order], np.arange(texels))
    known = number > 0
    table = np.zeros((texels, 3), dtype=np.float32)
    table[known, 0] = distance[order][(first + number // 2)[known]]
    table[known, 1] = distance[order][(first + number // 4)[known]]
    table[known, 2] = 1
    table = neighbours.pool(table)
    median, quartile = table[:, :2].T / np.maximum(table[:, 2], 1e-6)
    scale = np.maximum(2 * median, _LEAST_SCALE)[owner]
    return (1 / (1 + (distance / scale) ** 2)).astype(np.float32), quartile**2 / _RAYLEIGH_QUARTER


def _spread(squared: Floats, weight: Floats, taps: dict[int, Taps], neighbours: Neighbours) -> Floats:
    """The finest cells' mean of squares (P,), (K*n*n, 1); what few paths tell is taken from coarser cells."""
    texels = len(neighbours.plan.texel)
    prior = _SPREAD_PRIOR * max(float(weight.mean()), 1e-12)
    spread: Floats = np.zeros((texels, 1), dtype=np.float32)
    coarser = 1
    for cells in sorted(taps):
        table = neighbours.pool(taps[cells].scatter([weight * squared, weight]))
        if cells == 1:
            spread = table[:, :1] / np.maximum(table[:, 1:], 1e-9)
            continue
        known = upsampled(spread, texels, coarser, cells)
        spread = ((table[:, :1] + prior * known) / (table[:, 1:] + prior)).astype(np.float32)
        coarser = cells
    return spread
