# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex.glsl on a real OpenGL, over EGL, against the references: filters, pages, levels."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.pages import fitting_pages
from radtex_addon.core.sampler import Filter
from tests.lookups import (
    COUNT,
    LAYOUT,
    SIDE,
    Lookups,
    constant_buckets,
    hit_answers,
    random_atlas,
    random_lookups,
    relative_error,
    worst_error,
)
from tests.real.opengl import VERSIONS, compiled, drawn, mipmapped
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import page_chain

SHADER = Path(__file__).parents[2] / "shaders" / "radtex.glsl"
WORST = 2e-3
LEVELS = 4  # 13 x 7 texels are stored as 16 x 8, and the last level as 2 x 1
PAGED, HARDWARE = "#define RADTEX_PAGES\n", "#define RADTEX_HARDWARE_LINEAR\n"
WAYS = {"one texture": "", "pages": PAGED}
FRAGMENT = """
#ifdef RADTEX_PAGES
uniform highp sampler2DArray atlas;
uniform ivec4 pages;
#else
uniform sampler2D atlas;
#endif
uniform sampler2D uvs, normals, tangents, viewers;
uniform ivec2 texels;
uniform int n, mode;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, here, 0), tangent = texelFetch(tangents, here, 0);
    vec3 viewer = texelFetch(viewers, here, 0).xyz;
    vec3 I = radtex_incidence(viewer, normal.xyz, tangent.xyz, normal.w);
    vec3 uv = texelFetch(uvs, here, 0).xyz;  // and the level
    if (mode < 3) result = radtex_sample(RADTEX_PASSED, texels, n, uv.xy, I, mode);
    else if (mode == 3) result = radtex_sample_level(RADTEX_PASSED, texels, n, uv.xy, I, uv.z);
    else result = radtex_hit(RADTEX_PASSED, texels, n, uv.xy, -viewer, normal.xyz, tangent.xyz, normal.w,
                             RADTEX_QUADRILINEAR);
}
"""
BY_LEVEL, BY_RAY = 3, 4  # the shader's modes, after the filters


def run(
    context: moderngl.Context, head: str, atlas: Floats, lookups: Lookups, mode: int, level: Floats
) -> Floats:
    """The shader's answers, (K, 4) float32; `head` is a version and defines, `level` (K,)."""
    program = compiled(context, head, SHADER.read_text(encoding="utf-8") + FRAGMENT)
    program["texels"], program["n"], program["mode"] = (LAYOUT.width, LAYOUT.height), LAYOUT.bucket, mode
    if PAGED in head:
        pages = fitting_pages(LAYOUT, 50, LEVELS)
        program["pages"] = (pages.columns, pages.rows, pages.width, pages.height)
        chain = page_chain(atlas, LAYOUT, pages, LEVELS)
    else:
        chain = level_chain(atlas, LAYOUT, LEVELS)
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    places = np.concatenate([lookups.uv, level[:, None]], axis=1).astype(np.float32)
    inputs = {"uvs": places, "normals": signed, "tangents": lookups.tangent, "viewers": lookups.viewer}
    fields = {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}
    sampled = moderngl.LINEAR_MIPMAP_NEAREST if HARDWARE in head else moderngl.NEAREST
    stored = mipmapped(context, [image.astype(np.float16) for image in chain], sampled)
    return drawn(context, program, {"atlas": stored, **fields}, SIDE)


def filtered(context: moderngl.Context, head: str, atlas: Floats, lookups: Lookups, kind: Filter) -> Floats:
    return run(context, head, atlas, lookups, list(Filter).index(kind), np.zeros(COUNT))


def random_levels(seed: int = 5) -> Floats:
    """Levels (K,) float32, many of them whole, one for 2 x 2 pixels: Mesa reads no more."""
    level = np.random.default_rng(seed).uniform(0, LEVELS - 1, (SIDE // 2, SIDE // 2))
    level[::3] = np.round(level[::3])
    return np.kron(level, np.ones((2, 2))).ravel().astype(np.float32)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", list(Filter))
def test_glsl_agrees_with_the_reference(
    context: moderngl.Context, version: str, kind: Filter, way: str
) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    result = filtered(context, VERSIONS[version] + WAYS[way], atlas, lookups, kind)
    worst, across = worst_error(result, atlas, lookups, kind)
    print(f"{version} {kind}, {way}: worst error {worst:.1e}, across an edge {across:.2%}")
    assert worst <= WORST
    assert across <= 2e-3


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
def test_levels_agree_with_the_reference(context: moderngl.Context, version: str, way: str) -> None:
    atlas, lookups, level = random_atlas(), random_lookups(), random_levels()
    result = run(context, VERSIONS[version] + WAYS[way], atlas, lookups, BY_LEVEL, level)
    chain = [image.astype(np.float16).astype(float) for image in level_chain(atlas, LAYOUT, LEVELS)]
    expected = sample_level(chain, LAYOUT, lookups.uv.astype(float), lookups.incidence, level.astype(float))
    worst = float(relative_error(result, expected).max())
    print(f"{version} levels, {way}: worst error {worst:.1e}")
    assert worst <= WORST


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
def test_rays_find_what_the_reference_does(context: moderngl.Context, version: str, way: str) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    result = run(context, VERSIONS[version] + WAYS[way], atlas, lookups, BY_RAY, np.zeros(COUNT))
    error = relative_error(result, hit_answers(atlas, lookups))
    print(f"{version} rays, {way}: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST


@pytest.mark.parametrize(("defines", "rounding"), [("", 1e-7), (HARDWARE, 5e-4), (HARDWARE + PAGED, 5e-4)])
def test_buckets_do_not_bleed(context: moderngl.Context, defines: str, rounding: float) -> None:
    atlas, lookups = constant_buckets(), random_lookups()
    result = filtered(context, VERSIONS["GLSL 330"] + defines, atlas, lookups, Filter.LINEAR)
    assert worst_error(result, atlas, lookups, Filter.LINEAR)[0] <= rounding


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mode", [1, 2, BY_LEVEL])
def test_one_hardware_lookup_is_as_good_as_its_weights(
    context: moderngl.Context, mode: int, way: str
) -> None:
    atlas, lookups, level = random_atlas(), random_lookups(), random_levels()
    head = VERSIONS["GLSL 330"] + WAYS[way]
    result = run(context, head + HARDWARE, atlas, lookups, mode, level)
    exact = run(context, head, atlas, lookups, mode, level)
    range_of_colours = float(atlas.max())
    np.testing.assert_allclose(result, exact, rtol=0, atol=range_of_colours * 2 / 256)
