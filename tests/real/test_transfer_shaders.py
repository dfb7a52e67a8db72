# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_transfer.hlsl, .wgsl and .gdshaderinc on a real Vulkan and in a real Godot."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrangements import Pages, fitting_pages
from radtex_addon.core.arrays import Floats
from radtex_addon.formats.transfer_files import with_views
from tests.lookups import COUNT, LAYOUT, SIDE, relative_error
from tests.real.godot import RENDERERS, Job, answers
from tests.real.hlsl import COMPILERS, looked_up
from tests.real.root import Root
from tests.real.webgpu import Resource, drawn, fields, image
from tests.reference.pages import page_chain
from tests.transfer_lookups import VIEWS, WORST, Question, Way, questions

SHADERS = Path(__file__).parents[2] / "shaders"
PAGED, TOP_DOWN = "#define RADTEX_PAGES\n", "#define RADTEX_TOP_DOWN\n"
HLSL = """
#include "radtex.hlsl"
#include "radtex_transfer.hlsl"
#ifdef RADTEX_PAGES
Texture2DArray atlas : register(t0);
#else
Texture2D atlas : register(t0);
#endif
Texture2DArray fields : register(t1);
cbuffer Facts : register(b0) { int4 pages; int4 facts; };
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy), texels = facts.xy;
    int n = facts.z, mode = facts.w;
    float2 uv = fields.Load(int4(here, 0, 0)).xy;
    float4 normal = fields.Load(int4(here, 1, 0));
    float4 tangent = float4(fields.Load(int4(here, 2, 0)).xyz, normal.w);
    float3 I = radtex_incidence(fields.Load(int4(here, 3, 0)).xyz, normal.xyz, tangent.xyz, tangent.w);
    float3 light = fields.Load(int4(here, 4, 0)).xyz, power = float3(2.0, 1.0, 0.5);
    float3 L = radtex_incidence(light, normal.xyz, tangent.xyz, tangent.w);
    if (mode == 0) return radtex_transfer(RADTEX_PASSED, texels, n, uv, L);
    if (mode == 1)
        return float4(radtex_sun(RADTEX_PASSED, texels, n, uv, normal.xyz, tangent, light, power), 1.0);
    if (mode == 2)
        return float4(
            radtex_point_light(RADTEX_PASSED, texels, n, uv, normal.xyz, tangent, light, power), 1.0);
    return radtex_transfer_around(RADTEX_PASSED, texels, 3, n, uv, I, L);
}
"""
WGSL = """
struct Settings { texels: vec2i, n: i32, mode: i32 }
@group(0) @binding(0) var<uniform> s: Settings;
@group(0) @binding(1) var fields: texture_2d_array<f32>;
@group(0) @binding(2) var atlas: texture_2d<f32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    let uv = textureLoad(fields, here, 0, 0).xy;
    let normal = textureLoad(fields, here, 1, 0);
    let tangent = vec4f(textureLoad(fields, here, 2, 0).xyz, normal.w);
    let I = radtex_incidence(textureLoad(fields, here, 3, 0).xyz, normal.xyz, tangent.xyz, tangent.w);
    let light = textureLoad(fields, here, 4, 0).xyz;
    let power = vec3f(2.0, 1.0, 0.5);
    let L = radtex_incidence(light, normal.xyz, tangent.xyz, tangent.w);
    switch s.mode {
        case 0 { return radtex_transfer(atlas, s.texels, s.n, uv, L); }
        case 1 { return vec4f(radtex_sun(atlas, s.texels, s.n, uv, normal.xyz, tangent, light, power), 1.0); }
        case 2 {
            let lamp = radtex_point_light(atlas, s.texels, s.n, uv, normal.xyz, tangent, light, power);
            return vec4f(lamp, 1.0);
        }
        default { return radtex_transfer_around(atlas, s.texels, 3, s.n, uv, I, L); }
    }
}
"""
GODOT = f"""
#ifdef RADTEX_PAGES
#define ATLAS atlas, ivec4(%d, %d, %d, %d)
#else
#define ATLAS atlas
#endif
const ivec2 texels = ivec2({LAYOUT.width}, {LAYOUT.height});
const int n = {LAYOUT.bucket};
vec4 answer(ivec2 here) {{
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec4 normal = texelFetch(normals, here, 0);
    vec4 tangent = vec4(texelFetch(tangents, here, 0).xyz, normal.w);
    vec3 light = texelFetch(lights, here, 0).xyz, power = vec3(2.0, 1.0, 0.5);
    vec3 L = radtex_incidence(light, normal.xyz, tangent.xyz, tangent.w);
    vec3 I = radtex_incidence(texelFetch(viewers, here, 0).xyz, normal.xyz, tangent.xyz, tangent.w);
    return %s;
}}
"""
IN_GODOT = {
    Way.LOOKUP: "radtex_transfer(ATLAS, texels, n, uv, L)",
    Way.SUN: "vec4(radtex_sun(ATLAS, texels, n, uv, normal.xyz, tangent, light, power), 1.0)",
    Way.POINT: "vec4(radtex_point_light(ATLAS, texels, n, uv, normal.xyz, tangent, light, power), 1.0)",
    Way.AROUND: f"radtex_transfer_around(ATLAS, texels, {VIEWS}, n, uv, I, L)",
}


