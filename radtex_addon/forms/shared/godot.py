# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Godot shader of bakes in the shared layout."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.arrays import Floats
from ...formats.packing import LOBE_CHANNELS, TEXTURES, WEIGHTS
from ...textures.entry import TextureEntry
from ...textures.godot_shader import GodotShader, integers, number_list

_AXES = {"mirror": "reflect(-V, N)", "through": "-V"}


def shared_shader(
    bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], baked: Floats
) -> GodotShader:
    """The shader of a bake with this sidecar's JSON and these textures; `baked` as in `Form.godot_shader`."""
    shared = bake["shared"]
    condensed = shared.get("condensed")
    includes = ("radtex_shared", "radtex_condensed") if condensed else ("radtex_shared",)
    defines = [f"#define RADTEX_FALLOFF {len(shared['falloff'])}"]
    terms = ["radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, dot(N, V))"]
    numbers = ["ivec2 fine", "ivec2 texels", "ivec2 around", "int cells", "vec3 falloff[RADTEX_FALLOFF]"]
    parameters = {
        "baked": f"Basis({number_list(baked[:, :3])})",
        "fine": integers(shared["colour"]),
        "texels": integers(bake["texels"]),
        "around": integers((shared["surroundings"], shared["levels"])),
        "cells": str(bake["bucket"]),
        "falloff": f"PackedVector3Array({number_list(shared['falloff'])})",
    }
    if condensed:
        defines.append(f"#define RADTEX_RANK {condensed['rank']}")
        numbers.append("int columns")
        parameters["columns"] = str(condensed["columns"])
    for lobe in shared["lobes"]:
        axis = _AXES[lobe]
        if condensed:
            numbers.append(f"vec4 {lobe}_ranges[12]")
            ranges = _ranges(condensed["lobes"][lobe])
            parameters[f"{lobe}_ranges"] = f"PackedVector4Array({number_list(ranges)})"
            images = [f"{lobe}_{part}" for part in (WEIGHTS, *sum(TEXTURES.values(), ()))]
            rest = f"{lobe}_ranges, columns, cells, texels, surroundings, around, uv, {axis}"
            terms.append(f"radtex_condensed_lobe({', '.join(images)},\n            {rest})")
        else:
            images = [f"{lobe}_{part}" for part in LOBE_CHANNELS]
            terms.append(f"radtex_lobe({', '.join(images)}, cells, surroundings, around, uv, {axis})")
    samplers = [f"sampler2D {layer} : filter_nearest, repeat_disable" for layer in textures]
    words = {
        "DEFINES": "\n".join(defines),
        "INCLUDES": "".join(f'\n#include "shaders/{name}.gdshaderinc"' for name in includes),
        "UNIFORMS": "\n".join(f"uniform {uniform};" for uniform in (*samplers, *numbers)),
        "LOOKUP": "\n        + ".join(terms),
    }
    return GodotShader("shared.gdshader", words, includes, parameters, textures)


def _ranges(lobe: Mapping[str, Any]) -> Floats:
    """A lobe's ranges in the order that the shader include expects, (12, 4)."""
    rows = [row + [0.0] * (4 - len(row)) for part in LOBE_CHANNELS for row in lobe[part]]
    return np.array(rows)
