# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout: what all texels see in common is kept once, sharp; a texel keeps what is its own.

    radiance = colour(uv) irradiance(uv) falloff(N.I)  +  gain(uv, R) surroundings(d)  +  rest(uv, R)

R is the mirror direction at the fragment, in world space. `surroundings` is one octahedral picture of what
glossy light comes from, over the direction d in which the point that R meets lies from the object's middle:
near things stand where they are, whatever texel looks at them (`meet_surroundings`). Gain (how much of it is
seen) and rest (what else is) are a bucket a texel, over the octahedron of R: neighbouring texels are blended
at the same R, not at the same angle to their normals, so that a curved surface blurs nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .arrays import Floats, Ints, as_floats
from .errors import ShapeError
from .octahedron import direction_to_octahedron, octahedron_taps, sample_octahedron

MEETINGS = 6  # iterations by which a ray finds what it meets

_AXES: dict[str, tuple[str | int, ...]] = {  # the same letter, the same size
    "rest": ("H", "W", "n", "n", 4),
    "surroundings": ("M", "M", 3),
    "nearness": ("D", "D"),
    "middle": (3,),
    "colour": ("H'", "W'", 3),
    "irradiance": ("H", "W", 3),
    "falloff": ("B", 3),
}


@dataclass(frozen=True, eq=False)
class SharedAtlas:
    """A bake in the shared layout; float32, scene-linear Rec.709, row 0 at v = 0, space the world's.

    `rest` (H, W, n, n, 4): rest in RGB, gain in A, by [j, i, y, x], the last two on the octahedron of R.
    `surroundings` (M, M, 3) and `nearness` (D, D), one over the distance of what is there, on the octahedron
    of directions from `middle` (3,). `colour` (H', W', 3), `irradiance` (H, W, 3), and `falloff` (B, 3) at
    N.I = (k + 0.5) / B. Raises ShapeError if shapes do not fit.
    """

    rest: Floats
    surroundings: Floats
    nearness: Floats
    middle: Floats
    colour: Floats
    irradiance: Floats
    falloff: Floats

    def __post_init__(self) -> None:
        sizes: dict[str | int, int] = {3: 3, 4: 4}
        for name, axes in _AXES.items():
            shape = getattr(self, name).shape
            if len(shape) == len(axes):
                sizes = dict(zip(axes, shape, strict=True)) | sizes
            expected = tuple(sizes.get(axis, axis) for axis in axes)
            if shape != expected:
                raise ShapeError(f"{name}: expected shape ({', '.join(map(str, expected))}), got {shape}")


def sample_shared(atlas: SharedAtlas, uv: Floats, position: Floats, normal: Floats, viewer: Floats) -> Floats:
    """Radiance seen at fragments, (K, 3) float32, linear.

    `uv` (K, 2); `position`, unit `normal` and unit `viewer`, the direction to the viewer, (K, 3), in world
    space. Raises ShapeError for other shapes.
    """
    uv = as_floats("uv", uv, 2)
    for name, vectors in {"position": position, "normal": normal, "viewer": viewer}.items():
        if vectors.shape != (len(uv), 3):
            raise ShapeError(f"{name}: expected shape {(len(uv), 3)}, as many as uv, got {vectors.shape}")
    facing = np.sum(normal * viewer, axis=1, keepdims=True)
    mirrored = 2 * facing * normal - viewer
    height, width, n = atlas.rest.shape[:3]
    texels = atlas.rest.reshape(height * width, n * n, 4)
    place = direction_to_octahedron(mirrored)
    own = np.zeros((len(uv), 4), dtype=np.float32)
    for texel, weight in bilinear_texels(uv, width, height):
        for cell, share in octahedron_taps(place, n):
            own += (weight * share)[:, None] * texels[texel, cell]
    met = direction_to_octahedron(meet_surroundings(atlas.nearness, atlas.middle, position, mirrored))
    shared = own[:, 3:] * sample_octahedron(atlas.surroundings, met)
    return _view_independent(atlas, uv, facing[:, 0]) + shared + own[:, :3]


def meet_surroundings(nearness: Floats, middle: Floats, position: Floats, direction: Floats) -> Floats:
    """Directions from the middle (K, 3), unit, of what rays from positions along unit directions (K, 3) meet.

    `nearness` (D, D) as in `SharedAtlas`. The ray is cut with the sphere that is as large as what lies in the
    direction found last, again and again: Szirmay-Kalos et al., "Approximate Ray-Tracing on the GPU with
    Distance Impostors" (2005).
    """
    offset = (position - middle).astype(np.float32)
    direction = direction.astype(np.float32)
    along = np.sum(offset * direction, axis=1)
    squared = np.sum(offset * offset, axis=1)
    found = direction
    for _ in range(MEETINGS):
        near = sample_octahedron(nearness[..., None], direction_to_octahedron(found))[:, 0]
        distance = np.sqrt(np.maximum(along * along - squared + 1 / (near * near), 0)) - along
        reached = offset + distance[:, None] * direction
        found = reached / np.sqrt(np.sum(reached * reached, axis=1, keepdims=True))
    return found


def sample_falloff(falloff: Floats, cosine: Floats) -> Floats:
    """The curve (B, 3) at cosines (K,), linear between its points: (K, 3)."""
    place = np.clip(cosine * len(falloff) - 0.5, 0, len(falloff) - 1)
    low = np.minimum(place.astype(np.int32), len(falloff) - 2)
    part = (place - low)[:, None].astype(falloff.dtype)
    between: Floats = falloff[low] * (1 - part) + falloff[low + 1] * part
    return between


def bilinear_texels(uv: Floats, width: int, height: int) -> Iterator[tuple[Ints, Floats]]:
    """The four texels around texture coordinates (K, 2), by flat index, clamped at the edge, and weights."""
    position = uv * np.array([width, height], dtype=uv.dtype) - uv.dtype.type(0.5)
    corner = np.floor(position)
    fraction = position - corner
    for dy in (0, 1):
        for dx in (0, 1):
            i = np.clip(corner[:, 0].astype(np.int32) + dx, 0, width - 1)
            j = np.clip(corner[:, 1].astype(np.int32) + dy, 0, height - 1)
            yield j * width + i, np.prod(np.where(np.array([dx, dy]) == 1, fraction, 1 - fraction), axis=1)


def _view_independent(atlas: SharedAtlas, uv: Floats, cosine: Floats) -> Floats:
    light = _bilinear(atlas.colour, uv) * _bilinear(atlas.irradiance, uv)
    return light * sample_falloff(atlas.falloff, cosine)


def _bilinear(image: Floats, uv: Floats) -> Floats:
    height, width = image.shape[:2]
    flat = image.reshape(height * width, -1)
    total = np.zeros((len(uv), flat.shape[1]), dtype=np.float32)
    for texel, weight in bilinear_texels(uv, width, height):
        total += weight[:, None] * flat[texel]
    return total
