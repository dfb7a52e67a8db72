# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex.hlsl, through SPIR-V on a real Vulkan, against the references."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.pages import fitting_pages
from radtex_addon.core.sampler import Filter
from tests.lookups import (
    COUNT,
    LAYOUT,
    SIDE,
    constant_buckets,
    hit_answers,
    random_atlas,
    random_lookups,
    relative_error,
    worst_error,
)
from tests.real.hlsl import COMPILERS, compiled, looked_up
from tests.real.root import Root
from tests.real.test_glsl_derivatives import half_slices, reference, uvs_of_quads
from tests.real.webgpu import Resource, Sampler, fields, image
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import page_chain

EXAMPLE = Path(__file__).parents[2] / "shaders" / "examples" / "object.hlsl"
WORST = 2e-3
LEVELS = 4  # 13 x 7 texels are stored as 16 x 8, and the last level as 2 x 1
PAGES = fitting_pages(LAYOUT, 50, LEVELS)
PAGED, TOP_DOWN = "#define RADTEX_PAGES\n", "#define RADTEX_TOP_DOWN\n"
HARDWARE = "#define RADTEX_HARDWARE_LINEAR filtering\n"
WAYS = {"one texture": "", "pages": PAGED, "top down": TOP_DOWN, "pages top down": PAGED + TOP_DOWN}
SHADER = """
SamplerState filtering : register(s0);
#include "radtex.hlsl"
#ifdef RADTEX_PAGES
Texture2DArray atlas : register(t0);
#else
Texture2D atlas : register(t0);
#endif
Texture2DArray fields : register(t1);
cbuffer Facts : register(b0) { int4 pages; int4 facts; };
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy), texels = facts.xy;
    int n = facts.z;
    float4 place = fields.Load(int4(here, 0, 0));  // u, v, filter, level
    float4 normal = fields.Load(int4(here, 1, 0)), tangent = fields.Load(int4(here, 2, 0));
    float3 viewer = fields.Load(int4(here, 3, 0)).xyz;
    float3 I = radtex_incidence(viewer, normal.xyz, tangent.xyz, normal.w);
    int mode = int(place.z);
    if (mode < 3) return radtex_sample(RADTEX_PASSED, texels, n, place.xy, I, mode);
    if (mode == 3) return radtex_sample_level(RADTEX_PASSED, texels, n, place.xy, I, place.w);
    return radtex_hit(RADTEX_PASSED, texels, n, place.xy, -viewer, normal.xyz, tangent.xyz, normal.w,
                      RADTEX_QUADRILINEAR);
}
"""
SLICES = """
#include "radtex.hlsl"
Texture2DArray slices : register(t0), fields : register(t1);
SamplerState filtering : register(s0);
cbuffer Facts : register(b0) { int4 pages; int4 facts; };
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy);
    float2 uv = fields.Load(int4(here, 0, 0)).xy;
    return radtex_slices(slices, filtering, facts.z, uv, fields.Load(int4(here, 1, 0)).xyz);
}
"""
LEVEL = """
#include "radtex.hlsl"
Texture2DArray fields : register(t1);
cbuffer Facts : register(b0) { int4 pages; int4 facts; };
float4 main(float4 at : SV_Position) : SV_Target {
    return radtex_level(fields.Load(int4(int2(at.xy), 0, 0)).xy, facts.xy, facts.w);
}
"""
FACTS = np.array([*astuple(PAGES), LAYOUT.width, LAYOUT.height, LAYOUT.bucket, LEVELS], np.int32)


def run(root: Root, compiler: str, defines: str, atlas: Floats, level: Floats | None) -> list[Floats]:
    """Answers to `random_lookups`, (COUNT, 4) float32 by each filter, then at `level` (COUNT,) or by rays."""
    lookups = random_lookups()
    paged = PAGED in defines
    chain = page_chain(atlas, LAYOUT, PAGES, LEVELS) if paged else level_chain(atlas, LAYOUT, LEVELS)
    stored = [values.astype(np.float16) for values in chain]
    if TOP_DOWN in defines:
        stored = [np.flip(values, axis=-3) for values in stored]
    mode = np.repeat([0, 1, 2, 4 if level is None else 3], COUNT)[:, None]
    levels = np.tile(np.zeros(COUNT) if level is None else level, 4)[:, None]
    places = np.concatenate([np.tile(lookups.uv, (4, 1)), mode, levels], axis=1)
    normals = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    vectors = [np.tile(values, (4, 1)) for values in (normals, lookups.tangent, lookups.viewer)]
    resources: dict[str, Resource] = {
        "t0": image(*stored),
        "t1": fields(2 * SIDE, places, *vectors),
        "s0": Sampler("linear"),
        "b0": FACTS,
    }
    answers = looked_up(root, compiler, defines + SHADER, resources, 2 * SIDE)
    return np.split(answers, 4)


