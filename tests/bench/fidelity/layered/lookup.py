# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""lookup.glsl for one bake: what is defined, its textures and its uniforms."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.lookup.environment import Pictures, Plane
from radtex_addon.forms.layered.lookup.lobes import STEPS, Material
from tests.real.opengl import mipmapped

from .compressed import Format, Texture, light_texture, picture_texture, to_srgb
from .conditions import chosen

SRGB8_ALPHA8 = 0x8C43  # GL_SRGB8_ALPHA8
CODE = Path(__file__).with_suffix(".glsl")
WHOLE_SIZE = 256  # texels along a side of the picture of everything, as it is seen from the middle
_FETCH = re.compile(r"\btexture(?:Lod)?\s*\(")


@dataclass(frozen=True)
class Cost:
    """What a lookup may cost.

    `steps`: fetches of distances. `own_taps` and `rest_taps`: 3 or 4 cells that are
    blended around a direction. `second`: what the
    second lobe looks at: "all", the "whole" picture, or "none". `product`: colour times irradiance are one
    texture. `rest`: whether what is left is added.
    """

    steps: int = 1
    own_taps: int = 3
    rest_taps: int = 3
    second: str = "whole"
    product: bool = False
    rest: bool = True


FULL = Cost(steps=2, own_taps=4, rest_taps=4, second="all")


@dataclass(frozen=True, eq=False)
class Lookup:
    """What `radtex_layered` needs: definitions before it, textures, uniforms but those of materials."""

    defines: Mapping[str, int]
    textures: Mapping[str, Texture]
    values: Mapping[str, Any]

    @property
    def code(self) -> str:
        head = "".join(f"#define {name} {value}\n" for name, value in self.defines.items())
        return head + CODE.read_text(encoding="utf-8")

    @property
    def fetches(self) -> int:
        """Texture lookups in the source, which has no loops and calls no function that looks up."""
        return len(_FETCH.findall(chosen(CODE.read_text(encoding="utf-8"), self.defines)))

    @property
    def bytes(self) -> int:
        return sum(texture.bytes for texture in self.textures.values())

    def uploaded(self, context: moderngl.Context) -> dict[str, moderngl.Texture]:
        return {name: upload(context, texture) for name, texture in self.textures.items()}


def lookup_of(atlas: LayeredAtlas, textures: Mapping[str, Texture], cost: Cost) -> Lookup:
    """The lookup of a decoded atlas and its textures by `compressed`.

    Raises ValueError for layers that are not a plane, or things, or things before a plane, for more than four
    lamps, and for light that comes through.
    """
    around = atlas.around
    shapes = ["plane" if isinstance(layer.shape, Plane) else "things" for layer in around.layers]
    known = shapes in ([], ["plane"], ["things"], ["plane", "things"])
    if not known or len(around.lamps) > 4 or atlas.through is not None:
        raise ValueError(f"layers {shapes}, {len(around.lamps)} lamps: no lookup is written for these")
    defines = {"RADTEX_STEPS": cost.steps, "RADTEX_LAMPS": 0}
    defines |= {"RADTEX_OWN_TAPS": cost.own_taps, "RADTEX_REST_TAPS": cost.rest_taps}
    used: dict[str, Texture] = {}
    values: dict[str, Any] = {}
    if "irradiance" in textures and "colour" in textures:
        _add_diffuse(atlas, textures, cost.product, defines, used, values)
    mirrors = any(lobes.weight.any() for lobes in atlas.materials)
    for name in ("normal", "alpha", *(("tint", "width") if mirrors else ())):
        _add_map(name, textures, defines, used, values)
    if mirrors:
        defines["RADTEX_MIRRORS"] = 1
        values["middle"] = tuple(around.middle.tolist())
        used["world"], used["own"] = textures["world"], textures["own"]
        values["world_levels"] = _levels(around.world)
        cells = defines["RADTEX_OWN_CELLS"] = atlas.own.shape[2]
        values["own_tile"], values["own_scale"] = _tile(used["own"], cells), used["own"].scale
        _add_layers(atlas, textures, defines, used, values)
        if around.lamps:
            defines["RADTEX_LAMPS"] = len(around.lamps)
            values["lamp_place"] = _array([(*lamp.place.tolist(), lamp.variance) for lamp in around.lamps])
            values["lamp_light"] = _array([tuple(lamp.irradiance.tolist()) for lamp in around.lamps])
        if cost.second == "whole":
            defines["RADTEX_WHOLE"] = 1
            whole = flattened(atlas)
            used["whole"], values["whole_levels"] = picture_texture(whole), _levels(whole)
        elif cost.second == "all":
            defines["RADTEX_ALL"] = 1
    if cost.rest:
        defines["RADTEX_REST"], used["rest"] = 1, textures["rest"]
        cells = defines["RADTEX_REST_CELLS"] = atlas.rest.shape[2]
        values["rest_tile"] = _tile(used["rest"], cells)
        values["rest_range"] = (used["rest"].scale, used["rest"].offset)
    return Lookup(defines, used, values)


