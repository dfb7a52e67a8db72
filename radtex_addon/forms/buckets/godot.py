# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Godot shader of bakes in buckets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...bake.kinds import Kind
from ...formats.containers.texture import PixelFormat
from ...textures.entry import Arranged, TextureEntry
from ...textures.godot_shader import GodotShader, blending_words, integers

_FILTERS = '"Nearest", "Linear", "Quadrilinear"'


def buckets_shader(bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> GodotShader:
    """The shader of a bake with this sidecar's JSON and these textures."""
    entry = textures[bake["kind"]]
    return _slices(bake, entry) if entry.arrangement is Arranged.SLICES else _matrix(bake, entry)


def _matrix(bake: Mapping[str, Any], entry: TextureEntry) -> GodotShader:
    paged, levels = entry.layers > 1, entry.levels
    atlas = "atlas, pages" if paged else "atlas"
    lookup = f"radtex_sample({atlas}, texels, cells, uv, I, filtering)"
    filters, default, uniforms = _FILTERS, 2, ["uniform ivec2 texels;", "uniform int cells;"]
    parameters = {"texels": integers(entry.texels), "cells": str(bake["bucket"])}
    if paged:
        uniforms.append("uniform ivec4 pages;  // columns, rows, texels a page across, up")
        parameters["pages"] = integers((*entry.pages, *entry.page_texels))
    if levels > 1:
        by_level = f"radtex_sample_level({atlas}, texels, cells, uv, I, radtex_level(uv, texels, levels))"
        lookup = f"filtering == 3 ? {by_level}\n        : {lookup}"
        filters, default = f'{_FILTERS}, "Quadrilinear, mipmaps"', 3
        uniforms.append("uniform int levels;")
        parameters["levels"] = str(levels)
    uniforms = [
        f"uniform int filtering : hint_enum({filters}) = {default};",
        "uniform sampler2DArray atlas : filter_nearest_mipmap, repeat_disable;"  # Godot blends no pages
        if paged
        else "uniform sampler2D atlas : filter_linear_mipmap, repeat_disable;",
        *uniforms,
    ]
    hull = Kind(bake["kind"]).traits.content
    return _buckets(entry, "atlas", f"vec4 light = {lookup};", uniforms, parameters, paged, hull)


def _slices(bake: Mapping[str, Any], entry: TextureEntry) -> GodotShader:
    hints = "filter_linear_mipmap_anisotropic, repeat_disable"
    uniforms = [f"uniform sampler2DArray slices : {hints};", "uniform int cells;"]
    lookup = "vec4 light = radtex_slices(slices, cells, uv, I);"
    parameters = {"cells": str(bake["bucket"])}
    hull = Kind(bake["kind"]).traits.content
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
    blended = entry.format is PixelFormat.RGBA16F  # other formats have no alpha: opaque
    words = {
        "CULLED": "cull_back" if hull else "cull_disabled",  # a hull is seen from outside only
        "DEFINES": "\n#define RADTEX_PAGES" if paged else "\n#define RADTEX_HARDWARE_LINEAR",
        "UNIFORMS": "\n".join(uniforms),
        "LOOKUP": f"    {lookup}",
        **blending_words("light.a" if blended else None, hull=hull),
    }
    return GodotShader("buckets.gdshader", words, ("radtex",), parameters, {texture: entry})
