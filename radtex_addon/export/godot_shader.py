# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's shader for Godot, and the parameters of its material."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..core.arrays import Floats
from ..formats.packing import LOBE_CHANNELS, TEXTURES, WEIGHTS
from ..formats.texture import PixelFormat
from .manifest import Arranged, Manifest, TextureEntry

_AXES = {"mirror": "reflect(-V, N)", "through": "-V"}
_FILTERS = '"Nearest", "Linear", "Quadrilinear"'


@dataclass(frozen=True)
class GodotShader:
    """A template, what to write for its words, the material's `parameters`, and its textures by uniform.

    `parameters` are written as Godot's text resources are.
    """

    template: str
    words: Mapping[str, str]
    includes: tuple[str, ...]
    parameters: Mapping[str, str]
    textures: Mapping[str, TextureEntry]


def bake_shader(manifest: Manifest, baked: Floats) -> GodotShader:
    """The shader of a bake; `baked` (3, 3) turns directions of the mesh into Blender's world of the bake."""
    if manifest.bake["layout"] == "shared":
        return _shared(manifest, baked)
    entry = manifest.textures[manifest.bake["kind"]]
    return _slices(manifest, entry) if entry.arrangement is Arranged.SLICES else _matrix(manifest, entry)


def _matrix(manifest: Manifest, entry: TextureEntry) -> GodotShader:
    paged, levels = entry.layers > 1, entry.levels
    atlas = "atlas, pages" if paged else "atlas"
    lookup = f"radtex_sample({atlas}, texels, cells, uv, I, filtering)"
    filters, default, uniforms = _FILTERS, 2, ["uniform ivec2 texels;", "uniform int cells;"]
    parameters = {"texels": _integers(entry.texels), "cells": str(manifest.bake["bucket"])}
    if paged:
        uniforms.append("uniform ivec4 pages;  // columns, rows, texels a page across, up")
        parameters["pages"] = _integers((*entry.pages, *entry.page_texels))
    if levels > 1:
        by_level = f"radtex_sample_level({atlas}, texels, cells, uv, I, radtex_level(uv, texels, levels))"
        lookup = f"filtering == 3 ? {by_level}\n        : {lookup}"
        filters, default = f'{_FILTERS}, "Quadrilinear, mipmaps"', 3
        uniforms.append("uniform int levels;")
        parameters["levels"] = str(levels)
    uniforms = [
        f"uniform int filtering : hint_enum({filters}) = {default};",
        f"uniform sampler2D{'Array' if paged else ''} atlas : filter_nearest_mipmap, repeat_disable;",
        *uniforms,
    ]
    hull = manifest.bake["kind"] == "proxy"
    return _buckets(entry, "atlas", f"vec4 light = {lookup};", uniforms, parameters, paged, hull)


def _slices(manifest: Manifest, entry: TextureEntry) -> GodotShader:
    hints = "filter_linear_mipmap_anisotropic, repeat_disable"
    uniforms = [f"uniform sampler2DArray slices : {hints};", "uniform int cells;"]
    lookup = "vec4 light = radtex_slices(slices, cells, uv, I);"
    parameters = {"cells": str(manifest.bake["bucket"])}
    hull = manifest.bake["kind"] == "proxy"
    return _buckets(entry, "slices", lookup, uniforms, parameters, False, hull)


def _buckets(
    entry: TextureEntry,
    texture: str,
    lookup: str,
    uniforms: list[str],
    parameters: Mapping[str, str],
    paged: bool,
    hull: bool,
) -> GodotShader:
    blended = entry.format is PixelFormat.RGBA16F  # what has no alpha is opaque
    words = {
        "CULLED": "cull_back" if hull else "cull_disabled",  # behind a hull there is nothing of it to see
        "BLENDED": ", blend_premul_alpha, depth_draw_always" if blended else "",
        "DEFINES": "\n#define RADTEX_PAGES" if paged else "",
        "UNIFORMS": "\n".join(uniforms),
        "LOOKUP": f"    {lookup}",
        "ALPHA": "    ALPHA = light.a;\n" if blended else "",
    }
    return GodotShader("buckets.gdshader", words, ("radtex",), parameters, {texture: entry})


def _shared(manifest: Manifest, baked: Floats) -> GodotShader:
    shared = manifest.bake["shared"]
    condensed = shared.get("condensed")
    includes = ("radtex_shared", "radtex_condensed") if condensed else ("radtex_shared",)
    defines = [f"#define RADTEX_FALLOFF {len(shared['falloff'])}"]
    terms = ["radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, dot(N, V))"]
    numbers = ["ivec2 fine", "ivec2 texels", "ivec2 around", "int cells", "vec3 falloff[RADTEX_FALLOFF]"]
    parameters = {
        "baked": f"Basis({_list(baked)})",
        "fine": _integers(shared["colour"]),
        "texels": _integers(manifest.bake["texels"]),
        "around": _integers((shared["surroundings"], shared["levels"])),
        "cells": str(manifest.bake["bucket"]),
        "falloff": f"PackedVector3Array({_list(shared['falloff'])})",
    }
    if condensed:
        defines.append(f"#define RADTEX_RANK {condensed['rank']}")
        numbers.append("int columns")
        parameters["columns"] = str(condensed["columns"])
    for lobe in shared["lobes"]:
        axis = _AXES[lobe]
        if condensed:
            numbers.append(f"vec4 {lobe}_ranges[12]")
            parameters[f"{lobe}_ranges"] = f"PackedVector4Array({_list(_ranges(condensed['lobes'][lobe]))})"
            images = [f"{lobe}_{part}" for part in (WEIGHTS, *sum(TEXTURES.values(), ()))]
            rest = f"{lobe}_ranges, columns, cells, texels, surroundings, around, uv, {axis}"
            terms.append(f"radtex_condensed_lobe({', '.join(images)},\n            {rest})")
        else:
            images = [f"{lobe}_{part}" for part in LOBE_CHANNELS]
            terms.append(f"radtex_lobe({', '.join(images)}, cells, surroundings, around, uv, {axis})")
    samplers = [f"sampler2D {layer} : filter_nearest, repeat_disable" for layer in manifest.textures]
    words = {
        "DEFINES": "\n".join(defines),
        "INCLUDES": "".join(f'\n#include "shaders/{name}.gdshaderinc"' for name in includes),
        "UNIFORMS": "\n".join(f"uniform {uniform};" for uniform in (*samplers, *numbers)),
        "LOOKUP": "\n        + ".join(terms),
    }
    return GodotShader("shared.gdshader", words, includes, parameters, manifest.textures)


def _ranges(lobe: Mapping[str, Any]) -> Floats:
    """A lobe's ranges as the include takes them, (12, 4)."""
    rows = [row + [0.0] * (4 - len(row)) for part in LOBE_CHANNELS for row in lobe[part]]
    return np.array(rows)


def _integers(values: Any) -> str:
    return f"Vector{len(values)}i({', '.join(str(int(value)) for value in values)})"


def _list(values: npt.ArrayLike) -> str:
    return ", ".join(repr(float(value)) for value in np.asarray(values, dtype=np.float64).ravel())
