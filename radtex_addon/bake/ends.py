# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit where a lobe's light comes from: each cell's shift and spread, from the ends of single paths.

Coarse to fine: first the shift that neighbouring texels share in wide cells, then what remains in finer
cells. A step is reduced by the share of it that its paths' noise explains (James and Stein, "Estimation with
Quadratic Loss", 1961), so that neighbouring cells stay alike on a rough surface but not on a sharp one.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..core.arrays import Floats
from ..core.octahedron import cell_directions
from .blocks import in_blocks
from .pooling import SHARE, WIDER, Neighbours, Taps, upsampled
from .surroundings import meet_surroundings

_STAGES = ((2, True), (4, True), (8, True), (8, False))  # cells along a side, pooled widely?; finest follow
_FINEST_ROUNDS = 2
_DOUBT = 0.7  # times the variance of a cell's mean: a squared step no larger than that is noise
_LEAST_SCALE = 0.05  # radians: a path that ends this near is no outlier
_SPREAD_PRIOR = 8.0  # weight of a coarser cell's spread, in paths
_TRUSTED = 0.807  # share of a Gaussian lobe's variance that is left when outliers count less
_RAYLEIGH_QUARTER = 0.575  # lower quartile of a distance, squared, over the variance along one axis


@dataclass(frozen=True, eq=False)
class LobePaths:
    """A lobe's paths, S for each of K texels, float32, channels first.

    `place` (2, K, S): each path's axis on the octahedron's square; `moved` (3, K, S): the direction of its
    end minus its axis, in world space; `weight` (K, S): luminance of the light that the object lets through,
    0 for paths that do not count.
    """

    place: Floats
    moved: Floats
    weight: Floats


def stages(n: int) -> list[tuple[int, bool]]:
    """The stages of `fit_ends` for buckets of n x n cells: cells along a side, and whether pooled widely."""
    return [(cells, wide) for cells, wide in _STAGES if cells < n] + [(n, False)] * _FINEST_ROUNDS


def fit_ends(
    paths: LobePaths, neighbours: Neighbours, n: int, start: Floats
) -> Generator[None, None, Floats]:
    """Fit shift and spread of each cell, (4, K, n*n), as in `core.shared.Lobe`.

    `start` (3, K, n*n) is the initial shift. Yields after each stage.
    """
    if not paths.weight.any():
        return np.concatenate([start, np.zeros_like(start[:1])])
    fit = _EndsFit(paths, neighbours, n, start)
    fit.look_again()
    for cells, wide in stages(n):
        fit.improve(cells, wide)
        fit.look_again()
        yield
    return np.concatenate([fit.shift, fit.spread()])


