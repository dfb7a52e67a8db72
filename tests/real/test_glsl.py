# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex.glsl on a real OpenGL, over EGL, against the reference sampler."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import Filter
from tests.lookups import (
    LAYOUT,
    SIDE,
    Lookups,
    constant_buckets,
    random_atlas,
    random_lookups,
    worst_error,
)
from tests.real.opengl import VERSIONS, compiled, drawn

SHADER = Path(__file__).parents[2] / "shaders" / "radtex.glsl"
FRAGMENT = """
uniform sampler2D atlas, uvs, normals, tangents, viewers;
uniform ivec2 texels;
uniform int n, mode;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, here, 0), tangent = texelFetch(tangents, here, 0);
    vec3 I = radtex_incidence(texelFetch(viewers, here, 0).xyz, normal.xyz, tangent.xyz, normal.w);
    result = radtex_sample(atlas, texels, n, texelFetch(uvs, here, 0).xy, I, mode);
}
"""


def run(
    context: moderngl.Context, version: str, atlas: Floats, lookups: Lookups, kind: Filter, defines: str = ""
) -> Floats:
    """The shader's answers, (K, 4) float32."""
    program = compiled(context, VERSIONS[version] + defines, SHADER.read_text(encoding="utf-8") + FRAGMENT)
    program["texels"], program["n"] = (LAYOUT.width, LAYOUT.height), LAYOUT.bucket
    program["mode"] = list(Filter).index(kind)
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    inputs = {"uvs": lookups.uv, "normals": signed, "tangents": lookups.tangent, "viewers": lookups.viewer}
    fields = {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}
    return drawn(context, program, {"atlas": atlas} | fields, SIDE)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", list(Filter))
def test_glsl_agrees_with_the_reference(context: moderngl.Context, version: str, kind: Filter) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    worst, across = worst_error(run(context, version, atlas, lookups, kind), atlas, lookups, kind)
    print(f"{version} {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
    assert worst <= 2e-3
    assert across <= 2e-3


@pytest.mark.parametrize(("defines", "rounding"), [("", 1e-7), ("#define RADTEX_HARDWARE_LINEAR\n", 5e-4)])
def test_buckets_do_not_bleed(context: moderngl.Context, defines: str, rounding: float) -> None:
    atlas, lookups = constant_buckets(), random_lookups()
    result = run(context, "GLSL 330", atlas, lookups, Filter.LINEAR, defines)
    assert worst_error(result, atlas, lookups, Filter.LINEAR)[0] <= rounding


@pytest.mark.parametrize("kind", [Filter.LINEAR, Filter.QUADRILINEAR])
def test_one_hardware_lookup_is_as_good_as_its_weights(context: moderngl.Context, kind: Filter) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    result = run(context, "GLSL 330", atlas, lookups, kind, "#define RADTEX_HARDWARE_LINEAR\n")
    exact = run(context, "GLSL 330", atlas, lookups, kind)
    range_of_colours = float(atlas.max())
    np.testing.assert_allclose(result, exact, rtol=0, atol=range_of_colours * 2 / 256)
