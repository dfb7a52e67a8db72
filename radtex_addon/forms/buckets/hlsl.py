# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lookup in HLSL of bakes in buckets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...textures.entry import Arranged, TextureEntry
from ...textures.export_spec import Target
from ..hlsl_lookup import SAMPLER, HlslLookup, is_top_down, keeps_levels, numbers, page_words


def buckets_lookup(
    bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
) -> HlslLookup:
    """The lookup of a bake with this sidecar's JSON and these textures."""
    entry, cells = textures[bake["kind"]], bake["bucket"]
    atlas, defines = page_words(entry)
    size = f"int2({numbers(entry.texels)})"
    if entry.arrangement is Arranged.SLICES:
        defines = {}
        light = f"radtex_slices(radtex_atlas, {SAMPLER}, {cells}, uv, I)"
    elif keeps_levels(entry, target):
        level = f"RADTEX_LEVEL(uv, {size}, {entry.levels})"
        light = f"radtex_sample_level({atlas}, {size}, {cells}, uv, I, {level})"
    else:
        light = f"radtex_sample({atlas}, {size}, {cells}, uv, I, RADTEX_QUADRILINEAR)"
    if is_top_down(entry, target):
        defines["RADTEX_TOP_DOWN"] = 1
    body = f"float3 I = radtex_incidence(V, N, T, side);\nreturn {light};"
    return HlslLookup(defines, {"radtex_atlas": entry}, (), ("radtex",), body)