class _EndsFit:
    """The shift so far (3, K, n*n), and how far it is off.

    `off` (3, K, S), `distance` (K, S): from where the shift predicts a path's end to where it is. `scale`
    (K, 1): distances beyond it are a texel's outliers. `noise` (K, 1): the ends' variance along one axis.
    """

    def __init__(self, paths: LobePaths, neighbours: Neighbours, n: int, start: Floats) -> None:
        self.paths, self.neighbours, self.n = paths, neighbours, n
        self.number = int(np.count_nonzero(paths.weight))
        self.mean_weight = max(float(paths.weight.sum(dtype=np.float64)) / self.number, 1e-12)
        self.shift = start.astype(np.float32)
        self.off = np.empty_like(paths.moved)
        self.distance = np.empty_like(paths.weight)
        self.scale = self.noise = np.empty((paths.weight.shape[0], 1), dtype=np.float32)

    def look_again(self) -> None:
        """Compute `off`, `distance`, `scale` and `noise` for the current shift."""
        paths, quartiles = self.paths, np.zeros((3, len(self.distance), 1), dtype=np.float32)

        def look(some: slice) -> None:
            taps = Taps.of(paths.place[:, some], self.n)
            self.off[:, some] = paths.moved[:, some] - taps.gather(self.shift[:, some])
            self.distance[some] = np.sqrt((self.off[:, some] ** 2).sum(axis=0))
            told = paths.weight[some] > 0
            number = told.sum(axis=1)[:, None]
            ranked = np.sort(np.where(told, self.distance[some], np.float32(np.inf)), axis=1)
            for row, part in zip(quartiles, (2, 4), strict=False):
                row[some] = np.where(number, np.take_along_axis(ranked, number // part, axis=1), 0)
            quartiles[2, some] = number > 0

        in_blocks(look, *self.distance.shape)
        pooled = self.neighbours.pool(quartiles)
        median, quartile = pooled[:2] / np.maximum(pooled[2], 1e-6)
        self.scale = np.maximum(2 * median, _LEAST_SCALE)
        self.noise = quartile**2 / _RAYLEIGH_QUARTER

    def counted(self, some: slice) -> Floats:
        """Weights of some texels' paths, (k, S): the farther a path ends from its prediction, the lower."""
        counted: Floats = self.paths.weight[some] / (1 + (self.distance[some] / self.scale[some]) ** 2)
        return counted

    def improve(self, cells: int, wide: bool) -> None:
        """Add to the shift the mean of `off` in each of cells x cells cells, reduced where it is noise."""
        table = np.empty((4, len(self.distance), cells * cells), dtype=np.float32)

        def sum_up(some: slice) -> None:
            counted = self.counted(some)
            taps = Taps.of(self.paths.place[:, some], cells)
            table[:, some] = taps.scatter([*(counted * self.off[:, some]), counted])

        in_blocks(sum_up, *self.distance.shape)
        wide |= self.neighbours.few
        table = self.neighbours.pool(table, wide)
        step = table[:3] / (table[3] + max(1e-3 * float(table[3].mean()), 1e-12))
        left = SHARE * (WIDER if wide else 1.0) * self.mean_weight / np.maximum(table[3], 1e-12)
        step *= np.maximum(0, 1 - _DOUBT * self.noise * left / np.maximum((step * step).sum(axis=0), 1e-12))
        self.shift += upsampled(step, self.n)

    def spread(self) -> Floats:
        """The variance along one axis of the paths' ends in each cell, (1, K, n*n).

        Cells with few paths rely on coarser cells.
        """
        sizes = sorted({cells for cells, _ in stages(self.n)} | {1})
        tables = {n: np.empty((2, len(self.distance), n * n), dtype=np.float32) for n in sizes}

        def sum_up(some: slice) -> float:
            counted = self.counted(some)
            columns = [counted * (self.distance[some] ** 2 / np.float32(2 * _TRUSTED)), counted]
            for n, table in tables.items():
                table[:, some] = Taps.of(self.paths.place[:, some], n).scatter(columns)
            return float(counted.sum(dtype=np.float64))

        total = sum(in_blocks(sum_up, *self.distance.shape))
        prior = _SPREAD_PRIOR * max(total / self.number, 1e-12)
        squares, weights = self.neighbours.pool(tables.pop(1))[:, None]
        spread: Floats = squares / np.maximum(weights, 1e-9)
        for n in sizes[1:]:
            squares, weights = self.neighbours.pool(tables.pop(n))[:, None]
            spread = (squares + prior * upsampled(spread, n)) / (weights + prior)
        return spread


def parallax(nearness: Floats, middle: Floats, places: Floats, n: int) -> Floats:
    """The shift (3, K, n*n) due to parallax, for mirror rays from places (K, 3).

    For each cell's axis: the direction from the middle to what the ray meets, minus the axis. `nearness` and
    `middle` are as for `meet_surroundings`.
    """
    axis = cell_directions(n)
    shift = np.empty((3, len(places), n * n), dtype=np.float32)

    def meet(some: slice) -> None:
        count = some.stop - some.start
        away = np.tile(axis, (count, 1))
        found = meet_surroundings(nearness, middle, np.repeat(places[some], n * n, axis=0), away)
        shift[:, some] = (found - away).T.reshape(3, count, n * n)

    in_blocks(meet, len(places), n * n)
    return shift
