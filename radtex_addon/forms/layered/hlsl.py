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
from .files.arrangement import OF_IMAGES
from .shader_values import IMAGES

_FRAME = """N = normalize(N);
V = normalize(V);
"""
_WHOLE_FRAME = f"""{_FRAME}T = normalize(T - N * dot(N, T));
"""
_OPAQUE = "radtex_layered(uv, position, N, V)"
_OF_IMAGES = "radtex_layered_images(uv, image_uv, position, T, sign(side) * cross(N, T), N, normalize(V))"
_THROUGH = "radtex_layered_through(uv, position, N, V, T, sign(side) * cross(N, T))"


def layered_lookup(
    facts: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
) -> HlslLookup:
    """The lookup of a bake with these textures and the JSON of `shader_values.shader_facts`."""
    defines: dict[str, int | str] = dict(facts["defines"])
    through = "RADTEX_THROUGH" in defines
    found = {_texture(layer): textures[layer] for layer in facts["layers"]}
    if any(is_top_down(entry, target) for entry in found.values()):
        defines["RADTEX_TOP_DOWN"] = 1
    body = (_WHOLE_FRAME if through else _FRAME) + _returned(_THROUGH if through else _OPAQUE)
    of_images = frozenset(number for number, each in enumerate(facts["materials"]) if IMAGES in each)
    if of_images:
        body = f"#ifdef RADTEX_IMAGES\n{_returned(_OF_IMAGES)}#else\n{body}#endif\n"
        defines["RADTEX_PACKED_BUMP"] = 1  # engines keep two channels of normal maps
    return HlslLookup(
        defines={**defines, "RADTEX_DECLARED": 1, "RADTEX_SAMPLER": SAMPLER},
        textures=found,
        constants=_constants(facts["values"]),
        includes=("radtex_layered", "radtex_layered_through") if through else ("radtex_layered",),
        body=body,
        materials=tuple(map(_constants, facts["materials"])),
        of_images=of_images,
        replaced=tuple(map(_texture, OF_IMAGES)),
    )


def _texture(layer: str) -> str:
    return f"radtex_{layer}_map"


def _returned(light: str) -> str:
    return f"return float4({light}, radtex_alpha(uv));\n"


def _constants(values: Mapping[str, Any]) -> tuple[Number, ...]:
    """Uniforms, all of four numbers, as constants."""
    return tuple(
        Number("float4", name, np.asarray(value, dtype=np.float32)) for name, value in values.items()
    )
