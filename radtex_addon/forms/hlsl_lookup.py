# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a bake is looked up in HLSL, for engines whose shaders are written with the bake's numbers in them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..textures.entry import Container, TextureEntry
from ..textures.export_spec import Target

SAMPLER = "radtex_trilinear_clamp_sampler"  # Unity makes a sampler of these words; in Unreal it is a member
ARGUMENTS = (
    "float2 uv, float2 image_uv, float3 position, float3 N, float3 T, float side, float3 V, float3 L, "
    "float3 irradiance"
)
IMAGE_TEXTURES = ("radtex_base_map", "radtex_metal_map", "radtex_bump_map")  # of shaders/radtex_layered.hlsl


@dataclass(frozen=True)
class Number:
    """A constant: "float4", "int2" and the like, its name, and its `values` (N,), or (K, N) for an array."""

    kind: str
    name: str
    values: npt.NDArray[Any]

    @property
    def count(self) -> int:
        """The array's length, 0 if it is no array."""
        return len(self.values) if self.values.ndim > 1 else 0

    @property
    def rows(self) -> list[str]:
        """The vectors, one or one for each element, in HLSL."""
        return [f"{self.kind}({numbers(row)})" for row in np.atleast_2d(self.values)]


@dataclass(frozen=True)
class HlslLookup:
    """Which `defines`, `textures` by their names, `constants` and `includes` of shaders/ a lookup needs.

    `body` is that of a function that returns light, premultiplied, and alpha: float4, from ARGUMENTS. These
    are, all but uv in the world of the bake: the place, normal, tangent, the bitangent's sign, and where the
    viewer is, of any length; and, for a `relit` bake, where the sun is, and its irradiance. A mesh with
    several materials has, for each, the constants in `materials`, too. Materials with the numbers `of_images`
    are shown by their own images, on coordinates of their own: for these RADTEX_IMAGES is defined, there are
    the textures IMAGE_TEXTURES, and the bake's `replaced` ones are not read.
    """

    defines: Mapping[str, int | str]
    textures: Mapping[str, TextureEntry]
    constants: tuple[Number, ...]
    includes: tuple[str, ...]
    body: str
    materials: tuple[tuple[Number, ...], ...] = ((),)
    relit: bool = False
    of_images: frozenset[int] = frozenset()
    replaced: tuple[str, ...] = ()

    def textures_of(self, material: int) -> dict[str, TextureEntry]:
        """The bake's textures that are read for a material."""
        left_out = self.replaced if material in self.of_images else ()
        return {name: entry for name, entry in self.textures.items() if name not in left_out}


def numbers(values: Iterable[Any]) -> str:
    """Numbers with the digits that tell single floats apart, separated by commas."""
    return ", ".join(_number(value) for value in np.asarray(values).ravel())


def _number(value: Any) -> str:
    return str(int(value)) if isinstance(value, np.integer) else str(np.float32(value))


def is_top_down(entry: TextureEntry, target: Target) -> bool:
    """Whether the target has a texture's top row as its first: an EXR's, if no importer turns it over."""
    return entry.container is Container.EXR and not target.traits.turns_exr


def keeps_levels(entry: TextureEntry, target: Target) -> bool:
    """Whether a texture's mip levels reach the target: in some, where sides are powers of two."""
    powers = all(side & (side - 1) == 0 for side in entry.size)
    return entry.levels > 1 and (powers or target.traits.odd_levels)


def page_words(entry: TextureEntry) -> tuple[str, dict[str, int | str]]:
    """What stands for the atlas `radtex_atlas` in a call, and what is to be defined for it."""
    if entry.layers == 1:
        return "radtex_atlas", {"RADTEX_HARDWARE_LINEAR": SAMPLER}
    return f"radtex_atlas, int4({numbers((*entry.pages, *entry.page_texels))})", {"RADTEX_PAGES": 1}