def random_levels(seed: int = 5) -> Floats:
    """Levels (COUNT,) float32, many of them whole."""
    level = np.random.default_rng(seed).uniform(0, LEVELS - 1, COUNT)
    level[::3] = np.round(level[::3])
    return level.astype(np.float32)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_hlsl_agrees_with_the_reference(root: Root, compiler: str, way: str) -> None:
    atlas, lookups, level = random_atlas(), random_lookups(), random_levels()
    *results, at_level = run(root, compiler, WAYS[way], atlas, level)
    for kind, result in zip(Filter, results, strict=True):
        worst, across = worst_error(result, atlas, lookups, kind)
        print(f"{compiler}, {way}, {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
        assert worst <= WORST
        assert across <= 2e-3
    chain = [values.astype(np.float16).astype(float) for values in level_chain(atlas, LAYOUT, LEVELS)]
    expected = sample_level(chain, LAYOUT, lookups.uv.astype(float), lookups.incidence, level.astype(float))
    error = relative_error(at_level, expected)
    print(f"{compiler}, {way}, levels: worst error {error.max():.1e}")
    assert error.max() <= WORST


@pytest.mark.parametrize("way", ["one texture", "pages top down"])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_rays_find_what_the_reference_does(root: Root, compiler: str, way: str) -> None:
    atlas = random_atlas()
    error = relative_error(
        run(root, compiler, WAYS[way], atlas, None)[3], hit_answers(atlas, random_lookups())
    )
    print(f"{compiler}, {way}, rays: worst error {error.max():.1e}")
    assert error.max() <= WORST


@pytest.mark.parametrize(("defines", "rounding"), [("", 1e-7), (HARDWARE, 5e-4), (HARDWARE + PAGED, 5e-4)])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_buckets_do_not_bleed(root: Root, compiler: str, defines: str, rounding: float) -> None:
    atlas, lookups = constant_buckets(), random_lookups()
    result = run(root, compiler, defines, atlas, random_levels())[list(Filter).index(Filter.LINEAR)]
    assert worst_error(result, atlas, lookups, Filter.LINEAR)[0] <= rounding


@pytest.mark.parametrize("way", ["one texture", "pages top down"])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_one_hardware_lookup_is_as_good_as_its_weights(root: Root, compiler: str, way: str) -> None:
    atlas, level = random_atlas(), random_levels()
    filtered = run(root, compiler, HARDWARE + WAYS[way], atlas, level)
    exact = run(root, compiler, WAYS[way], atlas, level)
    np.testing.assert_allclose(filtered, exact, rtol=0, atol=float(atlas.max()) * 2 / 256)


@pytest.mark.parametrize("defines", ["", TOP_DOWN])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_slices_agree_with_the_reference(root: Root, compiler: str, defines: str) -> None:
    uv, level = uvs_of_quads(axis=True, whole=True)
    chain = half_slices()
    stored = [values[:, ::-1] if defines else values for values in chain]
    resources: dict[str, Resource] = {
        "t0": image(*stored),
        "t1": fields(SIDE, uv.reshape(COUNT, 2), random_lookups().incidence),
        "s0": Sampler("linear"),
        "b0": FACTS,
    }
    result = looked_up(root, compiler, defines + SLICES, resources, SIDE)
    error = relative_error(result, reference(chain, uv, level))
    print(
        f"{compiler}, slices {defines.strip()}: worst error {error.max():.1e}, median {np.median(error):.1e}"
    )
    assert error.max() <= WORST


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_level_is_where_a_texel_is_as_wide_as_a_pixel(root: Root, compiler: str) -> None:
    uv, level = uvs_of_quads(axis=False, whole=False)
    resources: dict[str, Resource] = {"t1": fields(SIDE, uv.reshape(COUNT, 2)), "b0": FACTS}
    found = looked_up(root, compiler, LEVEL, resources, SIDE)[:, 0]
    np.testing.assert_allclose(found, np.minimum(level, LEVELS - 1).ravel(), atol=1e-4)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_example_compiles(root: Root, compiler: str) -> None:
    example = EXAMPLE.read_text(encoding="utf-8").replace('"../', '"')
    _, registers = compiled(root, compiler, example, "vertex", "vertex_main")
    assert "b0" in registers
    _, registers = compiled(root, compiler, example, "pixel", "pixel_main")
    assert {"t0", "b0", "b1"} <= set(registers)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_what_is_wrong_with_a_shader_is_told(root: Root, compiler: str) -> None:
    with pytest.raises(ValueError, match="radtex_bukcet"):
        looked_up(root, compiler, LEVEL.replace("radtex_level", "radtex_bukcet"), {}, SIDE)
