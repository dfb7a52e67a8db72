# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance at given fragments by the layered layout's GLSL, to be compared with `sample_layered`."""

from __future__ import annotations

import math

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.fragments import Fragments
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from tests.real.opengl import VERSIONS, compiled, drawn, set_values

from .lookup import Lookup

_SHADER = """
uniform sampler2D uvs, normals, viewers, positions;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
    result = vec4(radtex_layered(texelFetch(uvs, here, 0).xy, texelFetch(positions, here, 0).xyz, N, V), 1.0);
}
"""


def radiance(
    context: moderngl.Context, atlas: LayeredAtlas, lookup: Lookup, at: Fragments, defines: str = ""
) -> Floats:
    """Radiance seen at fragments, (N, 3) float32, linear; with more `defines` than the lookup's."""
    count = len(at.uv)
    side = math.ceil(count**0.5)
    images = {"uvs": at.uv, "normals": at.normal, "viewers": at.viewer, "positions": at.position}
    program = compiled(context, VERSIONS["GLSL 330"], defines + lookup.code + _SHADER)
    textures: dict[str, Floats | moderngl.Texture | moderngl.TextureArray] = dict(lookup.uploaded(context))
    for name, values in images.items():
        padded = np.zeros((side * side, values.shape[1]), dtype=np.float32)
        padded[:count] = values
        textures[name] = padded.reshape(side, side, -1)
    textures = {name: texture for name, texture in textures.items() if name in program}
    found = np.zeros((count, 3), dtype=np.float32)
    for number in range(len(atlas.materials)):
        set_values(program, lookup.values(number))
        own = at.material == number
        found[own] = drawn(context, program, textures, side)[:count, :3][own]
    return found
