# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders on a real OpenGL: many lookups at once, one a pixel."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats

VERSIONS = {"GLSL 330": "#version 330\n", "GLSL ES 300": "#version 300 es\n"}
_VERTEX = """
void main() {  // one triangle that covers the picture
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
"""


def compiled(context: moderngl.Context, head: str, fragment: str) -> moderngl.Program:
    """A program that draws the whole picture; `head` is a version and defines."""
    return context.program(vertex_shader=head + _VERTEX, fragment_shader=head + fragment)


def drawn(
    context: moderngl.Context, program: moderngl.Program, textures: Mapping[str, Floats], side: int
) -> Floats:
    """The shader's answers, (side², 4) float32; `textures` (H, W, C) go to the samplers of their names."""
    for unit, (name, values) in enumerate(textures.items()):
        _bind(context, program, name, values, unit)
    target = context.framebuffer([context.texture((side, side), 4, dtype="f4")])
    target.use()
    context.vertex_array(program, []).render(vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(-1, 4)


def _bind(context: moderngl.Context, program: moderngl.Program, name: str, values: Floats, unit: int) -> None:
    height, width, channels = values.shape
    data = np.ascontiguousarray(values).tobytes()
    texture = context.texture((width, height), channels, data, dtype=f"f{values.dtype.itemsize}", alignment=1)
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)  # what lies about this must not matter
    texture.use(unit)
    program[name] = unit
