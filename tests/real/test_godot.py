# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.gdshaderinc in a real Godot, by both its kinds of renderers, against the references."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from radtex_addon.core.arrangements import fitting_pages, to_slices
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.shadow_files import Words
from radtex_addon.forms.layered.shader_values import (
    DEFAULT,
    FULL,
    LookupCost,
    bake_values,
    definitions,
    layers_read,
    material_values,
)
from tests.layered_lookups import USUAL, Case, assert_agrees, case_of, off
from tests.lookups import (
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
from tests.real.godot import RENDERERS, Image, Job, answers
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
from tests.real.test_glsl import uvs_of_quads
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import page_chain
from tests.reference.slices import mip_chain, sample_slices

WORST = 2e-3
LEVELS = 4  # 13 x 7 texels are stored as 16 x 8, and the last level as 2 x 1
PAGES = fitting_pages(LAYOUT, 50, LEVELS)
PAGED = "#define RADTEX_PAGES\n"
HEAD = f"""
#ifdef RADTEX_PAGES
#define ATLAS atlas, ivec4({PAGES.columns}, {PAGES.rows}, {PAGES.width}, {PAGES.height})
#else
#define ATLAS atlas
#endif
const ivec2 texels = ivec2({LAYOUT.width}, {LAYOUT.height});
const int n = {LAYOUT.bucket};
vec3 incidence(ivec2 here) {{
    vec4 normal = texelFetch(normals, here, 0);
    vec3 tangent = texelFetch(tangents, here, 0).xyz;
    return radtex_incidence(texelFetch(viewers, here, 0).xyz, normal.xyz, tangent, normal.w);
}}
"""
BY_FILTER = """
vec4 answer(ivec2 here) {
    return radtex_sample(ATLAS, texels, n, texelFetch(uvs, here, 0).xy, incidence(here), %d);
}
"""
BY_LEVEL = """
vec4 answer(ivec2 here) {
    vec3 uv = texelFetch(uvs, here, 0).xyz;  // and the level
    return radtex_sample_level(ATLAS, texels, n, uv.xy, incidence(here), uv.z);
}
"""
OF_SLICES = (
    "vec4 answer(ivec2 h) { return radtex_slices(slices, n, texelFetch(uvs, h, 0).xy, incidence(h)); }"
)
BY_RAY = """
vec4 answer(ivec2 here) {
    vec4 normal = texelFetch(normals, here, 0);
    vec3 tangent = texelFetch(tangents, here, 0).xyz, ray = -texelFetch(viewers, here, 0).xyz;
    vec2 uv = texelFetch(uvs, here, 0).xy;
    return radtex_hit(ATLAS, texels, n, uv, ray, normal.xyz, tangent, normal.w, RADTEX_QUADRILINEAR);
}
"""
THE_LEVEL = "vec4 answer(ivec2 h) { return vec4(radtex_level(texelFetch(uvs, h, 0).xy, texels, 4)); }"


def fields(lookups: Lookups, level: Floats | None = None) -> dict[str, Floats]:
    """The lookups as textures."""
    inputs = {"normals": np.column_stack([lookups.normal, lookups.sign]), "tangents": lookups.tangent}
    places = lookups.uv if level is None else np.column_stack([lookups.uv, level]).astype(np.float32)
    inputs |= {"uvs": places, "viewers": lookups.viewer}
    return {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}


def halves(chain: Iterable[Floats]) -> list[Floats]:
    return [image.astype(np.float16) for image in chain]


@pytest.mark.parametrize("renderer", RENDERERS)
def test_filters_agree_with_the_reference(root: Root, renderer: str) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    paged = page_chain(atlas, LAYOUT, PAGES, 1)[0].astype(np.float16)
    ways = [(kind, form) for kind in Filter for form in ("one image", "pages")]
    jobs = [
        Job(
            HEAD + BY_FILTER % list(Filter).index(kind),
            {"atlas": paged if form == "pages" else atlas} | fields(lookups),
            defines=PAGED if form == "pages" else "",
        )
        for kind, form in ways
    ]
    for (kind, form), result in zip(ways, answers(root, renderer, jobs), strict=True):
        worst, across = worst_error(result, atlas, lookups, kind)
        print(f"{renderer} {kind}, {form}: worst error {worst:.1e}, across an edge {across:.2%}")
        assert worst <= WORST
        assert across <= 2e-3


@pytest.mark.parametrize("renderer", RENDERERS)
def test_buckets_do_not_bleed_when_the_hardware_blends_them(root: Root, renderer: str) -> None:
    atlas, lookups = constant_buckets(), random_lookups()
    job = Job(
        HEAD + BY_FILTER % list(Filter).index(Filter.LINEAR),
        {"atlas": atlas} | fields(lookups),
        defines="#define RADTEX_HARDWARE_LINEAR\n",
        hints={"atlas": "filter_linear"},
    )
    (result,) = answers(root, renderer, [job])
    assert worst_error(result, atlas, lookups, Filter.LINEAR)[0] <= 5e-4


@pytest.mark.parametrize("renderer", RENDERERS)
def test_levels_agree_with_the_reference(root: Root, renderer: str) -> None:
    lookups, chain = random_lookups(), level_chain(random_atlas(), LAYOUT, LEVELS)
    level = np.random.default_rng(5).uniform(0, LEVELS - 1, (SIDE // 2, SIDE // 2))
    level[::3] = np.round(level[::3])
    level = np.kron(level, np.ones((2, 2))).ravel().astype(np.float32)  # Mesa reads one for 2 x 2 pixels
    paged = page_chain(random_atlas(), LAYOUT, PAGES, LEVELS)
    hints = {"atlas": "filter_nearest_mipmap"}  # without it the Compatibility renderer has level 0 only
    jobs = [
        Job(HEAD + BY_LEVEL, {**fields(lookups, level), "atlas": halves(images)}, ("radtex",), defines, hints)
        for images, defines in ((chain, ""), (paged, PAGED))
    ]
    exact = [image.astype(float) for image in halves(chain)]
    expected = sample_level(exact, LAYOUT, lookups.uv.astype(float), lookups.incidence, level.astype(float))
    for form, result in zip(("one image", "pages"), answers(root, renderer, jobs), strict=True):
        worst = float(relative_error(result, expected).max())
        print(f"{renderer} levels, {form}: worst error {worst:.1e}")
        assert worst <= WORST


@pytest.mark.parametrize("renderer", RENDERERS)
def test_rays_find_what_the_reference_does(root: Root, renderer: str) -> None:
    """In the texture itself, and in pages."""
    atlas, lookups = random_atlas(), random_lookups()
    paged = page_chain(atlas, LAYOUT, PAGES, 1)[0].astype(np.float16)
    jobs = [
        Job(HEAD + BY_RAY, {"atlas": atlas} | fields(lookups)),
        Job(HEAD + BY_RAY, {"atlas": paged} | fields(lookups), defines=PAGED),
    ]
    error = relative_error(np.stack(answers(root, renderer, jobs)), hit_answers(atlas, lookups))
    print(f"{renderer} rays: worst error {error.max():.1e}")
    assert error.max() <= WORST


@pytest.mark.parametrize("renderer", RENDERERS)
def test_what_the_hardware_does_agrees_with_the_reference(root: Root, renderer: str) -> None:
    """Slices, at whole levels, as drivers measure pixels in their own ways; and the level of a matrix."""
    chain, lookups = halves(mip_chain(to_slices(random_atlas(), LAYOUT))), random_lookups()
    uv, level = uvs_of_quads(axis=True, whole=True)
    turned, turned_level = uvs_of_quads(axis=False, whole=False)
    jobs = [
        Job(
            HEAD + OF_SLICES,
            {**fields(lookups), "slices": chain, "uvs": uv},
            hints={"slices": "filter_linear_mipmap, repeat_disable"},
        ),
        Job(HEAD + THE_LEVEL, fields(lookups) | {"uvs": turned}),
    ]
    result, found = answers(root, renderer, jobs)
    exact = [values.astype(float) for values in chain]
    expected = sample_slices(exact, uv.reshape(-1, 2).astype(float), lookups.incidence, level.ravel())
    error = relative_error(result, expected)
    print(f"{renderer} slices: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST
    np.testing.assert_allclose(found[:, 0], np.minimum(turned_level, 3).ravel(), atol=1e-4)


LAYERED = """
vec4 answer(ivec2 here) {
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 position = texelFetch(positions, here, 0).xyz;
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
#ifdef RADTEX_THROUGH
    vec3 T = texelFetch(tangents, here, 0).xyz, B = texelFetch(bitangents, here, 0).xyz;
    return vec4(radtex_layered_through(uv, position, N, V, T, B), 1.0);
#else
    return vec4(radtex_layered(uv, position, N, V), 1.0);
#endif
}
"""


def layered_jobs(case: Case, cost: LookupCost) -> list[Job]:
    """A picture of each material."""
    defines = "".join(f"#define {name} {value}\n" for name, value in definitions(case.sidecar, cost).items())
    includes = ("radtex_layered", *(["radtex_layered_through"] if case.through else []))
    textures: dict[str, Image] = {
        f"radtex_{layer}_map": _levels(case.textures[layer]) for layer in layers_read(case.sidecar, cost)
    }
    textures |= {name: values.reshape(SIDE, SIDE, -1) for name, values in case.fields.items()}
    values = bake_values(case.sidecar, case.stored, cost)
    return [
        Job(
            LAYERED,
            textures,
            includes,
            defines,
            values=values | material_values(case.sidecar, number, cost),
            declared="radtex_",
        )
        for number in range(len(case.sidecar.materials))
    ]


def _levels(levels: list[Floats]) -> Image:
    return levels if len(levels) > 1 else levels[0]


@pytest.mark.parametrize("renderer", RENDERERS)
def test_the_layered_layout_agrees_with_the_reference(root: Root, renderer: str) -> None:
    asked = {name: layered_jobs(case_of(name), FULL) for name in USUAL}
    drawn = iter(answers(root, renderer, [job for some in asked.values() for job in some]))
    for name, some in asked.items():
        by_material = [next(drawn) for _ in some]
        case = case_of(name)
        assert_agrees(f"{renderer}, {name}", case.by_material(by_material.__getitem__), case)


@pytest.mark.parametrize("renderer", RENDERERS)
def test_what_chance_draws_is_near(root: Root, renderer: str) -> None:
    case = case_of("everything")
    by_material = answers(root, renderer, layered_jobs(case, replace(DEFAULT, temporal=True)))
    noise = off(case.by_material(by_material.__getitem__), case.answers())
    print(f"{renderer}, drawn by chance: mean error {noise.mean():.1e}")
    assert 0.01 < noise.mean() < 0.05


LAYERS = "#define RADTEX_SHADOW_LAYERS\n"
SHADOW = """
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


def stored_words(words: Words, *, layered: bool) -> Floats:
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
def test_shadows_agree_with_the_reference(root: Root, renderer: str) -> None:
    lookups, jobs = random_lookups(), []
    for mode, (cells, layered) in CASES:
        layout = AtlasLayout(13, 7, cells)
        code = SHADOW % (layout.width, layout.height, CALLS[mode].format(n=cells))
        textures = {"words": stored_words(random_words(layout), layered=layered), **fields(lookups)}
        includes = ("radtex", "radtex_shadow")
        jobs.append(Job(code, textures, includes, LAYERS * layered, {"words": "filter_nearest"}))
    for (mode, (cells, layered)), result in zip(CASES, answers(root, renderer, jobs), strict=True):
        layout = AtlasLayout(13, 7, cells)
        wanted = expected(random_words(layout), layout, lookups, mode, layered)
        check(result[:, 0], wanted, mode, layered, f"{renderer}, {cells} cells")
