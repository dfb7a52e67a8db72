# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lookups that are timed: each with its shader, as it ships, its textures and what these take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import moderngl
import numpy as np

from radtex_addon.core.arrangements import fitting_levels, to_slices
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.formats.containers.texture import PixelFormat, Texture
from tests.real.opengl import AnyTexture, cube_of_levels, in_blocks, mipmapped, uniform
from tests.reference.levels import level_chain
from tests.reference.slices import mip_chain

from ..drawing import SHADERS, Model, Painter
from ..fidelity.layered.conditions import fetches
from ..fidelity.split_sum import table
from .baselines import DIFFUSE, PHYSICAL, PROBE
from .subject import CUBE_LEVELS, TEXELS, Image, Subject

SRGB8_ALPHA8 = 0x8C43  # GL_SRGB8_ALPHA8: colours as games store them
_SEAMLESS = 0x884F  # GL_TEXTURE_CUBE_MAP_SEAMLESS: as WebGL 2 and Direct3D filter a cube
PHYSICALLY_BASED = "physically based"
_LAYERED = """
vec4 shade() {
    return vec4(radtex_layered(uv, position, normalize(normal), normalize(camera - position)), 1.0);
}
"""
# Around a shader: each fetch is counted, and the count drawn.
_COUNTS = """
int counted = 0;
vec4 counted_once(vec4 texel) {
    counted++;
    return texel;
}
#define texture(image, place) counted_once(texture(image, place))
#define textureLod(image, place, level) counted_once(textureLod(image, place, level))
#define texelFetch(image, texel, level) counted_once(texelFetch(image, texel, level))
#define shade shade_counted
"""
_COUNTED = """
#undef shade
vec4 shade() {
    vec4 shown = shade_counted();
    return vec4(float(counted) + 1e-30 * shown.r, 0.0, 0.0, 1.0);
}
"""
_MATRIX = "uniform sampler2D atlas; uniform ivec2 texels; uniform int n;"
_INCIDENCE = "radtex_incidence(camera - position, normal, tangent.xyz, tangent.w)"
_HARDWARE = "#define RADTEX_HARDWARE_LINEAR\n"
_FILTERED = (
    f"{_MATRIX} vec4 shade() {{ return radtex_sample(atlas, texels, n, uv, {_INCIDENCE}, RADTEX_%s); }}"
)
_LEVELS = f"""{_MATRIX} uniform int levels;
vec4 shade() {{
    return radtex_sample_level(atlas, texels, n, uv, {_INCIDENCE}, radtex_level(uv, texels, levels));
}}"""
_SLICES = f"""uniform sampler2DArray slices; uniform int n;
vec4 shade() {{ return radtex_slices(slices, n, uv, {_INCIDENCE}); }}"""


@dataclass(frozen=True, eq=False)
class Lookup:
    """What draws by a lookup, how many fetches its text makes at a fragment, and its textures' bytes.

    `counting` makes what draws in red how many fetches are made, as branches leave some out. `bytes` are
    those of blocks, which a card holds, `bytes_here` those that this device holds.
    """

    painter: Painter
    counting: Callable[[], Painter]
    fetches: int
    bytes: int
    bytes_here: int

    @classmethod
    def of(
        cls,
        context: moderngl.Context,
        model: Model,
        code: str,
        textures: Mapping[str, Upload],
        values: Mapping[str, Any],
        by_material: Sequence[Mapping[str, Any]],
        fetches: int,
    ) -> Lookup:
        """A lookup by the shader `code`; the rest as of `Painter`."""
        samplers = {name: upload.texture for name, upload in textures.items()}
        painter, counting = (
            partial(Painter, context, model, text, samplers, values, by_material)
            for text in (code, _COUNTS + code + _COUNTED)
        )
        uploads = textures.values()
        size, here = sum(each.bytes for each in uploads), sum(each.bytes_here for each in uploads)
        return cls(painter(), counting, fetches, size, here)


@dataclass(frozen=True, eq=False)
class Upload:
    """A texture on the device."""

    texture: AnyTexture
    bytes: int
    bytes_here: int


class Uploads:
    """Textures on the device, each once: in blocks, or decoded where the device reads blocks too slowly."""

    def __init__(self, context: moderngl.Context, blocks: bool) -> None:
        self.context, self.blocks = context, blocks
        self._kept: dict[Image, Upload] = {}

    def of(self, image: Image, cube: bool = False) -> Upload:
        """The texture; trilinear if it has levels."""
        if image not in self._kept:
            texture, size = self._in_blocks(image, cube) if self.blocks else self._decoded(image, cube)
            self._kept[image] = Upload(texture, image.nbytes, size)
        return self._kept[image]

    def _in_blocks(self, image: Image, cube: bool) -> tuple[AnyTexture, int]:
        blocks = image.blocks
        return in_blocks(self.context, blocks, _minified(blocks.levels), cube), blocks.nbytes

    def _decoded(self, image: Image, cube: bool) -> tuple[AnyTexture, int]:
        if image.format.is_srgb:
            codes = [_srgb_codes(level) for level in image.levels]
            return _srgb_texture(self.context, codes), sum(code.nbytes for code in codes)
        chain = [level.astype(np.float16) for level in image.levels]
        size = sum(level.nbytes for level in chain)
        if cube:
            return cube_of_levels(self.context, chain), size
        return mipmapped(self.context, chain, _minified(chain)), size


