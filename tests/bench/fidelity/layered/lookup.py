# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_layered.glsl for one bake: what is defined, its textures and its uniforms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.forms.layered.files.arrangement import DISTANCES, PLANE, THINGS
from radtex_addon.forms.layered.files.sidecar import LayeredSidecar
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.environment import Plane
from radtex_addon.forms.layered.shader_values import (
    LookupCost,
    Stored,
    Values,
    bake_values,
    definitions,
    layers_read,
    material_values,
)
from tests.real.opengl import mipmapped

from .compressed import Texture
from .conditions import fetches

SRGB8_ALPHA8 = 0x8C43  # GL_SRGB8_ALPHA8
CODE = Path(__file__).parents[4] / "shaders" / "radtex_layered.glsl"
_BLACK = Texture(PixelFormat.BC6H, (np.zeros((4, 4, 3), np.float32),), (4, 4))


@dataclass(frozen=True, eq=False)
class Lookup:
    """What `radtex_layered` needs: the facts of a bake, and its textures by layer."""

    sidecar: LayeredSidecar
    cost: LookupCost
    textures: Mapping[str, Texture]
    stored: Mapping[str, Stored]

    @property
    def defines(self) -> dict[str, int]:
        return definitions(self.sidecar, self.cost)

    @property
    def code(self) -> str:
        head = "".join(f"#define {name} {value}\n" for name, value in self.defines.items())
        return head + CODE.read_text(encoding="utf-8")

    @property
    def fetches(self) -> int:
        """Texture lookups that a call makes."""
        return fetches(CODE.read_text(encoding="utf-8"), self.defines, "radtex_layered")

    @property
    def bytes(self) -> int:
        return sum(texture.bytes for texture in self.textures.values())

    def values(self, material: int) -> Values:
        """The uniforms with which one of the materials is drawn."""
        of_material = material_values(self.sidecar, material, self.cost)
        return bake_values(self.sidecar, self.stored, self.cost) | of_material

    def uploaded(self, context: moderngl.Context) -> dict[str, moderngl.Texture]:
        """The textures by their uniforms."""
        return {f"radtex_{layer}_map": upload(context, texture) for layer, texture in self.textures.items()}


def lookup_of(atlas: LayeredAtlas, textures: Mapping[str, Texture], cost: LookupCost) -> Lookup:
    """The lookup of a decoded atlas and its textures by `compressed`.

    Raises ValueError for layers that are not a plane, or things, or things before a plane, and for light that
    comes through, InputError for too many lamps.
    """
    if atlas.through is not None:
        raise ValueError("light that comes through: its textures are not compressed here")
    height, width = atlas.irradiance.shape[:2]
    made_by = "RadTex 0"
    bake = Sidecar("Atlas", "radiance", width, height, 2, "UVMap", 1, 0, "portal", made_by, "5.2")
    sidecar = LayeredSidecar.of(atlas, bake)
    named = dict(textures)
    for number, layer in enumerate(atlas.around.layers):
        flat = isinstance(layer.shape, Plane)
        for name, new in ((f"near{number}", PLANE if flat else THINGS), (f"distances{number}", DISTANCES)):
            if name in named:
                named[new] = named.pop(name)
    definitions(sidecar, cost)
    # What is black everywhere has no texture.
    read = {layer: named.get(layer, _BLACK) for layer in layers_read(sidecar, cost)}
    return Lookup(sidecar, cost, read, {layer: _stored(layer, named[layer]) for layer in named})


def _stored(layer: str, texture: Texture) -> Stored:
    height, width = texture.levels[0].shape[:2]
    columns, rows = texture.size
    mean = float(texture.values(0).mean()) if layer == DISTANCES else 0.0
    tiled = layer in ("own", "rest")  # padded tile by tile
    part = (1.0, 1.0) if tiled else (columns / width, rows / height)
    return Stored(texture.scale, texture.offset, part, mean)


def upload(context: moderngl.Context, texture: Texture) -> moderngl.Texture:
    """The texture, decoded: llvmpipe reads blocks in seconds. As bytes of sRGB, or as half floats."""
    minified = moderngl.LINEAR_MIPMAP_LINEAR if len(texture.levels) > 1 else moderngl.LINEAR
    if not texture.format.is_srgb:
        chain = [level.astype(np.float16) for level in texture.levels]
        found = mipmapped(context, chain, minified)
        assert isinstance(found, moderngl.Texture)
        return found
    codes = [np.rint(_coded(level) * 255).astype(np.uint8) for level in texture.levels]
    height, width = codes[0].shape[:2]
    image = context.texture((width, height), 4, codes[0].tobytes(), internal_format=SRGB8_ALPHA8)
    if len(codes) > 1:
        image.build_mipmaps(0, len(codes) - 1)  # makes room; what is in it is overwritten
    for level, code in enumerate(codes[1:], start=1):
        image.write(code.tobytes(), level=level)
    image.filter = (minified, moderngl.LINEAR)
    image.repeat_x = image.repeat_y = False
    return image


def _coded(level: Floats) -> Floats:
    return np.concatenate([to_srgb(level[..., :3]), level[..., 3:]], axis=-1)
