# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shared.hlsl and radtex_condensed.hlsl, through SPIR-V on a real Vulkan."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas
from radtex_addon.core.frame import normalised
from radtex_addon.core.shared import SharedAtlas
from radtex_addon.formats.packing import pack
from tests.condensed_textures import COLUMNS, Ranges, doubts, uncompressed
from tests.lookups import SIDE, Lookups, relative_error
from tests.real.hlsl import COMPILERS, looked_up
from tests.real.root import Root
from tests.real.webgpu import Resource, Sampler, fields, image
from tests.shared_atlases import random_condensed_atlas, random_shared_atlas
from tests.shared_lookups import by_ray, random_fragments, shared_answers, shared_hit_answers

WIDTH, HEIGHT = 7, 5
WORST = 2e-3  # as far off as radtex_shared.glsl may be
HARDWARE, TOP_DOWN = "#define RADTEX_HARDWARE_LINEAR filtering\n", "#define RADTEX_TOP_DOWN\n"
LIGHT = ["colour", "irradiance", "surroundings"]
SHARED = [*LIGHT, *(f"{lobe}_{part}" for lobe in ("mirror", "through") for part in ("ends", "gain", "rest"))]
PARTS = ("weights", "ends_xy", "ends_zs", "gain", "rest")
CONDENSED = [*LIGHT, *(f"{lobe}_{part}" for lobe in ("mirror", "through") for part in PARTS)]
SHADER = """
SamplerState filtering : register(s0);
#include "radtex_%s.hlsl"
Texture2D %s;
Texture2DArray fields : register(t0);
cbuffer Facts : register(b0) { int4 sizes; int4 facts; }  // fine, texels; around, columns, n
cbuffer Light : register(b1) { float3 falloff[RADTEX_FALLOFF]; }
cbuffer Ranges : register(b2) { float4 mirror_ranges[12]; float4 through_ranges[12]; }
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy), fine = sizes.xy, texels = sizes.zw, around = facts.xy;
    int columns = facts.z, n = facts.w;
    float2 uv = fields.Load(int4(here, 0, 0)).xy;
    float3 N = fields.Load(int4(here, 1, 0)).xyz, V = fields.Load(int4(here, 2, 0)).xyz;
    return float4(%s, 1.0);
}
"""
SHARED_LOOKUP = """radtex_shared(colour, irradiance, falloff, mirror_ends, mirror_gain, mirror_rest,
        through_ends, through_gain, through_rest, n, surroundings, around, uv, N, V)"""
CONDENSED_LOOKUP = """radtex_condensed(colour, fine, irradiance, texels, falloff,
        mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
        through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest, through_ranges,
        columns, n, surroundings, around, uv, N, V)"""


def run(
    root: Root,
    compiler: str,
    defines: str,
    atlas: SharedAtlas | CondensedAtlas,
    images: Mapping[str, Floats],
    fragments: Lookups,
    ranges: Ranges | None = None,
    traced: bool = False,
) -> Floats:
    """The shader's answers, (K, 3) float32, by rays if `traced`; `ranges`: each condensed lobe's (12, 4)."""
    condensed = isinstance(atlas, CondensedAtlas)
    names, lookup = (CONDENSED, CONDENSED_LOOKUP) if condensed else (SHARED, SHARED_LOOKUP)
    lookup = by_ray(lookup) if traced else lookup
    declared = ", ".join(f"{name} : register(t{1 + k})" for k, name in enumerate(names))
    source = SHADER % ("condensed" if condensed else "shared", declared, lookup)
    normal, viewer = (normalised(vectors) for vectors in (fragments.normal, fragments.viewer))
    around = [len(atlas.surroundings[0]), len(atlas.surroundings)]
    sizes = [*atlas.colour.shape[1::-1], *atlas.irradiance.shape[1::-1]]
    resources: dict[str, Resource] = {
        "b0": np.array([*sizes, *around, COLUMNS, atlas.lobes[0].ends.shape[-2]], np.int32),
        "b1": np.pad(atlas.falloff, ((0, 0), (0, 1))),
        "s0": Sampler("linear"),
        "t0": fields(SIDE, fragments.uv, normal, viewer),
    }
    if ranges is not None:
        resources["b2"] = np.concatenate([ranges[lobe.axis] for lobe in atlas.lobes])
    for k, name in enumerate(names):
        resources[f"t{1 + k}"] = image(images[name][::-1] if TOP_DOWN in defines else images[name])
    return looked_up(root, compiler, defines + source, resources, SIDE)[:, :3]


