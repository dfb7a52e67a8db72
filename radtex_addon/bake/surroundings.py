# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of the surroundings, from samples of the arriving light: a sharp one, and ever more blurred copies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.frame import fallback_tangent, orthonormal_frame
from ..core.gutter import dilate, nearest_covered
from ..core.octahedron import cell_directions, direction_to_octahedron, octahedron_cell
from ..core.shared import level_count, level_sizes
from .blocks import in_blocks, planes
from .light_samples import SurroundingsSamples
from .pooling import Taps, corner_cells, corners

NEARNESS_SIZE = 64
_SMOOTH = 4.8  # a level's blur (standard deviation, radians) times its cells along a side: hides the cells
_KNOWN = 0.05  # samples in a cell: with fewer, it takes a neighbour's light
_BLUR_TAPS = 64
_MEETINGS = 6  # iterations to find what a ray meets


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Levels as in `core.shared.SharedAtlas`; the sharpest is blurred by its own cells only."""

    levels: tuple[Floats, ...]
    sharpest: float

    @classmethod
    def of(cls, samples: SurroundingsSamples, size: int) -> Surroundings:
        """Average the samples in size x size cells, and make the blurred copies."""
        sharpest = (_SMOOTH / size) ** 2
        levels = [_means(samples, size)]
        for number, side in enumerate(level_sizes(size, level_count(size))):
            if number:
                blurred = sharpest * (4**number - (4 ** (number - 1) if number > 1 else 0))
                levels.append(_blurred(levels[-1], side, blurred))
        return cls(tuple(levels), sharpest)

    def look(self, direction: Floats, spread: Floats) -> Floats:
        """The light around directions (P, 3), blurred by variances (P,): (P, 3) float32.

        Like `core.shared.sample_surroundings`, but faster for many directions.
        """
        place = direction_to_octahedron(direction).T
        last = len(self.levels) - 1
        level = np.clip(np.log2(np.maximum(spread, 1e-12) / self.sharpest) / 2, 0, last).astype(np.float32)
        lower = np.minimum(level.astype(np.intp), max(last - 1, 0))
        light = np.zeros((3, len(direction)), dtype=np.float32)
        for number, share in ((lower, 1 - (level - lower)), (np.minimum(lower + 1, last), level - lower)):
            light += self._maps.look(place, number) * share.astype(np.float32)
        return light.T

    @cached_property
    def _maps(self) -> LevelMaps:
        return LevelMaps.of(self.levels)


@dataclass(frozen=True, eq=False)
class LevelMaps:
    """Octahedral maps for many lookups: `around` (4, C, corners) has the four cells around each corner.

    The corners of all maps follow each other; `first` is each map's first corner, `size` its cells on a side.
    """

    around: Floats
    first: Ints
    size: Ints

    @classmethod
    def of(cls, maps: Sequence[Floats]) -> LevelMaps:
        """From maps (M, M, C), whose M may differ."""
        size = np.array([len(image) for image in maps])
        around = [planes(image.reshape(len(image) ** 2, -1))[:, corner_cells(len(image))] for image in maps]
        first = np.concatenate([[0], np.cumsum((size + 1) ** 2)[:-1]])
        return cls(np.ascontiguousarray(np.concatenate(around, axis=2).swapaxes(0, 1)), first, size)

    def look(self, place: Floats, number: Ints | int) -> Floats:
        """Look places (2, P) up, each in the map with its `number` (P,), or all in one map: (C, P)."""
        corner, weights = corners(place, self.size[number])
        corner = corner + self.first[number]
        light = np.zeros((self.around.shape[1], place.shape[1]), dtype=np.float32)
        for cells, weight in zip(self.around, weights, strict=True):
            light += [weight * values.take(corner) for values in cells]
        return light


def nearness_map(samples: SurroundingsSamples, far: float) -> Floats:
    """For each direction from the middle, one over the samples' median distance: (D, D) float32.

    Distances are at most `far`; directions without samples take a neighbour's.
    """
    cell = octahedron_cell(direction_to_octahedron(samples.direction), NEARNESS_SIZE)
    near = np.maximum(samples.nearness, 1 / far)
    order = np.lexsort((near, cell))
    first, last = (
        np.searchsorted(cell[order], np.arange(NEARNESS_SIZE**2), side=side) for side in ("left", "right")
    )
    known = last > first
    if not known.any():  # all rays met the object itself
        return np.full((NEARNESS_SIZE, NEARNESS_SIZE), 1 / far, dtype=np.float32)
    nearness = np.zeros(NEARNESS_SIZE**2, dtype=np.float32)
    nearness[known] = near[order][(first + last - 1)[known] // 2]
    image = nearness.reshape(NEARNESS_SIZE, NEARNESS_SIZE)
    return dilate(image, nearest_covered(known.reshape(image.shape)))


def meet_surroundings(nearness: Floats, middle: Floats, position: Floats, direction: Floats) -> Floats:
    """What rays from positions (K, 3) along unit directions (K, 3) meet, as unit directions from the middle.

    Returns (K, 3). `nearness` (D, D) is a `nearness_map`. Iterates: intersect the ray with a sphere
    around the middle whose radius is the distance in the direction found last. Szirmay-Kalos et al.,
    "Approximate Ray-Tracing on the GPU with Distance Impostors" (2005).
    """
    offset, direction = (planes(vectors).T for vectors in (position - middle, direction))
    along = np.sum(offset * direction, axis=1)
    squared = np.sum(offset * offset, axis=1)
    found, maps = direction, LevelMaps.of([nearness[..., None]])
    for _ in range(_MEETINGS):
        near = maps.look(direction_to_octahedron(found).T, 0)[0]
        distance = np.sqrt(np.maximum(along * along - squared + 1 / (near * near), 0)) - along
        reached = offset + distance[:, None] * direction
        found = reached / np.sqrt(np.sum(reached * reached, axis=1, keepdims=True))
    return found


def _means(samples: SurroundingsSamples, size: int) -> Floats:
    place = planes(direction_to_octahedron(samples.direction))[:, None]
    columns = [*planes(samples.radiance)[:, None], np.ones((1, len(samples.radiance)), dtype=np.float32)]
    total = Taps.of(place, size).scatter(columns)[:, 0]
    known = total[3] > _KNOWN
    image = (total[:3] / np.maximum(total[3], 1e-6)).astype(np.float32).T.reshape(size, size, 3)
    if not known.any():
        return np.zeros_like(image)
    return dilate(image, nearest_covered(known.reshape(size, size)))


def _blurred(image: Floats, size: int, variance: float) -> Floats:
    """The image (M, M, 3) blurred by a von Mises-Fisher lobe, `variance` along each axis: (size, size, 3)."""
    direction = cell_directions(size)
    tangent, bitangent, _ = orthonormal_frame(direction, fallback_tangent(direction), np.ones(len(direction)))
    share = (np.arange(_BLUR_TAPS) + 0.5) / _BLUR_TAPS
    cosine = 1 + variance * np.log(share + (1 - share) * np.exp(-2 / variance))
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    azimuth = np.arange(_BLUR_TAPS) * np.pi * (3 - np.sqrt(5))
    direction, tangent, bitangent = (planes(axis).T for axis in (direction, tangent, bitangent))
    maps = LevelMaps.of([image])

    def blurred(some: slice) -> Floats:
        total = np.zeros((3, some.stop - some.start), dtype=np.float32)
        for c, s, turn in zip(cosine.tolist(), sine.tolist(), azimuth.tolist(), strict=True):
            around = cos(turn) * tangent[some] + sin(turn) * bitangent[some]
            total += maps.look(direction_to_octahedron(c * direction[some] + s * around).T, 0)
        return total / _BLUR_TAPS

    return np.concatenate(in_blocks(blurred, size * size, 1), axis=1).T.reshape(size, size, 3)
