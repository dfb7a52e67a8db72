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
from radtex_addon.formats.shadow_files import Words
from tests.lookups import SIDE, Lookups, random_lookups
from tests.real.opengl import VERSIONS, compiled, drawn
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

SHADERS = Path(__file__).parents[2] / "shaders"
LAYERS = "#define RADTEX_SHADOW_LAYERS\n"
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
    layers, size = stacked(words), (layout.width, layout.height)
    texture: moderngl.Texture | moderngl.TextureArray
    if LAYERS in head:
        texture = context.texture_array((*size, len(layers)), 2, layers.tobytes(), alignment=1, dtype="u4")
    else:
        texture = context.texture(size, 2, layers.tobytes(), alignment=1, dtype="u4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    inputs = {"uvs": lookups.uv, "normals": signed, "tangents": lookups.tangent, "viewers": lookups.viewer}
    fields = {name: field.reshape(SIDE, SIDE, -1) for name, field in inputs.items()}
    fields["uvs"] = np.concatenate([fields["uvs"], np.zeros((SIDE, SIDE, 1), np.float32)], axis=2)
    return drawn(context, program, {"bits": texture, **fields}, SIDE)[:, 0]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("mode", [ONE, SUN, RECTANGLE])
@pytest.mark.parametrize(("cells", "define"), [(5, ""), (8, ""), (8, LAYERS), (12, LAYERS)])
def test_glsl_agrees_with_the_reference(
    context: moderngl.Context, version: str, mode: int, cells: int, define: str
) -> None:
    layout, lookups = AtlasLayout(13, 7, cells), random_lookups()
    words = random_words(layout)
    found = run(context, VERSIONS[version] + define, words, layout, lookups, mode)
    wanted = expected(words, layout, lookups, mode, bool(define))
    check(found, wanted, mode, bool(define), f"{version}, {cells} cells")
