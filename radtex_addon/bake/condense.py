# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Condense a fitted atlas: similar texels form a cluster, and become mixtures of its few buckets.

Clustered principal component analysis (Sloan et al. 2003), two steps in turn: compute each cluster's mean and
components, then move each texel to the nearby cluster that represents it best. Errors are weighted by their
effect on the light: a gain's by the surroundings that it multiplies, a shift's by how fast the surroundings
change there, both relative to the brightness there. Errors below the texel's horizon do not count.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.condensed import CondensedAtlas, CondensedLobe
from ..core.octahedron import cell_directions
from ..core.shared import Axis, Lobe, SharedAtlas
from .plan import CapturePlan
from .surroundings import Surroundings

_ROUNDS = 2
_NEAREST = 8  # nearest clusters that a texel may move to
_MOST_TEXELS = 1024  # texels of a cluster that its components are computed from, at most
_PLACE = 3.0  # weight of positions, in object sizes, against normals when texels are clustered
_HORIZON = -0.15  # N·A of the lowest cells that a fragment of a texel can look up
_SOFT = 0.04  # width of the smooth edge at that limit
_DARK = 0.3  # fraction of the mean light: where it is darker, errors hardly count more
_STEP = 0.05  # step of direction over which the change of the surroundings is measured
_SPREAD_UNIT = 0.3  # weight of a spread's error against a shift's
_TEXELS_AT_ONCE = 4096
_CHANNELS = (4, 3, 3)  # ends, gain, rest


def condense(
    atlas: SharedAtlas, plan: CapturePlan, clusters: int, rank: int = 2
) -> Generator[None, None, CondensedAtlas]:
    """Condense each lobe of the atlas to at most `clusters` clusters of 1 + `rank` buckets.

    Yields between blocks of work.
    """
    lobes = []
    for lobe in atlas.lobes:
        condensed = yield from _Condenser.of(atlas, lobe, plan, rank).lobe(clusters)
        lobes.append(condensed)
    return CondensedAtlas(
        atlas.colour, atlas.irradiance, atlas.falloff, atlas.surroundings, atlas.sharpest, tuple(lobes)
    )


@dataclass(frozen=True, eq=False)
class _Model:
    """A cluster's mean bucket (D,), components (r, D), and the square root of each number's weight (D,)."""

    mean: Floats
    components: Floats
    root: Floats


