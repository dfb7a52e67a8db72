# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout: one sharp picture of the surroundings, and how each texel reflects or transmits it.

    radiance = colour(uv) irradiance(uv) falloff(N.V)
             + for each lobe:  gain(uv, A) surroundings(A + shift(uv, A), spread(uv, A)) + rest(uv, A)

A lobe's axis A is a world direction at the fragment: the mirror direction of the viewer, or straight through
the surface. The lobe's light is looked up in the surroundings around the direction A + shift, blurred by
`spread`: shift accounts for nearby things, for further reflections at the object and for refraction.
`surroundings` is one picture for all texels, more blurred at each level. Shift, spread, gain and rest are
buckets over the octahedron of A: neighbouring texels are blended at the same world direction, not at the same
angle to their normals, so that blending on a curved surface does not blur reflections.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from .arrays import Floats, Ints, as_floats
from .errors import ShapeError
from .octahedron import direction_to_octahedron, octahedron_taps, sample_octahedron

LEAST_LEVEL = 8  # cells along a side of the most blurred surroundings


class Axis(StrEnum):
    """The direction that indexes a lobe's buckets: the viewer's mirror direction or the line of sight."""

    MIRROR = "mirror"
    THROUGH = "through"


@dataclass(frozen=True, eq=False)
class Lobe:
    """One lobe's buckets, indexed [j, i, y, x], the last two on the octahedron of its axis; float32.

    `ends` (H, W, n, n, 4): shift (3), then spread (1), the variance in radians² along each of two axes.
    `gain` and `rest` (H, W, n, n, 3), linear RGB. Raises ShapeError if shapes do not fit.
    """

    axis: Axis
    ends: Floats
    gain: Floats
    rest: Floats

    def __post_init__(self) -> None:
        base = self.ends.shape[:-1]
        square = len(base) == 4 and base[2] == base[3]
        for name, channels in (("ends", 4), ("gain", 3), ("rest", 3)):
            shape = getattr(self, name).shape
            if not square or shape != (*base, channels):
                raise ShapeError(f"{self.axis} {name}: expected shape (H, W, n, n, {channels}), got {shape}")


@dataclass(frozen=True, eq=False)
class SharedAtlas:
    """A bake in the shared layout; float32, scene-linear Rec.709, row 0 at v = 0, world space.

    `colour` (H', W', 3), `irradiance` (H, W, 3), and `falloff` (B, 3) at N.V = (k + 0.5) / B. `surroundings`:
    level l is (max(M / 2^l, 8),) * 2 + (3,), on the octahedron of directions, blurred by a variance of
    `sharpest` 4^l. `lobes` share H, W and n. Raises ShapeError if shapes do not fit.
    """

    colour: Floats
    irradiance: Floats
    falloff: Floats
    surroundings: tuple[Floats, ...]
    sharpest: float
    lobes: tuple[Lobe, ...]

    def __post_init__(self) -> None:
        for name, axes in (("colour", 3), ("irradiance", 3), ("falloff", 2)):
            shape = getattr(self, name).shape
            if len(shape) != axes or shape[-1] != 3:
                raise ShapeError(f"{name}: expected {axes} axes, the last of 3, got shape {shape}")
        sizes = [level.shape for level in self.surroundings]
        expected = [(size, size, 3) for size in level_sizes(sizes[0][0], len(sizes))] if sizes else [()]
        if sizes != expected:
            raise ShapeError(f"surroundings: expected shapes {expected}, got {sizes}")
        for lobe in self.lobes:
            if lobe.ends.shape[:3] != (*self.irradiance.shape[:2], self.lobes[0].ends.shape[2]):
                raise ShapeError(f"{lobe.axis} ends: shape {lobe.ends.shape} does not fit the other maps")


