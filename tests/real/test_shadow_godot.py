# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shadow.gdshaderinc in a real Godot against core.shadow: a light, a sun, a rectangle."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.formats.shadow_files import Words
from tests.lookups import random_lookups
from tests.real.godot import RENDERERS, Job, answers
from tests.real.root import Root
from tests.real.shadows import (
    ACROSS,
    ANGLE,
    CORNER,
    ONE,
    POINTS,
    RECTANGLE,
    SUN,
    UP,
    check,
    expected,
    random_words,
)
from tests.real.test_godot import fields

LAYERS = "#define RADTEX_SHADOW_LAYERS\n"
CODE = """
#ifdef RADTEX_SHADOW_LAYERS
#define HERE words, here
#else
#define HERE here
#endif
vec4 answer(ivec2 here_) {
    vec4 normal = texelFetch(normals, here_, 0);
    vec3 tangent = texelFetch(tangents, here_, 0).xyz, light = texelFetch(viewers, here_, 0).xyz;
    mat3 frame = radtex_frame(normal.xyz, tangent, normal.w);
    RadtexShadow here = radtex_shadow(words, ivec2(%d, %d), texelFetch(uvs, here_, 0).xy);
    return vec4(%s);
}
"""
CALLS = {
    ONE: "radtex_visible(HERE, {n}, normalize(light) * frame)",
    SUN: f"radtex_sun(HERE, {{n}}, frame, light, {ANGLE}, {POINTS})",
    RECTANGLE: f"radtex_rectangle(HERE, {{n}}, frame, light, vec3{CORNER}, vec3{ACROSS}, vec3{UP}, {POINTS})",
}
CASES = [*product((ONE, SUN, RECTANGLE), ((5, False), (8, False), (12, True)))]


def stored(words: Words, *, layered: bool) -> Floats:
    """Words (H, W, w) as Godot has them: pixels of a word's bytes over 255, (H, 1 or 2 W, 4), or layers."""
    height, width, count = words.shape
    if count == 1:
        pixels = words[None]
    else:
        pairs = np.pad(words, ((0, 0), (0, 0), (0, count % 2))).reshape(height, width, -1, 2)
        pixels = pairs.transpose(2, 0, 1, 3)
    whole = np.ascontiguousarray(pixels, dtype="<u4").view(np.uint8).reshape(len(pixels), height, -1, 4)
    images: Floats = (whole / np.float32(255)).astype(np.float32)
    return images if layered else images[0]


@pytest.mark.parametrize("renderer", RENDERERS)
def test_godot_agrees_with_the_reference(root: Root, renderer: str) -> None:
    lookups, jobs = random_lookups(), []
    for mode, (cells, layered) in CASES:
        layout = AtlasLayout(13, 7, cells)
        code = CODE % (layout.width, layout.height, CALLS[mode].format(n=cells))
        textures = {"words": stored(random_words(layout), layered=layered), **fields(lookups)}
        includes = ("radtex", "radtex_shadow")
        jobs.append(Job(code, textures, includes, LAYERS * layered, {"words": "filter_nearest"}))
    for (mode, (cells, layered)), result in zip(CASES, answers(root, renderer, jobs), strict=True):
        layout = AtlasLayout(13, 7, cells)
        wanted = expected(random_words(layout), layout, lookups, mode, layered)
        check(result[:, 0], wanted, mode, layered, f"{renderer}, {cells} cells")
