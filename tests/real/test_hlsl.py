# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.hlsl, through SPIR-V on a real Vulkan, against the references."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrangements import fitting_pages
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter
from radtex_addon.forms.layered.files.arrangement import CHANNELS, FIELD
from radtex_addon.forms.layered.shader_values import (
    BAKE_BUFFER,
    DEFAULT,
    FULL,
    IMAGES_BUFFER,
    MATERIAL_BUFFER,
    THROUGH_BUFFER,
    LookupCost,
    Values,
    bake_values,
    buffer_of,
    definitions,
    material_values,
)
from tests.layered_lookups import Case, ImageCase, assert_agrees, case_of, image_case, off, variants
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
from tests.real.test_glsl import half_slices, of_slices, uvs_of_quads
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
    error = relative_error(result, of_slices(chain, uv, level))
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


TEXTURES = (  # in the order of the registers; between these and tangents are a material's own images
    *("colour", "irradiance", "tint", "normal", "width", "alpha", "own", "rest"),
    *("world", "plane", "things", "distances"),
    *("exit_direction", "exit_place", "through_colour", "through_rest"),
)
IMAGES = ("radtex_base_map", "radtex_metal_map", "radtex_bump_map")
LAYERED = """
#define RADTEX_TEXTURE(k) : register(t##k)
#define RADTEX_BUFFER(k) : register(b##k)
SamplerState filtering : register(s0);
#define RADTEX_SAMPLER filtering
#include "%s.hlsl"
Texture2DArray fields : register(t20);
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy);
    float2 uv = fields.Load(int4(here, 0, 0)).xy;
    float3 position = fields.Load(int4(here, 1, 0)).xyz;
    float3 N = fields.Load(int4(here, 2, 0)).xyz, V = fields.Load(int4(here, 3, 0)).xyz;
#ifdef RADTEX_IMAGES
    float3 T = fields.Load(int4(here, 4, 0)).xyz, B = fields.Load(int4(here, 5, 0)).xyz;
    float2 place = fields.Load(int4(here, 6, 0)).xy;
    return float4(radtex_layered_images(uv, place, position, T, B, N, V), 1.0);
#elif defined(RADTEX_THROUGH)
    float3 T = fields.Load(int4(here, 4, 0)).xyz, B = fields.Load(int4(here, 5, 0)).xyz;
    return float4(radtex_layered_through(uv, position, N, V, T, B), 1.0);
#else
    return float4(radtex_layered(uv, position, N, V), 1.0);
#endif
}
"""


def run_layered(
    root: Root, compiler: str, defines: str, case: Case, cost: LookupCost, shown: ImageCase | None = None
) -> Floats:
    """The shader's answers, (N, 3) float32; materials are `shown` by images of their own."""
    assert {*TEXTURES, "tangent", FIELD} == set(CHANNELS)
    for name, value in definitions(case.sidecar, cost).items():
        defines += f"#define {name} {value}\n"
    source = defines + LAYERED % ("radtex_layered_through" if case.through else "radtex_layered")
    values = bake_values(case.sidecar, case.stored, cost)
    resources: dict[str, Resource] = {
        "s0": Sampler("linear"),
        "b0": packed(values, BAKE_BUFFER),
        "b2": packed(values, THROUGH_BUFFER),
        "t20": fields(SIDE, *case.fields.values(), *([shown.place] if shown else [])),
    }
    for k, layer in enumerate((*TEXTURES, *IMAGES, "tangent")):
        if layer in case.textures:
            levels = case.textures[layer]
            resources[f"t{k}"] = image(*(level[::-1] if TOP_DOWN in defines else level for level in levels))
    if FIELD in case.textures:  # in place of the rays that leave
        resources["t12"] = image(*case.textures[FIELD])
        del resources["t13"]
    for k, own in enumerate(shown.images.values() if shown else (), len(TEXTURES)):
        resources[f"t{k}"] = image(own.astype(np.float16))

    def with_material(number: int) -> Floats:
        values = material_values(case.sidecar, number, cost)
        if shown:
            values["radtex_images"] = shown.looks[number].rows
        bound = {"b1": packed(values, MATERIAL_BUFFER), "b3": packed(values, IMAGES_BUFFER)}
        return looked_up(root, compiler, source, resources | bound, SIDE)

    return case.by_material(with_material)