@dataclass(frozen=True, eq=False)
class _Condenser:
    """Condenses one lobe: `buckets` (K, D) of K texels; `seen` (K, n*n), 0 where no fragment looks, to 1."""

    axis: Axis
    plan: CapturePlan
    rank: int
    n: int
    buckets: Floats
    seen: Floats
    around: Surroundings

    @classmethod
    def of(cls, atlas: SharedAtlas, lobe: Lobe, plan: CapturePlan, rank: int) -> _Condenser:
        n, count = lobe.ends.shape[2], len(plan.texel)
        parts = [
            part.reshape(-1, *part.shape[2:])[plan.texel].reshape(count, -1)
            for part in (lobe.ends, lobe.gain, lobe.rest)
        ]
        cosine = plan.normals @ cell_directions(n).T
        towards = cosine if lobe.axis is Axis.MIRROR else -cosine
        seen = 1 / (1 + np.exp(np.clip((_HORIZON - towards) / _SOFT, -30, 30)))
        around = Surroundings(atlas.surroundings, atlas.sharpest)
        buckets = np.concatenate(parts, axis=1).astype(np.float32)
        return cls(lobe.axis, plan, rank, n, buckets, seen.astype(np.float32), around)

    def lobe(self, clusters: int) -> Generator[None, None, CondensedLobe]:
        place = _places(self.plan)
        own = yield from _nearest_seeds(place, clusters)
        for _ in range(_ROUNDS):
            models = []
            for texels in members(own):
                models.append(self._model(texels))
                yield
            own = yield from self._reassigned(own, models, place)
        return (yield from self._mixtures(own))

    def _model(self, texels: Ints) -> _Model:
        some, seen = self.buckets[texels], self.seen[texels] + 1e-4
        counts = np.concatenate([np.repeat(seen, channels, axis=1) for channels in _CHANNELS], axis=1)
        usual = counts.mean(axis=0)
        mean = (counts * some).mean(axis=0) / usual
        root = np.sqrt(usual * self._importance(mean, seen.mean(axis=0))).astype(np.float32)
        off = (some - mean) * (root * np.sqrt(np.minimum(counts / usual, 1)))
        off = off[:: -(-len(off) // _MOST_TEXELS)]
        values, vectors = np.linalg.eigh(off @ off.T)
        kept = values > 1e-6 * max(float(values[-1]), 1e-12)
        kept[: max(0, len(kept) - self.rank)] = False
        directions = (off.T @ (vectors[:, kept] / np.sqrt(values[kept]))).T
        components = np.zeros((self.rank, len(mean)), dtype=np.float32)
        components[: len(directions)] = directions[::-1]
        return _Model(mean, components, root)

    def _importance(self, mean: Floats, seen: Floats) -> Floats:
        """Weights of squared errors in each number of a bucket near `mean`: (D,)."""
        ends, gain, rest = (part.reshape(self.n**2, -1) for part in self._parts(mean))
        axis = cell_directions(self.n)

        def met(step: Floats) -> Floats:
            return self.around.look(axis + ends[:, :3] + step, np.maximum(ends[:, 3], 0))

        there = met(np.zeros(3, dtype=np.float32))
        bright = np.maximum(gain * there + rest, 0).mean(axis=1)
        level = max(float((bright * seen).sum() / seen.sum()), 1e-6)
        relative = 1 / (bright + _DARK * level) ** 2
        change = np.zeros(len(axis), dtype=np.float32)
        for step in np.eye(3, dtype=np.float32) * np.float32(_STEP):
            change += (np.maximum(gain, 0) * (met(step) - met(-step)) / (2 * _STEP)).mean(axis=1) ** 2
        least = (0.3 * gain * there).mean(axis=1) ** 2
        moved = relative * (change + least + 1e-4 * level**2)
        shown = relative * ((there**2).mean(axis=1) + 0.01 * level**2)
        by_part = (
            moved[:, None] * np.array([1, 1, 1, _SPREAD_UNIT**2], dtype=np.float32),
            np.repeat(shown[:, None], 3, axis=1),
            np.repeat(relative[:, None], 3, axis=1),
        )
        return np.concatenate([part.ravel() for part in by_part])

    def _parts(self, buckets: Floats) -> list[Floats]:
        """Split buckets (..., D) into ends, gain and rest: (..., n*n*channels) each."""
        cuts = np.cumsum([self.n * self.n * channels for channels in _CHANNELS])[:-1]
        return np.split(buckets, cuts, axis=-1)

    def _reassigned(self, own: Ints, models: list[_Model], place: Floats) -> Generator[None, None, Ints]:
        """For each texel the nearby cluster that represents it best: (K,)."""
        near = yield from _nearest(place, _middles(place, own), _NEAREST)
        near = np.column_stack([near, own])
        least = np.full(len(own), np.inf, dtype=np.float32)
        best = own.copy()
        for number, (model, texels) in enumerate(zip(models, members(near), strict=True)):
            off = (self.buckets[texels] - model.mean) * model.root
            error = (off * off).sum(axis=1) - ((off @ model.components.T) ** 2).sum(axis=1)
            better = error < least[texels]
            least[texels[better]] = error[better]
            best[texels[better]] = number
            yield
        _, compact = np.unique(best, return_inverse=True)
        return compact.astype(np.int32)

    def _mixtures(self, own: Ints) -> Generator[None, None, CondensedLobe]:
        count, n = int(own.max()) + 1, self.n
        weights = np.zeros((len(own), self.rank), dtype=np.float32)
        base = np.empty((count, 1 + self.rank, self.buckets.shape[1]), dtype=np.float32)
        for number, texels in enumerate(members(own)):
            model = self._model(texels)
            taken = ((self.buckets[texels] - model.mean) * model.root) @ model.components.T
            most = np.maximum(np.abs(taken).max(axis=0), 1e-12)
            weights[texels] = taken / most
            base[number, 0] = model.mean
            base[number, 1:] = model.components * most[:, None] / model.root
            yield
        parts = (part.reshape(count, 1 + self.rank, n, n, -1) for part in self._parts(base))
        placed = self.plan.placed
        return CondensedLobe(self.axis, placed(own, gutter=True), placed(weights, gutter=True), *parts)


def members(clusters: Ints) -> list[Ints]:
    """The texels of each cluster, ascending; one array for each cluster, in the order of their numbers.

    `clusters` (K, ...): the number of each texel's cluster, or of several; no cluster may be empty.
    """
    count = len(clusters)
    both = np.sort((clusters.reshape(count, -1) * np.int64(count) + np.arange(count)[:, None]).ravel())
    both = both[np.diff(both, prepend=-1) > 0]  # np.unique of millions is ten times slower
    number, texel = np.divmod(both, count)
    return np.split(texel, np.flatnonzero(np.diff(number)) + 1)


def _middles(place: Floats, own: Ints) -> Floats:
    """The mean place of each cluster's texels, (C, 6)."""
    return np.stack([place[texels].mean(axis=0) for texels in members(own)])


def _places(plan: CapturePlan) -> Floats:
    """Texels as points for clustering: positions, scaled to the object's size, and normals, (K, 6)."""
    size = float(np.linalg.norm(np.ptp(plan.points, axis=0)))
    middle = plan.points.mean(axis=0)  # squares of large float32 coordinates cannot tell neighbours apart
    return np.concatenate([(plan.points - middle) * (_PLACE / max(size, 1e-12)), plan.normals], axis=1)


def _nearest_seeds(place: Floats, count: int) -> Generator[None, None, Ints]:
    """The cluster of each texel (K,), of at most `count` clusters, for places (K, 6).

    Seeds are chosen as far from each other as possible, then refined by Lloyd's algorithm.
    """
    seeds = [0]
    distance = np.full(len(place), np.inf, dtype=np.float32)
    own = np.zeros(len(place), dtype=np.int32)
    for number in range(min(count, len(place))):
        off = place - place[seeds[-1]]
        here = (off * off).sum(axis=1)
        closer = here < distance
        own[closer] = number
        distance = np.minimum(distance, here)
        farthest = int(distance.argmax())
        if distance[farthest] <= 0:
            break
        seeds.append(farthest)
        yield
    for _ in range(8):  # rounds of Lloyd's algorithm
        near = yield from _nearest(place, _middles(place, own), 1)
        _, compact = np.unique(near[:, 0], return_inverse=True)
        own = compact.astype(np.int32)
    return own


def _nearest(place: Floats, centres: Floats, count: int) -> Generator[None, None, Ints]:
    """The `count` centres nearest to each place, (K, count), unordered."""
    if count >= len(centres):
        return np.tile(np.arange(len(centres)), (len(place), 1))
    near = np.empty((len(place), count), dtype=np.int32)
    for first in range(0, len(place), _TEXELS_AT_ONCE):
        some = slice(first, first + _TEXELS_AT_ONCE)
        squared = (centres * centres).sum(axis=1) - 2 * (place[some] @ centres.T)
        near[some] = np.argpartition(squared, count, axis=1)[:, :count]
        yield
    return near