def _add_diffuse(
    atlas: LayeredAtlas,
    textures: Mapping[str, Texture],
    product: bool,
    defines: dict[str, int],
    used: dict[str, Texture],
    values: dict[str, Any],
) -> None:
    if product:
        defines["RADTEX_LIT"] = 1
        used["lit"] = light_texture(_product(atlas))
        values["lit_part"] = _part(used["lit"])
        return
    defines["RADTEX_COLOUR"] = 1
    used["colour"], used["irradiance"] = textures["colour"], textures["irradiance"]
    values["colour_scale"] = textures["colour"].scale
    values["colour_part"], values["irradiance_part"] = (
        _part(used[name]) for name in ("colour", "irradiance")
    )


def _add_map(
    name: str,
    textures: Mapping[str, Texture],
    defines: dict[str, int],
    used: dict[str, Texture],
    values: dict[str, Any],
) -> None:
    """Add a map of the surface, if it is there."""
    if name in textures:
        defines[f"RADTEX_{name.upper()}"] = 1
        found = used["shading_normal" if name == "normal" else name] = textures[name]
        values[f"{name}_part"] = _part(found)
        if name == "tint":
            values["tint_scale"] = found.scale
        if name == "width":
            values["width_range"] = (found.scale, found.offset)


def _part(texture: Texture) -> tuple[float, float]:
    """The share of a texture's width and height that is not padding."""
    height, width = texture.levels[0].shape[:2]
    return texture.size[0] / width, texture.size[1] / height


def _add_layers(
    atlas: LayeredAtlas,
    textures: Mapping[str, Texture],
    defines: dict[str, int],
    used: dict[str, Texture],
    values: dict[str, Any],
) -> None:
    for number, layer in enumerate(atlas.around.layers):
        name = "plane" if isinstance(layer.shape, Plane) else "things"
        defines[f"RADTEX_{name.upper()}"] = 1
        used[name] = textures[f"near{number}"]
        values[f"{name}_levels"], values[f"{name}_scale"] = _levels(layer.pictures), used[name].scale
        if isinstance(layer.shape, Plane):
            values["plane_place"] = (*layer.shape.normal.tolist(), layer.shape.height)
            values["plane_eye"] = tuple(layer.shape.eye.tolist())
        else:
            found = textures[f"distances{number}"]
            mean = float(layer.shape.nearness.mean())
            values["nearness"] = (found.scale, found.offset, mean)
            if defines["RADTEX_STEPS"]:
                used["distances"] = found
                values["distances_size"] = float(len(found.levels[0]))


def material_values(atlas: LayeredAtlas, number: int, lookup: Lookup) -> dict[str, Any]:
    """The uniforms of one material: its curves and its falloff at the same steps of N.V."""
    material = atlas.materials[number]
    facts = np.concatenate([_resampled(atlas.falloff[number]), np.sin(material.bend[:, None])], axis=1)
    values: dict[str, Any] = {"material": [tuple(row) for row in facts.tolist()]}
    if "RADTEX_MIRRORS" in lookup.defines:
        spread = np.log2(material.variance)[..., None]
        both = np.concatenate([material.weight, spread], axis=2).reshape(2 * STEPS, 4)
        if "RADTEX_ALL" not in lookup.defines and "RADTEX_WHOLE" not in lookup.defines:
            both = _merged(material)
        values["lobes"] = [tuple(row) for row in both.tolist()]
    return values


