# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_layered.hlsl, through SPIR-V on a real Vulkan, against the layout's reference sampler."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.forms.layered.files.arrangement import CHANNELS
from radtex_addon.forms.layered.shader_values import (
    BAKE_BUFFER,
    DEFAULT,
    FULL,
    MATERIAL_BUFFER,
    THROUGH_BUFFER,
    Cost,
    Values,
    bake_values,
    buffer_of,
    definitions,
    material_values,
)
from tests.layered_lookups import Case, assert_agrees, case_of, off
from tests.lookups import SIDE
from tests.real.hlsl import COMPILERS, compiled, looked_up
from tests.real.root import Root
from tests.real.webgpu import Resource, Sampler, fields, image

TOP_DOWN = "#define RADTEX_TOP_DOWN\n"
TEXTURES = (  # in the order of the registers
    *("colour", "irradiance", "tint", "normal", "width", "alpha", "own", "rest"),
    *("world", "plane", "things", "distances"),
    *("exit_direction", "exit_place", "through_colour", "through_rest"),
)
SHADER = """
#define RADTEX_TEXTURE(k) : register(t##k)
#define RADTEX_BUFFER(k) : register(b##k)
SamplerState filtering : register(s0);
#define RADTEX_SAMPLER filtering
#include "%s.hlsl"
Texture2DArray fields : register(t16);
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy);
    float2 uv = fields.Load(int4(here, 0, 0)).xy;
    float3 position = fields.Load(int4(here, 1, 0)).xyz;
    float3 N = fields.Load(int4(here, 2, 0)).xyz, V = fields.Load(int4(here, 3, 0)).xyz;
#ifdef RADTEX_THROUGH
    float3 T = fields.Load(int4(here, 4, 0)).xyz, B = fields.Load(int4(here, 5, 0)).xyz;
    return float4(radtex_layered_through(uv, position, N, V, T, B), 1.0);
#else
    return float4(radtex_layered(uv, position, N, V), 1.0);
#endif
}
"""


def run(root: Root, compiler: str, defines: str, case: Case, cost: Cost) -> Floats:
    """The shader's answers, (N, 3) float32."""
    assert set(TEXTURES) == set(CHANNELS)
    for name, value in definitions(case.sidecar, cost).items():
        defines += f"#define {name} {value}\n"
    source = defines + SHADER % ("radtex_layered_through" if case.through else "radtex_layered")
    values = bake_values(case.sidecar, case.stored, cost)
    resources: dict[str, Resource] = {
        "s0": Sampler("linear"),
        "b0": packed(values, BAKE_BUFFER),
        "b2": packed(values, THROUGH_BUFFER),
        "t16": fields(SIDE, *case.fields.values()),
    }
    for k, layer in enumerate(TEXTURES):
        if layer in case.textures:
            levels = case.textures[layer]
            resources[f"t{k}"] = image(*(level[::-1] if TOP_DOWN in defines else level for level in levels))

    def with_material(number: int) -> Floats:
        of_material = packed(material_values(case.sidecar, number, cost), MATERIAL_BUFFER)
        return looked_up(root, compiler, source, resources | {"b1": of_material}, SIDE)

    return case.by_material(with_material)


def packed(values: Values, layout: Mapping[str, int]) -> Floats:
    return np.array(buffer_of(values, layout), dtype=np.float32)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(
    ("name", "defines"),
    [("everything, in ranges", TOP_DOWN), ("made up", ""), ("bare", ""), ("matt", "")],
)
def test_hlsl_agrees_with_the_reference(root: Root, compiler: str, name: str, defines: str) -> None:
    case = case_of(name)
    assert_agrees(f"{compiler}, {name}", run(root, compiler, defines, case, FULL), case)


def test_thrift_changes_little(root: Root) -> None:
    case = case_of("everything")
    wrong = off(run(root, "glslang", "", case, DEFAULT), case.answers())
    print(f"as it is by default: mean error {wrong.mean():.1e}")
    assert wrong.mean() < 0.01


def test_the_compiler_chooses_registers_in_any_stage(root: Root) -> None:
    defines = "".join(
        f"#define {name} {value}\n" for name, value in definitions(case_of("made up").sidecar).items()
    )
    code = """#define RADTEX_NO_DERIVATIVES
#include "radtex_layered.hlsl"
float4 main(float4 at : POSITION) : SV_Position {
    float3 N = float3(0.0, 0.0, 1.0);
    return float4(radtex_layered(at.xy, at.xyz, N, normalize(at.xyz)), radtex_alpha(at.xy));
}
"""
    compiled(root, "vkd3d", defines + code, "vertex")