def packed(values: Values, layout: Mapping[str, int]) -> Floats:
    return np.array(buffer_of(values, layout), dtype=np.float32)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(
    ("name", "defines"),
    [
        ("everything, in ranges", TOP_DOWN),
        ("made up", ""),
        ("bare", ""),
        ("matt", ""),
        ("one lobe", ""),
        ("glass ball", ""),
        ("room", ""),
        ("brushed", ""),
    ],
)
def test_the_layered_layout_agrees_with_the_reference(
    root: Root, compiler: str, name: str, defines: str
) -> None:
    case = case_of(name)
    assert_agrees(f"{compiler}, {name}", run_layered(root, compiler, defines, case, FULL), case)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(
    ("name", "two_channels"), [("made up", False), ("clear", True), ("everything, in ranges", True)]
)
def test_materials_of_images_agree(root: Root, compiler: str, name: str, two_channels: bool) -> None:
    """Also where light comes through other materials of the bake."""
    shown = image_case(name, two_channels)
    defines = "#define RADTEX_IMAGES\n" + "#define RADTEX_PACKED_BUMP\n" * two_channels
    found = run_layered(root, compiler, defines, shown.case, FULL, shown)
    assert_agrees(f"{compiler}, {name}, by images", found, shown)


def test_thrift_changes_little_of_the_layered_layout(root: Root) -> None:
    case = case_of("everything")
    wrong = off(run_layered(root, "glslang", "", case, DEFAULT), case.answers())
    print(f"as it is by default: mean error {wrong.mean():.1e}")
    assert wrong.mean() < 0.01
    noise = off(run_layered(root, "glslang", "", case, replace(DEFAULT, temporal=True)), case.answers())
    print(f"drawn by chance: mean error {noise.mean():.1e}")
    assert 0.01 < noise.mean() < 0.05


ANY_LIGHT = """
float4 main(float4 at : SV_Position, float3 N : NORMAL, float3 V : TEXCOORD0) : SV_Target {
#ifdef RADTEX_IMAGES
    float3 light = radtex_layered_images(at.xy, at.yx, at.xyz, N.yzx, N.zxy, N, V);
#elif defined(RADTEX_THROUGH)
    float3 light = radtex_layered_through(at.xy, at.xyz, N, V, N.yzx, N.zxy);
#else
    float3 light = radtex_layered(at.xy, at.xyz, N, V);
#endif
    return float4(light, radtex_alpha(at.xy));
}
"""


def test_any_two_parts_of_a_bake_compile_together(root: Root) -> None:
    for defines in variants():
        clear = "RADTEX_THROUGH" in defines and "RADTEX_IMAGES" not in defines
        names = ["radtex_layered", *(["radtex_layered_through"] if clear else [])]
        code = "".join(f'#include "{name}.hlsl"\n' for name in names)
        compiled(root, "glslang", defines + code + ANY_LIGHT)


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


SHADOW_LAYERS = "#define RADTEX_SHADOW_LAYERS\n"
SHADOW = """
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
    [
        (5, ""),
        (8, ""),
        (8, TOP_DOWN),
        (8, SHADOW_LAYERS),
        (12, SHADOW_LAYERS),
        (12, SHADOW_LAYERS + TOP_DOWN),
    ],
)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_shadows_agree_with_the_reference(root: Root, compiler: str, cells: int, defines: str) -> None:
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
        "t0": image(bits if SHADOW_LAYERS in defines else bits[0]),
        "t1": fields(2 * SIDE, places, *vectors),
        "b0": np.frombuffer(facts, np.uint8),
    }
    answers = np.split(looked_up(root, compiler, defines + SHADOW, resources, 2 * SIDE)[:, 0], 4)
    for mode, found in zip(modes[:3], answers, strict=False):
        wanted = expected(words, layout, lookups, mode, SHADOW_LAYERS in defines)
        check(found, wanted, mode, SHADOW_LAYERS in defines, f"{compiler}, {cells} cells, {defines!r}")
