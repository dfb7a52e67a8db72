# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lookup in HLSL of bakes in the layered layout."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...textures.entry import TextureEntry
from ...textures.export_spec import Target
from ..hlsl_lookup import SAMPLER, HlslLookup, Number, is_top_down

_FRAME = """N = normalize(N);
V = normalize(V);
"""
_WHOLE_FRAME = f"""{_FRAME}T = normalize(T - N * dot(N, T));
"""
_OPAQUE = "radtex_layered(uv, position, N, V)"
_THROUGH = "radtex_layered_through(uv, position, N, V, T, sign(side) * cross(N, T))"


def layered_lookup(
    facts: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
) -> HlslLookup:
    """The lookup of a bake with these textures and the JSON of `shader_values.shader_facts`."""
    defines: dict[str, int | str] = dict(facts["defines"])
    through = "RADTEX_THROUGH" in defines
    found = {f"radtex_{layer}_map": textures[layer] for layer in facts["layers"]}
    if any(is_top_down(entry, target) for entry in found.values()):
        defines["RADTEX_TOP_DOWN"] = 1
    return HlslLookup(
        defines={**defines, "RADTEX_DECLARED": 1, "RADTEX_SAMPLER": SAMPLER},
        textures=found,
        constants=_constants(facts["values"]),
        includes=("radtex_layered", "radtex_layered_through") if through else ("radtex_layered",),
        body=(_WHOLE_FRAME if through else _FRAME)
        + f"return float4({_THROUGH if through else _OPAQUE}, radtex_alpha(uv));",
        materials=tuple(map(_constants, facts["materials"])),
    )


def _constants(values: Mapping[str, Any]) -> tuple[Number, ...]:
    """Uniforms, all of four numbers, as constants."""
    return tuple(
        Number("float4", name, np.asarray(value, dtype=np.float32)) for name, value in values.items()
    )
