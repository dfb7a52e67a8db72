# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Godot shader of bakes in the layered layout."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.arrays import Floats
from ...textures.entry import TextureEntry
from ...textures.godot_shader import GodotShader, blending_words, number_list

_OPAQUE = "radtex_layered(uv, place, N, V)"
_THROUGH = "radtex_layered_through(uv, place, N, V, T, side * cross(N, T))"


def layered_shader(
    facts: Mapping[str, Any], textures: Mapping[str, TextureEntry], baked: Floats, culled: bool = False
) -> GodotShader:
    """The shader of a bake with these textures and the JSON of `shader_values.shader_facts`.

    `baked` is as in `Form.godot_shader`. Each of the bake's materials has parameters of its own; if it is
    `culled`, only front faces are drawn.
    """
    defines = facts["defines"]
    through, clear = "RADTEX_THROUGH" in defines, "RADTEX_ALPHA" in defines
    includes = ("radtex_layered", "radtex_layered_through") if through else ("radtex_layered",)
    words = {
        "SIDES": "cull_back" if culled else "cull_disabled",
        "DEFINES": "\n".join(f"#define {name} {value}" for name, value in defines.items()),
        "INCLUDES": "".join(f'\n#include "shaders/{name}.gdshaderinc"' for name in includes),
        "LOOKUP": _THROUGH if through else _OPAQUE,
        **blending_words("radtex_alpha(uv)" if clear else None, prepass=True),
    }
    parameters = {
        "baked": f"Basis({number_list(baked[:, :3])})",
        "baked_place": f"Vector3({number_list(baked[:, 3])})",
    }
    found = {f"radtex_{layer}_map": textures[layer] for layer in facts["layers"]}
    return GodotShader(
        "layered.gdshader",
        words,
        includes,
        parameters | _written(facts["values"]),
        found,
        tuple(map(_written, facts["materials"])),
    )


def _written(values: Mapping[str, Any]) -> dict[str, str]:
    """Uniforms as Godot's material files have them."""
    return {
        name: f"{'PackedVector4Array' if np.ndim(value) > 1 else 'Vector4'}({number_list(value)})"
        for name, value in values.items()
    }
