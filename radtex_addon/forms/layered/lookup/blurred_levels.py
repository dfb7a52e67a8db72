# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Octahedral maps of light, from samples: a sharp one, and ever more blurred copies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.pooling import Taps, corner_cells, corners
from ....core.arrays import Floats, Ints
from ....core.frame import fallback_tangent, orthonormal_frame
from ....core.gutter import dilate, nearest_covered
from ....core.octahedron import cell_directions, direction_to_octahedron

LEAST_LEVEL = 8  # cells along a side of the most blurred level
_SMOOTH = 4.8  # a level's blur (standard deviation, radians) times its cells along a side: hides the cells
_KNOWN = 0.05  # samples in a cell: with fewer, it takes a neighbour's light
_BLUR_TAPS = 64


def blurred_levels(direction: Floats, light: Floats, size: int) -> tuple[tuple[Floats, ...], float]:
    """The means of light (P, C) from unit directions (P, 3) in size x size cells, and blurred copies of them.

    Returns the levels, (M, M, C) float32, of the sizes in `level_sizes`, and the variance `sharpest`: level l
    is blurred by `sharpest` 4^l; the first is blurred by its own cells only.
    """
    sharpest = sharpest_variance(size)
    levels = [mean_map(direction, light, size)]
    for number, side in enumerate(level_sizes(size, level_count(size))):
        if number:
            blurred = sharpest * (4**number - (4 ** (number - 1) if number > 1 else 0))
            levels.append(_blurred(levels[-1], side, blurred))
    return tuple(levels), sharpest


@dataclass(frozen=True, eq=False)
class LevelMaps:
    """Octahedral maps of so many `channels` for many lookups.

    `around` (2 * corners, 2 * D) has the four cells around each corner in two rows, of D >= `channels`: so
    little memory is read at once. The corners of all maps follow each other; `first` is each map's first
    corner, `size` its cells on a side.
    """

    around: Floats
    channels: int
    first: Ints
    size: Ints

    @classmethod
    def of(cls, maps: Sequence[Floats]) -> LevelMaps:
        """From maps (M, M, C), whose M may differ."""
        size = np.array([len(image) for image in maps])
        first = np.concatenate([[0], np.cumsum((size + 1) ** 2)])
        channels = maps[0].shape[2]
        around = np.zeros((int(first[-1]), 4, 1 << (channels - 1).bit_length()), dtype=np.float32)
        for image, begin, end in zip(maps, first[:-1], first[1:], strict=True):
            cells = image.reshape(-1, channels)[corner_cells(len(image))]
            around[begin:end, :, :channels] = cells.swapaxes(0, 1)
        return cls(around.reshape(2 * len(around), -1), channels, first[:-1], size)

    def look(self, place: Floats, number: Ints | int) -> Floats:
        """Look places (2, P) up, each in the map with its `number` (P,), or all in one map: (C, P)."""
        corner, weights = corners(place, self.size[number])
        row = 2 * (corner + self.first[number])
        light = np.zeros((self.channels, place.shape[1]), dtype=np.float32)
        for lower in (0, 1):
            cells = self.around.take(row + lower, axis=0).reshape(len(row), 2, self.around.shape[1] // 2)
            for side in (0, 1):
                for channel in range(self.channels):
                    light[channel] += weights[2 * lower + side] * cells[:, side, channel]
        return light


def mean_map(direction: Floats, light: Floats, size: int) -> Floats:
    """The means of light (P, C) in size x size cells, (M, M, C) float32; empty cells take a neighbour's."""
    place = planes(direction_to_octahedron(direction))[:, None]
    columns = [*planes(light)[:, None], np.ones((1, len(light)), dtype=np.float32)]
    total = Taps.of(place, size).scatter(columns)[:, 0]
    known = total[-1] > _KNOWN
    image = (total[:-1] / np.maximum(total[-1], 1e-6)).astype(np.float32).T.reshape(size, size, -1)
    if not known.any():
        return np.zeros_like(image)
    return dilate(image, nearest_covered(known.reshape(size, size)))


def _blurred(image: Floats, size: int, variance: float) -> Floats:
    """The image (M, M, C) blurred by a von Mises-Fisher lobe, `variance` along each axis: (size, size, C)."""
    direction = cell_directions(size)
    tangent, bitangent, _ = orthonormal_frame(direction, fallback_tangent(direction), np.ones(len(direction)))
    share = (np.arange(_BLUR_TAPS) + 0.5) / _BLUR_TAPS
    cosine = 1 + variance * np.log(share + (1 - share) * np.exp(-2 / variance))
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    azimuth = np.arange(_BLUR_TAPS) * np.pi * (3 - np.sqrt(5))
    direction, tangent, bitangent = (planes(axis).T for axis in (direction, tangent, bitangent))
    maps = LevelMaps.of([image])

    def blurred(some: slice) -> Floats:
        total = np.zeros((image.shape[2], some.stop - some.start), dtype=np.float32)
        for c, s, turn in zip(cosine.tolist(), sine.tolist(), azimuth.tolist(), strict=True):
            around = cos(turn) * tangent[some] + sin(turn) * bitangent[some]
            total += maps.look(direction_to_octahedron(c * direction[some] + s * around).T, 0)
        return total / _BLUR_TAPS

    return np.concatenate(in_blocks(blurred, size * size, 1), axis=1).T.reshape(size, size, -1)


def sharpest_variance(size: int) -> float:
    """The variance, radians², of which level l > 0 of pictures with `size` cells a side has 4^l times."""
    return (_SMOOTH / size) ** 2


def level_count(size: int) -> int:
    """Number of levels of surroundings with `size` cells a side: each half as large, down to LEAST_LEVEL."""
    return max(size // LEAST_LEVEL, 1).bit_length()


def level_sizes(size: int, count: int) -> list[int]:
    """Cells along a side of each of `count` levels of the surroundings, the sharpest having `size`."""
    return [max(size >> level, LEAST_LEVEL) for level in range(count)]
