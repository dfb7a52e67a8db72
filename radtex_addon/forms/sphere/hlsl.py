# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lookup in HLSL of bakes of kind `transfer`, in the light of one sun."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...textures.entry import TextureEntry
from ...textures.export_spec import Target
from ..hlsl_lookup import HlslLookup, is_top_down, numbers, page_words


def sphere_lookup(
    bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
) -> HlslLookup:
    """The lookup of a bake with this sidecar's JSON and these textures."""
    entry, cells, views = textures[bake["kind"]], bake["bucket"], bake["transfer"].get("views", 1)
    atlas, defines = page_words(entry)
    if is_top_down(entry, target):
        defines["RADTEX_TOP_DOWN"] = 1
    size = f"int2({numbers(bake['texels'])})"
    answer = f"radtex_transfer({atlas}, {size}, {cells}, uv, to_sun)"
    if views > 1:
        answer = f"radtex_transfer_around({atlas}, {size}, {views}, {cells}, uv, I, to_sun)"
    body = (
        "float3 I = radtex_incidence(V, N, T, side), to_sun = radtex_incidence(L, N, T, side);\n"
        f"float4 answer = {answer};\n"
        "return float4(answer.rgb * irradiance, answer.a);"
    )
    includes = ("radtex", "radtex_transfer")
    return HlslLookup(defines, {"radtex_atlas": entry}, (), includes, body, relit=True)
