# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A game engine's reflection probe: a picture of the surroundings, blurred by roughness, in a box.

What a ray meets is looked up where it leaves the box (Lagarde and Zanuttini, "Local Image-Based Lighting with
Parallax-Corrected Cubemaps", 2012). An artist would draw the box; here it is the one that agrees best with
the distances of what was captured. Where everything is far, a side lies at infinity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import fallback_tangent, orthonormal_frame
from radtex_addon.core.octahedron import cell_directions, direction_to_octahedron, sample_octahedron
from radtex_addon.forms.layered.lookup.blurred_levels import mean_map

from .lightmaps import texture_bytes
from .single_paths import SurroundingsSamples, nearness_map
from .split_sum import ggx_halves

SIZE = 256  # cells along the sides of the sharpest picture: about a cube map's of 104 pixels
LEVELS = (  # roughness and size of each level; engines have fewer
    (0.0, SIZE), (0.07, SIZE), (0.14, 128), (0.2, 128), (0.28, 64), (0.36, 64),
    (0.45, 64), (0.55, 32), (0.7, 32), (0.85, 16), (1.0, 16),
)  # fmt: skip
_RAYS = 192  # of a blurred texel
_ROUNDS = 4
_CHOICES = 129  # of a side's nearness, tried in every round
_FAR = 1e6
FAR = 100.0  # distance of the world, in object sizes


@dataclass(frozen=True, eq=False)
class Box:
    """A box along the world's axes around `middle` (3,); `nearness` (2, 3) of its sides towards -x … +z.

    Nearness is one over the distance from the middle: 0 for a side at infinity.
    """

    middle: Floats
    nearness: Floats

    @classmethod
    def around(cls, middle: Floats, nearness: Floats, points: Floats) -> Box:
        """The box that holds all `points` (K, 3) and agrees best with a map (M, M) of what is near.

        The map is as of `nearness_map`. The box has the least mean error of nearness, for it is this that a
        ray's parallax goes by; by coordinate descent.
        """
        direction, near = cell_directions(len(nearness)), nearness.ravel()
        reach = np.stack([middle - points.min(axis=0), points.max(axis=0) - middle])
        limit = 1 / np.maximum(reach * 1.01, 1e-6)
        towards = np.concatenate([-direction, direction], axis=1)  # the cosine to each side's normal
        sides = np.zeros(6)
        for _ in range(_ROUNDS):
            for side, most in enumerate(limit.ravel().tolist()):
                others = np.delete(towards * sides, side, axis=1).max(axis=1, initial=0)
                choices = np.linspace(0, most, _CHOICES)
                errors = [
                    np.abs(np.maximum(others, choice * towards[:, side]) - near).mean() for choice in choices
                ]
                sides[side] = choices[int(np.argmin(errors))]
        return cls(middle, sides.reshape(2, 3))

    def leave(self, position: Floats, direction: Floats) -> Floats:
        """Directions from the middle (K, 3), of any length, of where rays from inside leave the box."""
        offset = position - self.middle
        near = np.where(direction > 0, self.nearness[1], self.nearness[0])
        inside = 1 - np.sign(direction) * offset * near  # of the way from the middle to the side
        speed = np.abs(direction) * near
        along = np.divide(inside, speed, out=np.full_like(speed, _FAR), where=speed > 1 / _FAR)
        met: Floats = offset + np.maximum(along.min(axis=1, keepdims=True), 0) * direction
        return met


@dataclass(frozen=True, eq=False)
class Probe:
    """The box, and pictures (M, M, 3) on the octahedron of directions for LEVELS; linear, float32."""

    box: Box
    levels: tuple[Floats, ...]

    @classmethod
    def of(cls, samples: SurroundingsSamples, points: Floats) -> Probe:
        """The probe in the middle of an object that consists of `points` (K, 3)."""
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        box = Box.around(samples.middle, nearness_map(samples, FAR * size), points)
        return cls(box, prefiltered(mean_map(samples.direction, samples.radiance, SIZE)))

    def look(self, position: Floats, direction: Floats, roughness: Floats) -> Floats:
        """Light from unit directions at positions (K, 3), blurred by roughness (K,): (K, 3) float32."""
        place = direction_to_octahedron(self.box.leave(position, direction).astype(np.float32))
        known = np.array([rough for rough, _ in LEVELS])
        level = np.interp(roughness, known, np.arange(len(known)))
        light = np.zeros((len(position), 3), dtype=np.float32)
        for number, image in enumerate(self.levels):
            share = np.maximum(1 - np.abs(level - number), 0).astype(np.float32)
            some = np.flatnonzero(share)
            if len(some):
                light[some] += share[some, None] * sample_octahedron(image, place[some])
        return light

    @property
    def bytes(self) -> int:
        """All levels in BC6H."""
        return sum(texture_bytes(image) for image in self.levels)


def prefiltered(image: Floats, levels: Sequence[tuple[float, int]] = LEVELS) -> tuple[Floats, ...]:
    """A picture (M, M, 3) on the octahedron, blurred for each of some levels' roughness and size.

    By GGX where surface, viewer and mirror direction are one, weighted by the cosine: Karis, "Real Shading in
    Unreal Engine 4" (2013). A ray looks into a copy as coarse as its share of the sphere: Krivanek and
    Colbert, "Real-time Shading with Filtered Importance Sampling" (2008).
    """
    chain = [image]
    while len(chain[-1]) > 8:
        half = len(chain[-1]) // 2
        chain.append(chain[-1].reshape(half, 2, half, 2, 3).mean(axis=(1, 3)))
    return tuple(
        image if not rough else _blurred(chain, rough**2, size).astype(np.float32) for rough, size in levels
    )


def _blurred(chain: list[Floats], alpha: float, size: int) -> Floats:
    normal = cell_directions(size)
    tangent, bitangent, _ = orthonormal_frame(normal, fallback_tangent(normal), np.ones(len(normal)))
    total, sum_of_weights = np.zeros((len(normal), 3)), 0.0
    for half in ggx_halves(alpha, _RAYS).tolist():
        x, y, z = 2 * half[2] * half[0], 2 * half[2] * half[1], 2 * half[2] ** 2 - 1
        if z <= 0:
            continue
        density = alpha**2 / (np.pi * (half[2] ** 2 * (alpha**2 - 1) + 1) ** 2) / 4
        own, cell = 1 / (_RAYS * density), 4 * np.pi / len(chain[0]) ** 2
        level = int(np.clip(round(0.5 * np.log2(own / cell) + 1), 0, len(chain) - 1))
        direction = x * tangent + y * bitangent + z * normal
        total += z * sample_octahedron(chain[level], direction_to_octahedron(direction.astype(np.float32)))
        sum_of_weights += z
    blurred: Floats = (total / sum_of_weights).reshape(size, size, 3)
    return blurred