def level_count(size: int) -> int:
    """Number of levels of surroundings with `size` cells a side: each half as large, down to LEAST_LEVEL."""
    return max(size // LEAST_LEVEL, 1).bit_length()


def level_sizes(size: int, count: int) -> list[int]:
    """Cells along a side of each of `count` levels of the surroundings, the sharpest having `size`."""
    return [max(size >> level, LEAST_LEVEL) for level in range(count)]


def sample_shared(atlas: SharedAtlas, uv: Floats, normal: Floats, viewer: Floats) -> Floats:
    """Radiance seen at fragments, (K, 3) float32, linear.

    `uv` (K, 2); unit `normal` and unit `viewer`, the direction to the viewer, (K, 3), in world space. Raises
    ShapeError for other shapes.
    """
    uv = as_floats("uv", uv, 2)
    for name, vectors in {"normal": normal, "viewer": viewer}.items():
        if vectors.shape != (len(uv), 3):
            raise ShapeError(f"{name}: expected shape {(len(uv), 3)}, as many as uv, got {vectors.shape}")
    facing = np.sum(normal * viewer, axis=1, keepdims=True)
    light = bilinear(atlas.colour, uv) * bilinear(atlas.irradiance, uv)
    light = light * sample_falloff(atlas.falloff, facing[:, 0])
    for lobe in atlas.lobes:
        axis = 2 * facing * normal - viewer if lobe.axis is Axis.MIRROR else -viewer
        light = light + _sample_lobe(atlas, lobe, uv, axis)
    return np.maximum(light, 0).astype(np.float32, copy=False)


def sample_surroundings(
    surroundings: tuple[Floats, ...], sharpest: float, direction: Floats, spread: Floats
) -> Floats:
    """The surroundings in directions (K, 3), of any length, blurred by variances (K,): (K, 3)."""
    place = direction_to_octahedron(direction)
    light = np.zeros((len(direction), 3), dtype=np.float32)
    for level, weight in level_weights(spread, sharpest, len(surroundings)):
        some = np.flatnonzero(weight)
        light[some] += weight[some, None] * sample_octahedron(surroundings[level], place[some])
    return light


def level_weights(spread: Floats, sharpest: float, count: int) -> Iterator[tuple[int, Floats]]:
    """Yield levels and their weights (K,) in lookups blurred by variances (K,): linear between two levels."""
    level = np.clip(np.log2(np.maximum(spread, 1e-12) / sharpest) / 2, 0, count - 1).astype(np.float32)
    for number in range(count):
        yield number, np.maximum(1 - np.abs(level - number), 0)


def sample_falloff(falloff: Floats, cosine: Floats) -> Floats:
    """The falloff curve (B, 3) at cosines (K,), interpolated linearly: (K, 3)."""
    place = np.clip(cosine * len(falloff) - 0.5, 0, len(falloff) - 1)
    low = np.minimum(place.astype(np.int32), len(falloff) - 2)
    part = (place - low)[:, None].astype(falloff.dtype)
    between: Floats = falloff[low] * (1 - part) + falloff[low + 1] * part
    return between


def bilinear_texels(uv: Floats, width: int, height: int) -> Iterator[tuple[Ints, Floats]]:
    """Yield the four texels around uv (K, 2), as flat indices clamped at the edge, and their weights."""
    position = uv * np.array([width, height], dtype=uv.dtype) - uv.dtype.type(0.5)
    corner = np.floor(position)
    fraction = position - corner
    for dy in (0, 1):
        for dx in (0, 1):
            i = np.clip(corner[:, 0].astype(np.int32) + dx, 0, width - 1)
            j = np.clip(corner[:, 1].astype(np.int32) + dy, 0, height - 1)
            yield j * width + i, np.prod(np.where(np.array([dx, dy]) == 1, fraction, 1 - fraction), axis=1)


def _sample_lobe(atlas: SharedAtlas, lobe: Lobe, uv: Floats, axis: Floats) -> Floats:
    height, width, n = lobe.ends.shape[:3]
    buckets = [part.reshape(height * width, n * n, -1) for part in (lobe.ends, lobe.gain, lobe.rest)]
    place = direction_to_octahedron(axis)
    ends, gain, rest = (np.zeros((len(uv), part.shape[2]), dtype=np.float32) for part in buckets)
    for texel, weight in bilinear_texels(uv, width, height):
        for cell, share in octahedron_taps(place, n):
            both = (weight * share)[:, None].astype(np.float32)
            for total, part in zip((ends, gain, rest), buckets, strict=True):
                np.add(total, both * part[texel, cell], out=total)
    met = sample_surroundings(atlas.surroundings, atlas.sharpest, axis + ends[:, :3], ends[:, 3])
    return gain * met + rest


def bilinear(image: Floats, uv: Floats) -> Floats:
    """Bilinear lookup in an image (H, W, C) at uv (K, 2), clamped at the edges: (K, C) float32."""
    height, width = image.shape[:2]
    flat = image.reshape(height * width, -1)
    total = np.zeros((len(uv), flat.shape[1]), dtype=np.float32)
    for texel, weight in bilinear_texels(uv, width, height):
        total += weight[:, None] * flat[texel]
    return total
