# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_shadow.glsl on a real OpenGL, over EGL, against core.shadow: a light, a sun, a rectangle."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter
from radtex_addon.core.shadow import (
    area_weights,
    pack_bits,
    soft_visibility,
    square_points,
    sun_directions,
    sun_weight,
    visibility,
)
from radtex_addon.formats.shadow_files import Words
from tests.lookups import SIDE, Lookups, random_lookups
from tests.real.opengl import VERSIONS, compiled, drawn

SHADERS = Path(__file__).parents[2] / "shaders"
LAYERS = "#define RADTEX_SHADOW_LAYERS\n"
ONE, SUN, RECTANGLE = range(3)
POINTS = 12
ANGLE = 0.3
CORNER, ACROSS, UP = (-0.5, -0.4, 2.0), (1.0, 0.2, 0.0), (0.0, 0.3, 0.9)
FRAGMENT = """
#ifdef RADTEX_SHADOW_LAYERS
uniform highp usampler2DArray bits;
#else
uniform highp usampler2D bits;
#endif
uniform sampler2D uvs, normals, tangents, viewers;
uniform ivec2 texels;
uniform int n, mode, count;
uniform float angle;
uniform vec3 corner, across, up;
out vec4 result;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, at, 0);
    vec3 tangent = texelFetch(tangents, at, 0).xyz, light = texelFetch(viewers, at, 0).xyz;
    mat3 frame = radtex_frame(normal.xyz, tangent, normal.w);
    RadtexShadow here = radtex_shadow(bits, texels, texelFetch(uvs, at, 0).xy);
    float value = mode == 0 ? radtex_visible(RADTEX_HERE, n, normalize(light) * frame)
        : mode == 1 ? radtex_sun(RADTEX_HERE, n, frame, light, angle, count)
        : radtex_rectangle(RADTEX_HERE, n, frame, light, corner, across, up, count);
    result = vec4(value);
}
"""


def random_words(layout: AtlasLayout) -> Words:
    shape = (layout.height, layout.width, layout.bucket, layout.bucket)
    return pack_bits(np.random.default_rng(4).random(shape) < 0.5)


def run(
    context: moderngl.Context, head: str, words: Words, layout: AtlasLayout, lookups: Lookups, mode: int
) -> Floats:
    """The shader's answers, (K,)."""
    source = "".join(
        (SHADERS / name).read_text(encoding="utf-8") for name in ("radtex.glsl", "radtex_shadow.glsl")
    )
    program = compiled(context, head + "#define RADTEX_NO_DERIVATIVES\n", source + FRAGMENT)
    values = {
        "texels": (layout.width, layout.height),
        "n": layout.bucket,
        "mode": mode,
        "count": POINTS,
        "angle": ANGLE,
        "corner": CORNER,
        "across": ACROSS,
        "up": UP,
    }
    for name, value in values.items():
        program[name] = value
    pairs = np.pad(words, ((0, 0), (0, 0), (0, words.shape[2] % 2)))
    size = (layout.width, layout.height)
    texture: moderngl.Texture | moderngl.TextureArray
    if LAYERS in head:
        stacked = np.ascontiguousarray(pairs.reshape(*pairs.shape[:2], -1, 2).transpose(2, 0, 1, 3))
        texture = context.texture_array((*size, len(stacked)), 2, stacked.tobytes(), alignment=1, dtype="u4")
    else:
        texture = context.texture(size, 2, pairs.tobytes(), alignment=1, dtype="u4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    inputs = {"uvs": lookups.uv, "normals": signed, "tangents": lookups.tangent, "viewers": lookups.viewer}
    fields = {name: field.reshape(SIDE, SIDE, -1) for name, field in inputs.items()}
    fields["uvs"] = np.concatenate([fields["uvs"], np.zeros((SIDE, SIDE, 1), np.float32)], axis=2)
    return drawn(context, program, {"bits": texture, **fields}, SIDE)[:, 0]


def expected(words: Words, layout: AtlasLayout, lookups: Lookups, mode: int) -> Floats:
    """The reference's."""
    normal, tangent, sign, light, uv = (
        field.astype(float)
        for field in (lookups.normal, lookups.tangent, lookups.sign, lookups.viewer, lookups.uv)
    )
    frame = orthonormal_frame(normal, tangent, sign)
    kind = Filter.QUADRILINEAR
    if mode == ONE:
        return visibility(words, layout, uv, to_frame(normalised(light), *frame), kind)
    if mode == SUN:
        ways = sun_directions(normalised(light), ANGLE, POINTS)
        weight = np.maximum(np.einsum("ksx,kx->ks", ways, frame[2]), 0)
        scale = sun_weight(ANGLE)
    else:
        sides = np.cross(ACROSS, UP)
        scale = float(np.linalg.norm(sides))
        places = (np.array(list(square_points(POINTS))) + 1) / 2
        points = np.array(CORNER) + places @ np.array([ACROSS, UP])
        ways, weight = area_weights(light, frame[2], points, sides / scale)
    local = np.stack([to_frame(ways[:, k], *frame) for k in range(POINTS)], axis=1)
    arrives: Floats = weight.mean(axis=1) * scale * soft_visibility(words, layout, uv, local, weight, kind)
    return arrives


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("mode", [ONE, SUN, RECTANGLE])
@pytest.mark.parametrize(("cells", "define"), [(5, ""), (8, ""), (8, LAYERS), (12, LAYERS)])
def test_glsl_agrees_with_the_reference(
    context: moderngl.Context, version: str, mode: int, cells: int, define: str
) -> None:
    layout, lookups = AtlasLayout(13, 7, cells), random_lookups()
    words = random_words(layout)
    found = run(context, VERSIONS[version] + define, words, layout, lookups, mode)
    wanted = expected(words, layout, lookups, mode)
    off = np.abs(found - wanted) / (1 + np.abs(wanted))
    across = float(
        np.mean(off > 5e-4)
    )  # a point of a light so close to a cell's edge that float32 falls beyond
    print(f"{version}, {cells} cells, mode {mode}: worst of {len(off)} {off.max():.1e}, across {across:.2%}")
    assert across <= (0 if mode == ONE else 1e-3)
    assert off.max() < 2 / POINTS
    assert wanted.std() > 0.02