def paged(question: Question) -> tuple[Floats, Pages]:
    """The atlas as an array of pages, and how it is cut."""
    stored = with_views(LAYOUT, question.views)
    pages = fitting_pages(stored, 60, 1)
    return page_chain(question.atlas, stored, pages, 1)[0].astype(np.float16), pages


def check(result: Floats, question: Question, where: str) -> None:
    worst = float(relative_error(result, question.answers).max())
    print(f"{where}, {question.way.name}: worst error of {COUNT} lookups {worst:.1e}")
    assert worst <= WORST


def seen(question: Question) -> Resource:
    """The lookups as an array texture."""
    lookups = question.lookups
    normals = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    return fields(SIDE, lookups.uv, normals, lookups.tangent, lookups.viewer, question.light)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("defines", ["", TOP_DOWN, PAGED, PAGED + TOP_DOWN])
def test_hlsl_agrees_with_the_reference(root: Root, compiler: str, defines: str) -> None:
    for question in questions():
        atlas, pages = paged(question) if PAGED in defines else (question.atlas, Pages(1, 1, 1, 1))
        facts = [*astuple(pages), LAYOUT.width, LAYOUT.height, LAYOUT.bucket, int(question.way)]
        resources: dict[str, Resource] = {
            "t0": image(np.flip(atlas, axis=-3) if TOP_DOWN in defines else atlas),
            "t1": seen(question),
            "b0": np.array(facts, np.int32),
        }
        result = looked_up(root, compiler, defines + HLSL, resources, SIDE)
        check(result, question, f"{compiler} {defines.split()}")


def test_wgsl_agrees_with_the_reference(root: Root) -> None:
    code = "".join((SHADERS / f"{name}.wgsl").read_text("utf-8") for name in ("radtex", "radtex_transfer"))
    for question in questions():
        settings = [LAYOUT.width, LAYOUT.height, LAYOUT.bucket, int(question.way)]
        resources: dict[int | str, Resource] = {
            "s": np.array(settings, np.int32),
            "fields": seen(question),
            "atlas": image(question.atlas),
        }
        check(drawn(root, code + WGSL, resources, SIDE), question, "WGSL")


@pytest.mark.parametrize("renderer", RENDERERS)
def test_godot_agrees_with_the_reference(root: Root, renderer: str) -> None:
    jobs, asked = [], []
    for question in questions():
        lookups = question.lookups
        inputs = {
            "uvs": lookups.uv,
            "normals": np.column_stack([lookups.normal, lookups.sign]),
            "tangents": lookups.tangent,
            "viewers": lookups.viewer,
            "lights": question.light,
        }
        textures = {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}
        for defines in ("", PAGED):
            atlas, pages = paged(question) if defines else (question.atlas, Pages(1, 1, 1, 1))
            code = GODOT % (*astuple(pages), IN_GODOT[question.way])
            includes = ("radtex", "radtex_transfer")
            jobs.append(Job(code, {"atlas": atlas, **textures}, includes, defines))
            asked.append(question)
    for question, result in zip(asked, answers(root, renderer, jobs), strict=True):
        check(result, question, renderer)