def _minified(levels: Sequence[Any]) -> int:
    return moderngl.LINEAR_MIPMAP_LINEAR if len(levels) > 1 else moderngl.LINEAR


def lookups_of(context: moderngl.Context, subject: Subject, blocks: bool) -> dict[str, Lookup]:
    """All lookups of an object, by name; the diffuse one first."""
    context.enable_direct(_SEAMLESS)
    uploads = Uploads(context, blocks)
    image = subject.image("buckets").levels[0]
    cells = subject.facts["textures"]["buckets"]["cells"]
    layout = AtlasLayout(image.shape[1] // cells, image.shape[0] // cells, cells)
    variants = dict(subject.facts["variants"])
    plain = variants["layered"]
    variants["layered, temporal"] = {**plain, "defines": {**plain["defines"], "RADTEX_TEMPORAL": 1}}
    return (
        _baselines(uploads, subject)
        | bucket_lookups(uploads, subject.model("buckets"), image, layout)
        | {name: _layered(uploads, subject, variant) for name, variant in variants.items()}
    )


def _layered(uploads: Uploads, subject: Subject, variant: Mapping[str, Any]) -> Lookup:
    text = (SHADERS / "radtex_layered.glsl").read_text(encoding="utf-8")
    defines = variant["defines"]
    return Lookup.of(
        uploads.context,
        subject.model("layered"),
        _defined(defines) + text + _LAYERED,
        {f"radtex_{layer}_map": uploads.of(subject.image(layer)) for layer in variant["layers"]},
        _uniforms(subject.values(dict(variant))),
        [_uniforms(values) for values in variant["materials"]],
        fetches(text, defines, "radtex_layered"),
    )


def _baselines(uploads: Uploads, subject: Subject) -> dict[str, Lookup]:
    facts, side = subject.facts, 4 * TEXELS * subject.times
    linked = any(material["base"] is None for material in facts["materials"])
    values = facts["variants"]["layered"]["values"]
    scale = values["radtex_colour_range"][2] if linked else 1.0
    factors = [_factors(material, scale) for material in facts["materials"]]
    table_of_split = table().astype(np.float16)
    split_map = mipmapped(uploads.context, [table_of_split], moderngl.LINEAR)
    colour = subject.image("colour") if linked else _even(side, PixelFormat.BC7_SRGB)
    simple = {"base_map": uploads.of(colour)}
    probed = simple | {
        "surface_map": uploads.of(_even(side, PixelFormat.BC7)),
        "probe_map": uploads.of(subject.image("probe"), cube=True),
    }
    lightmapped = probed | {
        "light_map": uploads.of(subject.image("irradiance")),
        "split_map": Upload(split_map, table_of_split.nbytes, table_of_split.nbytes),
    }
    lit = {"light_range": values["radtex_irradiance_range"]}
    low, high = facts["box"]
    box = {"middle": facts["middle"], "low": low, "high": high}
    film = any(material["film"] > 0 for material in facts["materials"])
    of_physical = {"LAMPS": len(facts["lamps"])} | ({"FILM": 1} if film else {})
    rows: dict[str, tuple[str, dict[str, Any], dict[str, Upload], dict[str, Any]]] = {
        "diffuse": (DIFFUSE, {}, simple, {}),
        "lightmap, probe": (PROBE, {}, lightmapped, lit),
        "lightmap, parallax-corrected probe": (PROBE, {"BOX": 1}, lightmapped, lit | box),
        PHYSICALLY_BASED: (PHYSICAL, of_physical, probed, _lamps(facts)),
    }
    model, last = subject.model("layered"), {"LAST_LEVEL": f"{CUBE_LEVELS - 1}.0"}
    return {
        name: Lookup.of(
            uploads.context,
            model,
            _defined(defines | last) + code,
            textures,
            _uniforms(given),
            factors,
            fetches(code, defines, "shade"),
        )
        for name, (code, defines, textures, given) in rows.items()
    }


def _factors(material: Mapping[str, Any], scale: float) -> dict[str, Any]:
    """The uniforms of a material in the baselines."""
    return {
        "base_factor": tuple(material["base"] or (scale, scale, scale)),
        "surface_factor": (material["roughness"], material["metallic"], _frontal(material["ior"])),
        "coat": (material["coat"], material["coat_roughness"], _frontal(1.5)),
        "film": (material["film"], material["film_ior"]),
    }


def _frontal(ior: float) -> float:
    return ((ior - 1) / (ior + 1)) ** 2


def _lamps(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Lamps as points in the world; their irradiance at the middle is known."""
    if not facts["lamps"]:
        return {}
    place = np.array([lamp["place"] for lamp in facts["lamps"]])
    light = np.array([lamp["irradiance"] for lamp in facts["lamps"]]) * (place**2).sum(axis=1, keepdims=True)
    return {"lamp_place": (place + facts["middle"]).tolist(), "lamp_light": light.tolist()}


def bucket_lookups(uploads: Uploads, model: Model, image: Floats, layout: AtlasLayout) -> dict[str, Lookup]:
    """Each filter of a bucket matrix, and slices, of an atlas's image (H n, W n, C)."""
    levels = fitting_levels(layout)
    rgb = image[..., :3].astype(np.float32)
    matrix = Image.of([rgb], PixelFormat.BC6H)
    chain = Image.of(level_chain(rgb, layout, levels), PixelFormat.BC6H)
    slices = Image.of(mip_chain(to_slices(rgb, layout)), PixelFormat.BC6H, is_array=True)
    code = (SHADERS / "radtex.glsl").read_text(encoding="utf-8")
    values = {"texels": (layout.width, layout.height), "n": layout.bucket}
    leveled = values | {"levels": levels}

    def lookup(count: int, text: str, name: str, image: Image, given: Mapping[str, Any]) -> Lookup:
        found = uploads.of(image)
        if image is chain:
            found.texture.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
        return Lookup.of(uploads.context, model, text, {name: found}, given, (), count)

    return {
        "buckets, nearest": lookup(1, code + _FILTERED % "NEAREST", "atlas", matrix, values),
        "buckets, linear": lookup(4, code + _FILTERED % "LINEAR", "atlas", matrix, values),
        "buckets, linear, by the sampler": lookup(
            1, _HARDWARE + code + _FILTERED % "LINEAR", "atlas", matrix, values
        ),
        "buckets, quadrilinear": lookup(16, code + _FILTERED % "QUADRILINEAR", "atlas", matrix, values),
        "buckets, quadrilinear, by the sampler": lookup(
            4, _HARDWARE + code + _FILTERED % "QUADRILINEAR", "atlas", matrix, values
        ),
        "buckets, levels": lookup(16, code + _LEVELS, "atlas", chain, leveled),
        "buckets, levels, by the sampler": lookup(4, _HARDWARE + code + _LEVELS, "atlas", chain, leveled),
        "buckets, slices": lookup(4, code + _SLICES, "slices", slices, {"n": layout.bucket}),
    }


def noise(context: moderngl.Context, model: Model) -> Painter:
    """The diffuse lookup of a texture of noise, for a model that has none."""
    image = np.random.default_rng(1).integers(0, 256, (512, 512, 4)).astype(np.uint8)
    texture = context.texture((512, 512), 4, image.tobytes(), internal_format=SRGB8_ALPHA8)
    texture.build_mipmaps()
    return Painter(context, model, DIFFUSE, {"base_map": texture}, {"base_factor": (1.0, 1.0, 1.0)})


def _srgb_texture(context: moderngl.Context, codes: list[Any]) -> moderngl.Texture:
    """A trilinear texture of sRGB bytes (H, W, 4) with its levels."""
    height, width = codes[0].shape[:2]
    texture = context.texture((width, height), 4, codes[0].tobytes(), internal_format=SRGB8_ALPHA8)
    if len(codes) > 1:
        texture.build_mipmaps(0, len(codes) - 1)  # makes room; what is in it is overwritten
    for level, code in enumerate(codes[1:], start=1):
        texture.write(code.tobytes(), level=level)
    minified = moderngl.LINEAR_MIPMAP_LINEAR if len(codes) > 1 else moderngl.LINEAR
    texture.filter = (minified, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def _srgb_codes(level: Floats) -> Any:
    coded = np.concatenate([to_srgb(level[..., :3]), level[..., 3:]], axis=-1)
    return np.rint(coded * 255).astype(np.uint8)


def _even(side: int, kind: PixelFormat) -> Image:
    """A white map with all its levels: what varies is no matter, it is fetched all the same."""
    (block,) = Image.of([np.ones((4, 4, 4), np.float32)], kind).blocks.levels
    sides = [side >> number for number in range(side.bit_length())]
    levels = tuple(np.tile(block, (1, max(1, each // 4), max(1, each // 4), 1)) for each in sides)
    return Image.of_blocks(Texture(kind, side, side, levels))


def _defined(defines: Mapping[str, Any]) -> str:
    return "".join(f"#define {name} {value}\n" for name, value in defines.items())


def _uniforms(values: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers, and vectors or lists of such as moderngl wants them."""
    return {name: uniform(value) if isinstance(value, list) else value for name, value in values.items()}
