# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.gdshaderinc in a real Godot, by both its kinds of renderers, against the references."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.pages import fitting_pages
from radtex_addon.core.sampler import Filter
from radtex_addon.core.slices import to_slices
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
from tests.real.godot import RENDERERS, Job, answers
from tests.real.root import Root
from tests.real.test_glsl_derivatives import uvs_of_quads
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import page_chain
from tests.reference.slices import mip_chain, sample_slices

WORST = 2e-3
LEVELS = 4  # 13 x 7 texels are stored as 16 x 8, and the last level as 2 x 1
PAGES = fitting_pages(LAYOUT, 50, LEVELS)
PAGED = "#define RADTEX_PAGES\n"
ONE = f"""
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
            ONE + BY_FILTER % list(Filter).index(kind),
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
        ONE + BY_FILTER % list(Filter).index(Filter.LINEAR),
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
        Job(ONE + BY_LEVEL, {**fields(lookups, level), "atlas": halves(images)}, ("radtex",), defines, hints)
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
        Job(ONE + BY_RAY, {"atlas": atlas} | fields(lookups)),
        Job(ONE + BY_RAY, {"atlas": paged} | fields(lookups), defines=PAGED),
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
            ONE + OF_SLICES,
            {**fields(lookups), "slices": chain, "uvs": uv},
            hints={"slices": "filter_linear_mipmap, repeat_disable"},
        ),
        Job(ONE + THE_LEVEL, fields(lookups) | {"uvs": turned}),
    ]
    result, found = answers(root, renderer, jobs)
    exact = [values.astype(float) for values in chain]
    expected = sample_slices(exact, uv.reshape(-1, 2).astype(float), lookups.incidence, level.ravel())
    error = relative_error(result, expected)
    print(f"{renderer} slices: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST
    np.testing.assert_allclose(found[:, 0], np.minimum(turned_level, 3).ravel(), atol=1e-4)
