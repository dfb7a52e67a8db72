# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shadow.hlsl, through SPIR-V on a real Vulkan, against core.shadow: light, sun, rectangle."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.atlas import AtlasLayout
from tests.lookups import COUNT, SIDE, random_lookups
from tests.real.hlsl import COMPILERS, looked_up
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
    stacked,
)
from tests.real.webgpu import Resource, fields, image

LAYERS, TOP_DOWN = "#define RADTEX_SHADOW_LAYERS\n", "#define RADTEX_TOP_DOWN\n"
SHADER = """
#include "radtex.hlsl"
#include "radtex_shadow.hlsl"
RADTEX_BITS bits : register(t0);
Texture2DArray fields : register(t1);
cbuffer Facts : register(b0) { float4 corner, across, up; int4 facts; };
float4 main(float4 at : SV_Position) : SV_Target {
    int2 pixel = int2(at.xy);
    float4 place = fields.Load(int4(pixel, 0, 0)), normal = fields.Load(int4(pixel, 1, 0));
    float3 tangent = fields.Load(int4(pixel, 2, 0)).xyz, light = fields.Load(int4(pixel, 3, 0)).xyz;
    float3x3 frame = radtex_frame(normal.xyz, tangent, normal.w);
    RadtexShadow here = radtex_shadow(bits, facts.xy, place.xy);
    int n = facts.z, count = int(up.w), mode = int(place.z);
    float value;
    if (mode == 0) value = radtex_visible(RADTEX_HERE, n, mul(frame, normalize(light)));
    else if (mode == 1) value = radtex_sun(RADTEX_HERE, n, frame, light, corner.w, count);
    else value = radtex_rectangle(RADTEX_HERE, n, frame, light, corner.xyz, across.xyz, up.xyz, count);
    return float4(value, value, value, value);
}
"""


@pytest.mark.parametrize(
    ("cells", "defines"),
    [(5, ""), (8, ""), (8, TOP_DOWN), (8, LAYERS), (12, LAYERS), (12, LAYERS + TOP_DOWN)],
)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_hlsl_agrees_with_the_reference(root: Root, compiler: str, cells: int, defines: str) -> None:
    layout, lookups = AtlasLayout(13, 7, cells), random_lookups()
    words = random_words(layout)
    bits = stacked(words)[:, ::-1] if TOP_DOWN in defines else stacked(words)
    modes = (ONE, SUN, RECTANGLE, ONE)  # a picture of four squares
    facts = np.array([*CORNER, ANGLE, *ACROSS, 0, *UP, POINTS], np.float32).tobytes()
    facts += np.array([layout.width, layout.height, cells, 0], np.int32).tobytes()
    places = np.concatenate([np.tile(lookups.uv, (4, 1)), np.repeat(modes, COUNT)[:, None]], axis=1)
    normals = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    vectors = [np.tile(values, (4, 1)) for values in (normals, lookups.tangent, lookups.viewer)]
    resources: dict[str, Resource] = {
        "t0": image(bits if LAYERS in defines else bits[0]),
        "t1": fields(2 * SIDE, places, *vectors),
        "b0": np.frombuffer(facts, np.uint8),
    }
    answers = np.split(looked_up(root, compiler, defines + SHADER, resources, 2 * SIDE)[:, 0], 4)
    for mode, found in zip(modes[:3], answers, strict=False):
        wanted = expected(words, layout, lookups, mode, LAYERS in defines)
        check(found, wanted, mode, LAYERS in defines, f"{compiler}, {cells} cells, {defines!r}")
