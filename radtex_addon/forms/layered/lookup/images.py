# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lookup takes of a material: its colours and normals, by the bake's maps or by its own images."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from ....core.arrays import Floats

Colour = tuple[float, float, float]
ROWS = 3  # vectors of four numbers that tell shaders of an `ImageLook`
_LEAST = 1e-6


@dataclass(frozen=True)
class ImageLook:
    """How the colours of a Principled BSDF whose maps are images follow from these, on the UV layer `uv_map`.

    With the base colour b, the metal m, which is `metallic` times its image, and the roughness image r:
    diffuse light has the colour `diffuse` b (1 - m), and lobes have the tint `dielectric` (1 - `fading` r^4)
    (1 - m) + `metal` b m over the material's mean glossy colour: what is rough and no metal reflects less
    towards its normal. Constant factors of b are in `diffuse` and `metal`, that of r in `fading`. `strength`
    is that of the normal map, 0 without one.
    """

    uv_map: str
    diffuse: Colour
    dielectric: Colour
    metal: Colour
    metallic: float
    strength: float
    fading: float = 0.0

    @property
    def rows(self) -> list[list[float]]:
        """The vectors that shaders take, (ROWS, 4)."""
        return [
            [*self.diffuse, self.metallic],
            [*self.dielectric, self.strength],
            [*self.metal, self.fading],
        ]


@dataclass(frozen=True, eq=False)
class Look:
    """A material at N fragments: diffuse `colour`, the lobes' `tint`, and the unit `normal`, (N, 3) each."""

    colour: Floats
    tint: Floats
    normal: Floats


def look_of_images(
    look: ImageLook,
    base: Floats,
    metal: Floats,
    rough: Floats,
    bump: Floats,
    frame: tuple[Floats, Floats, Floats],
    alpha: Floats,
) -> Look:
    """The material where its images have these values.

    `base` (N, 3) linear; `metal` and `rough` (N,); `bump` (N, 3), the normal map's colour; `frame` (T, B, N),
    (N, 3) each, interpolated but not normalised, as MikkTSpace has it. Colours are multiplied by `alpha`.
    """
    part = (look.metallic * metal)[:, None]
    bare = 1 - part
    colour = np.array(look.diffuse, np.float32) * base * bare
    dull = bare * (1 - look.fading * rough[:, None] ** 4)
    tint = np.array(look.dielectric, np.float32) * dull + np.array(look.metal, np.float32) * base * part
    normal = normal_of_image(bump, frame, look.strength)
    return Look(colour * alpha[:, None], tint * alpha[:, None], normal)


def normal_of_image(bump: Floats, frame: tuple[Floats, Floats, Floats], strength: float) -> Floats:
    """The unit normals (N, 3) of a normal map's colours (N, 3); `frame` as for `look_of_images`."""
    tangent, bitangent, normal = frame
    x, y, z = (2 * bump - 1).T[..., None]
    mapped = _unit(x * tangent + y * bitangent + z * normal)
    outward = _unit(normal)
    return _unit(outward + strength * (mapped - outward))


def _unit(vectors: Floats) -> Floats:
    length = np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), _LEAST)
    return cast(Floats, vectors / length)
