# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The octahedral map: all directions on one square, and bilinear lookups that wrap around its edges.

Meyer et al., "On Floating-Point Normal Vectors" (2010): the unit sphere is projected onto the octahedron
|x| + |y| + |z| = 1 and its lower half folded outwards. +z is the square's middle, -z its four corners.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .arrays import Floats, Ints, as_floats
from .errors import ShapeError

_TINY = 1e-30  # avoids 0/0: the zero vector maps to the middle


def direction_to_octahedron(direction: Floats) -> Floats:
    """Place of directions on the square: (..., 3), of any length -> (..., 2) in [0, 1].

    x and y lie apart in memory: NumPy is fast only along a long axis. Nor is there a `where`, whose branches
    cost as much as all the rest.
    """
    direction = as_floats("direction", direction, 3)
    x, y, z = direction[..., 0], direction[..., 1], direction[..., 2]
    sums = np.maximum(np.abs(x) + np.abs(y) + np.abs(z), _TINY)
    x, y, below = x / sums, y / sums, (z < 0).astype(direction.dtype)
    above = 1 - below
    folded = np.copysign(1 - np.abs(y), x + 0), np.copysign(1 - np.abs(x), y + 0)  # -0 is on the side of 0
    place = [(there * below + here * above) * 0.5 + 0.5 for there, here in zip(folded, (x, y), strict=True)]
    return np.moveaxis(np.stack(place), 0, -1)


def octahedron_to_direction(place: Floats) -> Floats:
    """Unit direction of a place on the square: (..., 2) -> (..., 3)."""
    xy = as_floats("place", place, 2) * 2 - 1
    z = 1 - np.abs(xy).sum(axis=-1, keepdims=True)
    folded = (1 - np.abs(xy[..., ::-1])) * np.where(xy >= 0, 1, -1).astype(xy.dtype)
    direction = np.concatenate([np.where(z < 0, folded, xy), z], axis=-1)
    unit: Floats = direction / np.sqrt(np.sum(direction * direction, axis=-1, keepdims=True))
    return unit


def cell_places(size: int) -> Floats:
    """Centres of size x size cells on the square, row by row: (size * size, 2) float32."""
    middle = ((np.arange(size) + 0.5) / size).astype(np.float32)
    return np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)


def cell_directions(size: int) -> Floats:
    """Unit directions of the centres of size x size cells: (size * size, 3) float32."""
    return octahedron_to_direction(cell_places(size))


def octahedron_cell(place: Floats, size: int) -> Ints:
    """Flat index y * size + x of the cell that holds each place (..., 2), on a map of size x size cells."""
    place = as_floats("place", place, 2)
    cell = np.minimum((place * size).astype(np.int32), size - 1)
    index: Ints = cell[..., 1] * size + cell[..., 0]
    return index


def octahedron_taps(place: Floats, size: int) -> Iterator[tuple[Ints, Floats]]:
    """Yield the four cells around each place (..., 2), by flat index, and their weights, both (...).

    A cell beyond an edge is replaced by its neighbour on the sphere: on the same edge, mirrored about the
    edge's middle.
    """
    place = as_floats("place", place, 2)
    position = place * place.dtype.type(size) - place.dtype.type(0.5)
    corner = np.floor(position)
    fraction = position - corner
    for dy in (0, 1):
        for dx in (0, 1):
            x, y = corner[..., 0].astype(np.int32) + dx, corner[..., 1].astype(np.int32) + dy
            beyond_x, beyond_y = (x < 0) | (x >= size), (y < 0) | (y >= size)
            x, y = (
                np.where(beyond_y, size - 1 - x, np.clip(x, 0, size - 1)),
                np.where(beyond_x, size - 1 - y, np.clip(y, 0, size - 1)),
            )
            x, y = np.clip(x, 0, size - 1), np.clip(y, 0, size - 1)
            weight = np.prod(np.where(np.array([dx, dy]) == 1, fraction, 1 - fraction), axis=-1)
            yield y * size + x, weight


def sample_octahedron(image: Floats, place: Floats) -> Floats:
    """Bilinear lookup: image (M, M, C), place (..., 2) -> (..., C). Raises ShapeError for other shapes."""
    if image.ndim != 3 or image.shape[0] != image.shape[1]:
        raise ShapeError(f"octahedral image: expected shape (M, M, C), got {image.shape}")
    size = len(image)
    cells = image.reshape(size * size, -1)
    taps = [cells[index] * weight[..., None] for index, weight in octahedron_taps(place, size)]
    return np.asarray(taps[0] + taps[1] + taps[2] + taps[3])