def flattened(atlas: LayeredAtlas) -> Pictures:
    """Everything but lamps as it is seen from the middle, in WHOLE_SIZE texels, and ever more blurred."""
    around = replace(atlas.around, lamps=())
    sharpest = around.world.sharpest * (len(around.world.levels[0]) / WHOLE_SIZE) ** 2
    levels = []
    for number in range((WHOLE_SIZE // 8).bit_length()):
        size = WHOLE_SIZE >> number
        direction = cell_directions(size).astype(np.float32)
        variance = np.full(len(direction), sharpest * 4**number, dtype=np.float32)
        seen = around.look(np.zeros_like(direction), direction, variance)
        levels.append(np.ascontiguousarray(np.maximum(seen.T, 0).reshape(size, size, 3)))
    return Pictures(tuple(levels), sharpest)


def upload(context: moderngl.Context, texture: Texture) -> moderngl.Texture:
    """The texture, decoded: llvmpipe reads blocks in seconds. As bytes of sRGB, or as half floats."""
    minified = moderngl.LINEAR_MIPMAP_LINEAR if len(texture.levels) > 1 else moderngl.LINEAR
    if texture.format not in (Format.BC3_SRGB, Format.BC7_SRGB):
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


def _array(values: list[tuple[float, ...]]) -> Any:
    """As moderngl wants an array of uniforms, one of a single element too."""
    return values if len(values) > 1 else values[0]


def _levels(pictures: Pictures) -> tuple[float, float, float]:
    """Texels along a side, the last level, and the logarithm to base 2 of the sharpest level's variance."""
    return float(len(pictures.levels[0])), len(pictures.levels) - 1.0, float(np.log2(pictures.sharpest))


def _tile(texture: Texture, cells: int) -> tuple[float, float, float, float]:
    height, width = (side // cells for side in texture.levels[0].shape[:2])
    return texture.size[0] / width, texture.size[1] / height, 0.5 / width, 0.5 / height


def _resampled(falloff: Floats) -> Floats:
    """The falloff (B, 3) at the materials' steps of N.V, (STEPS, 3)."""
    place = (np.arange(STEPS) + 0.5) / STEPS * len(falloff) - 0.5
    columns = [np.interp(place, np.arange(len(falloff)), column) for column in falloff.T]
    return np.stack(columns, axis=1)


def _merged(material: Material) -> Floats:
    """One lobe for two, twice (2 STEPS, 4): their weights' sum, and their variances' geometric mean."""
    bright = material.weight.sum(axis=2)
    share = bright / np.maximum(bright.sum(axis=0), 1e-9)
    spread = (share * np.log2(material.variance)).sum(axis=0)
    one = np.concatenate([material.weight.sum(axis=0), spread[:, None]], axis=1)
    return np.concatenate([one, one])


def _product(atlas: LayeredAtlas) -> Floats:
    """Colour times irradiance, at the colour's resolution."""
    height, width = atlas.colour.shape[:2]
    light: Floats = atlas.colour * _enlarged(_enlarged(atlas.irradiance, height, 0), width, 1)
    return light


def _enlarged(image: Floats, size: int, axis: int) -> Floats:
    """An image resized along an axis, linear between texels' centres."""
    place = np.clip((np.arange(size) + 0.5) / size * image.shape[axis] - 0.5, 0, image.shape[axis] - 1)
    low = np.minimum(place.astype(np.intp), image.shape[axis] - 2)
    shape = [1, 1, 1]
    shape[axis] = size
    above = (place - low).astype(np.float32).reshape(shape)
    found: Floats = image.take(low, axis=axis) * (1 - above) + image.take(low + 1, axis=axis) * above
    return found
