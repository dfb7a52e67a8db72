# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_transfer.glsl on a real OpenGL, over EGL, against the reference: suns and point lights."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import orthonormal_frame, to_frame
from radtex_addon.core.transfer import relight, sample_transfer
from tests.lookups import COUNT, LAYOUT, SIDE, Lookups, random_atlas, random_lookups, relative_error
from tests.real.opengl import VERSIONS, compiled, drawn, mipmapped

SHADERS = Path(__file__).parents[2] / "shaders"
WORST = 2e-3
IRRADIANCE = (2.0, 1.0, 0.5)
FRAGMENT = """
uniform sampler2D atlas, uvs, normals, tangents, lights;
uniform ivec2 texels;
uniform int n, mode;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, here, 0);
    vec4 tangent = vec4(texelFetch(tangents, here, 0).xyz, normal.w);
    vec3 light = texelFetch(lights, here, 0).xyz, power = vec3(2.0, 1.0, 0.5);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    if (mode == 0) {
        vec3 L = radtex_incidence(light, normal.xyz, tangent.xyz, tangent.w);
        result = radtex_transfer(atlas, texels, n, uv, L);
    } else if (mode == 1) {
        result = vec4(radtex_sun(atlas, texels, n, uv, normal.xyz, tangent, light, power), 1.0);
    } else {
        result = vec4(radtex_point_light(atlas, texels, n, uv, normal.xyz, tangent, light, power), 1.0);
    }
}
"""


def lights(seed: int = 8) -> Floats:
    """To lights all around, (K, 3) float32, of lengths from 0.5 to 3."""
    random = np.random.default_rng(seed)
    away = random.normal(size=(COUNT, 3))
    away *= random.uniform(0.5, 3, (COUNT, 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    return away.astype(np.float32)


def run(
    context: moderngl.Context, head: str, atlas: Floats, lookups: Lookups, light: Floats, mode: int
) -> Floats:
    """The shader's answers, (K, 4) float32."""
    source = "".join((SHADERS / name).read_text("utf-8") for name in ("radtex.glsl", "radtex_transfer.glsl"))
    program = compiled(context, head, source + FRAGMENT)
    program["texels"], program["n"], program["mode"] = (LAYOUT.width, LAYOUT.height), LAYOUT.bucket, mode
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    inputs = {"uvs": lookups.uv, "normals": signed, "tangents": lookups.tangent, "lights": light}
    fields = {name: values.reshape(SIDE, SIDE, -1).astype(np.float32) for name, values in inputs.items()}
    stored = mipmapped(context, [atlas.astype(np.float16)], moderngl.NEAREST)
    return drawn(context, program, {"atlas": stored, **fields}, SIDE)


def local(lookups: Lookups, light: Floats) -> Floats:
    """Lights in the frame, (K, 3) float64."""
    frame = orthonormal_frame(lookups.normal.astype(float), lookups.tangent.astype(float), lookups.sign)
    return to_frame(light.astype(float), *frame)


@pytest.mark.parametrize("version", VERSIONS)
def test_glsl_agrees_with_the_reference(context: moderngl.Context, version: str) -> None:
    atlas, lookups, light = random_atlas(), random_lookups(), lights()
    stored, uv, direction = (
        atlas.astype(np.float16).astype(float),
        lookups.uv.astype(float),
        local(lookups, light),
    )
    squared = (light.astype(float) ** 2).sum(axis=1, keepdims=True)
    sun = relight(stored, LAYOUT, uv, [(direction, np.array(IRRADIANCE))])
    lamp = relight(stored, LAYOUT, uv, [(direction, IRRADIANCE / squared)])
    expected = [sample_transfer(stored, LAYOUT, uv, direction), sun, lamp]
    for mode, answers in enumerate(expected):
        result = run(context, VERSIONS[version], atlas, lookups, light, mode)[:, : answers.shape[1]]
        worst = float(relative_error(result, answers).max())
        print(f"{version}, mode {mode}: worst error of {COUNT} lookups {worst:.1e}")
        assert worst <= WORST


def test_cells_do_not_bleed_into_other_texels(context: moderngl.Context) -> None:
    """Texels that are constants stay so at their middles, from every direction."""
    random, lookups = np.random.default_rng(4), random_lookups()
    value = random.random((LAYOUT.height, LAYOUT.width, 4)).astype(np.float16).astype(float)
    atlas = np.kron(value.transpose(2, 0, 1), np.ones((LAYOUT.bucket, LAYOUT.bucket))).transpose(1, 2, 0)
    i, j = random.integers(LAYOUT.width, size=COUNT), random.integers(LAYOUT.height, size=COUNT)
    lookups.uv[:] = np.stack([(i + 0.5) / LAYOUT.width, (j + 0.5) / LAYOUT.height], axis=1)
    result = run(context, VERSIONS["GLSL 330"], atlas, lookups, lights(), 0)
    np.testing.assert_allclose(result, value[j, i], atol=1e-5)
