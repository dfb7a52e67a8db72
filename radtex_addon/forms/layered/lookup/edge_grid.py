# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Octahedral pictures that a GPU's own filters read without a seam, and what those filters find in them.

The centres of a level's outermost texels lie on the square's edge, where two of them are the same direction.
A filter that is clamped to the edge thus finds the same on both sides of it, with no border to store.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from ....core.arrays import Floats, Ints
from ....core.octahedron import cell_places, direction_to_octahedron, octahedron_taps, sample_octahedron
from .environment import Impostor, Pictures

_ROUNDS = 3  # by which what a change of grids has blurred is sharpened again


def on_edges(image: Floats) -> Floats:
    """A picture of M x M cells (M, M, C) float32, on M x M places from edge to edge of the square.

    Filtered at the cells' middles it is nearly what it was: interpolation alone would blur it. No value lies
    beyond those of the cells around it: light below 0 would be cut off, and small lamps thus be too bright.
    """
    if (image == image[:1, :1]).all():
        return image
    size = len(image)
    along = np.linspace(0, 1, size, dtype=np.float32)
    place = np.stack(np.meshgrid(along, along), axis=-1)
    half = 0.5 / size
    middles = cell_places(size) * np.float32(1 - 2 * half) + np.float32(half)
    level = np.zeros(len(middles), dtype=np.intp)
    found = sample_octahedron(image, place)
    around = np.stack([image.reshape(size * size, -1)[cell] for cell, _ in octahedron_taps(place, size)])
    least, most = around.min(axis=0), around.max(axis=0)
    for _ in range(_ROUNDS):
        back = EdgePictures((found,), 1.0).bilinear(middles, level)
        found = found + sample_octahedron(image - back.reshape(image.shape), place)
        found = np.clip(found, least, most)
    return found.astype(np.float32)


@dataclass(frozen=True, eq=False)
class EdgePictures(Pictures):
    """Pictures whose levels' outermost texels lie on the square's edge, looked up as a GPU does it.

    One lookup filters two levels at the same coordinates, though their grids differ by a fraction of a texel:
    the coordinates are those of a grid between them. `levels` are powers of two in size.
    """

    def look(self, direction: Floats, variance: Floats) -> Floats:
        last, size = len(self.levels) - 1, len(self.levels[0])
        level = self.level(variance)
        half = 0.5 * np.exp2(level) / size
        place = direction_to_octahedron(direction) * (1 - 2 * half)[:, None] + half[:, None]
        lower, above = self.between(level)
        above, upper = above[:, None], np.minimum(lower + 1, last)
        found = self.bilinear(place, lower) * (1 - above) + self.bilinear(place, upper) * above
        return cast(Floats, found.T.astype(np.float32))

    def bilinear(self, place: Floats, level: Ints) -> Floats:
        """Of one level each, at texture coordinates (N, 2): (N, C), clamped to the edge."""
        flat, first = self._flat
        size = np.right_shift(len(self.levels[0]), level)
        position = np.clip(place * size[:, None] - np.float32(0.5), 0, (size - 1)[:, None])
        low = np.minimum(position.astype(np.intp), (size - 2)[:, None])
        x, y = (position - low).astype(np.float32).T[..., None]
        at = first[level] + low[:, 1] * size + low[:, 0]
        below = flat[at] * (1 - x) + flat[at + 1] * x
        return cast(Floats, below * (1 - y) + (flat[at + size] * (1 - x) + flat[at + size + 1] * x) * y)

    @cached_property
    def _flat(self) -> tuple[Floats, Ints]:
        """The levels' texels one after another, and where each level begins."""
        texels = [level.reshape(-1, level.shape[-1]) for level in self.levels]
        return np.concatenate(texels), np.cumsum([0, *map(len, texels)])[:-1]


@dataclass(frozen=True, eq=False)
class EdgeImpostor(Impostor):
    """An impostor whose distances' outermost texels lie on the square's edge."""

    @cached_property
    def _maps(self) -> _Distances:  # type: ignore[override]  # what `meet` asks of it is the same
        return _Distances(EdgePictures((self.nearness[..., None],), 1.0))


@dataclass(frozen=True, eq=False)
class _Distances:
    """One picture, looked up as `Impostor.meet` asks for it: at places (2, N) on the square."""

    picture: EdgePictures

    def look(self, place: Floats, number: int) -> Floats:
        half = np.float32(0.5 / len(self.picture.levels[number]))
        level = np.full(place.shape[1], number, dtype=np.intp)
        return self.picture.bilinear(place.T * (1 - 2 * half) + half, level).T
