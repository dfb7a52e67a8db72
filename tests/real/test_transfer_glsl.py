# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_transfer.glsl on a real OpenGL, over EGL, against the reference: suns and point lights."""

from __future__ import annotations

from dataclasses import astuple, replace
from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.pages import fitting_pages
from radtex_addon.core.transfer import with_views
from tests.lookups import COUNT, LAYOUT, SIDE, random_lookups, relative_error
from tests.real.opengl import VERSIONS, compiled, drawn, mipmapped
from tests.reference.pages import page_chain
from tests.transfer_lookups import VIEWS, WORST, Question, Way, questions, random_lights

SHADERS = Path(__file__).parents[2] / "shaders"
PAGED = "#define RADTEX_PAGES\n"
FRAGMENT = """
#ifdef RADTEX_PAGES
uniform sampler2DArray atlas;
uniform ivec4 pages;
#else
uniform sampler2D atlas;
#endif
uniform sampler2D uvs, normals, tangents, viewers, lights;
uniform ivec2 texels;
uniform int n, mode, views;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, here, 0);
    vec4 tangent = vec4(texelFetch(tangents, here, 0).xyz, normal.w);
    vec3 light = texelFetch(lights, here, 0).xyz, E = vec3(2.0, 1.0, 0.5);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 L = radtex_incidence(light, normal.xyz, tangent.xyz, tangent.w);
    vec3 I = radtex_incidence(texelFetch(viewers, here, 0).xyz, normal.xyz, tangent.xyz, tangent.w);
    result = vec4(1.0);
    if (mode == 0) result = radtex_transfer(RADTEX_PASSED, texels, n, uv, L);
    if (mode == 1) result.rgb = radtex_sun(RADTEX_PASSED, texels, n, uv, normal.xyz, tangent, light, E);
    if (mode == 2)
        result.rgb = radtex_point_light(RADTEX_PASSED, texels, n, uv, normal.xyz, tangent, light, E);
    if (mode == 3) result = radtex_transfer_around(RADTEX_PASSED, texels, views, n, uv, I, L);
}
"""


def run(context: moderngl.Context, head: str, question: Question, paged: bool = False) -> Floats:
    """The shader's answers, (K, 4) float32."""
    source = "".join((SHADERS / name).read_text("utf-8") for name in ("radtex.glsl", "radtex_transfer.glsl"))
    program = compiled(context, head, (PAGED if paged else "") + source + FRAGMENT)
    program["texels"], program["n"], program["mode"] = (
        (LAYOUT.width, LAYOUT.height),
        LAYOUT.bucket,
        question.way,
    )
    program["views"] = question.views
    lookups = question.lookups
    inputs = {
        "uvs": lookups.uv,
        "normals": np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1),
        "tangents": lookups.tangent,
        "viewers": lookups.viewer,
        "lights": question.light,
    }
    fields = {name: values.reshape(SIDE, SIDE, -1).astype(np.float32) for name, values in inputs.items()}
    levels = [question.atlas]
    if paged:
        stored = with_views(LAYOUT, question.views)
        pages = fitting_pages(stored, 60, 1)
        program["pages"] = astuple(pages)
        levels = page_chain(question.atlas, stored, pages, 1)
    return drawn(context, program, {"atlas": mipmapped(context, levels, moderngl.NEAREST), **fields}, SIDE)


@pytest.mark.parametrize("paged", [False, True])
@pytest.mark.parametrize("version", VERSIONS)
def test_glsl_agrees_with_the_reference(context: moderngl.Context, version: str, paged: bool) -> None:
    for question in questions():
        result = run(context, VERSIONS[version], question, paged)
        worst = float(relative_error(result, question.answers).max())
        print(f"{version}, {question.way.name}: worst error of {COUNT} lookups {worst:.1e}")
        assert worst <= WORST


def test_cells_do_not_bleed_into_other_texels(context: moderngl.Context) -> None:
    """Texels that are constants stay so at their middles, from every direction."""
    random, lookups = np.random.default_rng(4), random_lookups()
    value = random.random((LAYOUT.height, LAYOUT.width, 4)).astype(np.float16).astype(float)
    atlas = np.kron(value.transpose(2, 0, 1), np.ones((LAYOUT.bucket, LAYOUT.bucket))).transpose(1, 2, 0)
    i, j = random.integers(LAYOUT.width, size=COUNT), random.integers(LAYOUT.height, size=COUNT)
    lookups.uv[:] = np.stack([(i + 0.5) / LAYOUT.width, (j + 0.5) / LAYOUT.height], axis=1)
    asked = Question(Way.LOOKUP, atlas.astype(np.float16), lookups, random_lights())
    result = run(context, VERSIONS["GLSL 330"], asked)
    np.testing.assert_allclose(result, value[j, i], atol=1e-5)
    alike = LAYOUT.to_buckets(asked.atlas.astype(float)).repeat(VIEWS, axis=0).repeat(VIEWS, axis=1)
    atlas = with_views(LAYOUT, VIEWS).from_buckets(alike).astype(np.float16)
    result = run(context, VERSIONS["GLSL 330"], replace(asked, way=Way.AROUND, atlas=atlas))
    np.testing.assert_allclose(result, value[j, i], atol=1e-5)