@pytest.mark.parametrize(
    ("bucket", "surroundings", "levels", "defines"),
    [(6, 48, 5, TOP_DOWN), (1, 8, 1, ""), (3, 50, 2, ""), (8, 192, 6, "")],
)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_shared_layout_agrees_with_the_reference(
    root: Root, compiler: str, bucket: int, surroundings: int, levels: int, defines: str
) -> None:
    atlas = random_shared_atlas(WIDTH, HEIGHT, bucket=bucket, surroundings=surroundings, levels=levels)
    fragments = random_fragments(WIDTH, HEIGHT)
    result = run(root, compiler, defines, atlas, pack(atlas), fragments)
    error = relative_error(result, shared_answers(atlas, fragments))
    print(f"{compiler}, n {bucket}, {levels} levels from {surroundings}: worst error {error.max():.1e}")
    assert np.median(error) <= 5e-6
    assert np.quantile(error, 0.999) <= 5e-5
    assert error.max() <= WORST


@pytest.mark.parametrize(
    ("clusters", "rank", "bucket", "defines"),
    [(4, 2, 14, ""), (1, 2, 2, ""), (9, 6, 6, TOP_DOWN), (1000, 2, 2, "")],
)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_condensed_form_agrees_with_the_reference(
    root: Root, compiler: str, clusters: int, rank: int, bucket: int, defines: str
) -> None:
    atlas = random_condensed_atlas(WIDTH, HEIGHT, clusters, rank, bucket)
    fragments = random_fragments(WIDTH, HEIGHT)
    images, ranges = uncompressed(atlas)
    defines += f"#define RADTEX_RANK {rank}\n"
    error = relative_error(
        run(root, compiler, defines, atlas, images, fragments, ranges),
        shared_answers(atlas.expanded(), fragments),
    )
    doubt = doubts(atlas, fragments)
    sure = doubt <= WORST
    print(
        f"{compiler}, {clusters} clusters of rank {rank}, n {bucket}: worst error {error[sure].max():.1e};"
        f" at {np.sum(~sure)} lookups that rounding moves further than {WORST}, {error.max():.1e}"
    )
    assert np.median(error) <= 5e-6
    assert np.quantile(error, 0.99) <= 1e-4
    assert (error <= np.maximum(doubt, WORST)).all()
    assert np.mean(sure) >= 0.99


@pytest.mark.parametrize("compiler", COMPILERS)
def test_rays_find_what_the_reference_does(root: Root, compiler: str) -> None:
    fragments, shared = random_fragments(WIDTH, HEIGHT), random_shared_atlas(WIDTH, HEIGHT)
    result = run(root, compiler, "", shared, pack(shared), fragments, traced=True)
    error = relative_error(result, shared_hit_answers(shared, fragments))
    condensed = random_condensed_atlas(WIDTH, HEIGHT)
    images, ranges = uncompressed(condensed)
    result = run(root, compiler, "", condensed, images, fragments, ranges, traced=True)
    worse = relative_error(result, shared_hit_answers(condensed.expanded(), fragments))
    print(f"{compiler}, rays: worst error {error.max():.1e}, condensed {worse.max():.1e}")
    for found in (error, worse):
        assert np.median(found) <= 5e-6
        assert np.quantile(found, 0.99) <= 1e-4
    assert error.max() <= WORST
    assert (worse <= np.maximum(doubts(condensed, fragments), WORST)).all()


@pytest.mark.parametrize(("compiler", "defines"), [("glslang", HARDWARE), ("vkd3d", HARDWARE + TOP_DOWN)])
def test_one_hardware_lookup_is_as_good_as_its_weights(root: Root, compiler: str, defines: str) -> None:
    atlas, fragments = random_shared_atlas(WIDTH, HEIGHT), random_fragments(WIDTH, HEIGHT)
    result = run(root, compiler, defines, atlas, pack(atlas), fragments)
    error = relative_error(result, shared_answers(atlas, fragments))
    print(f"{compiler}, hardware: median error {np.median(error):.1e}, worst {error.max():.1e}")
    assert np.median(error) <= 5e-3
    assert np.quantile(error, 0.99) <= 5e-2
