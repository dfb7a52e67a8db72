# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders on a real OpenGL: many lookups at once, one a pixel."""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Mapping

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats

VERSIONS = {"GLSL 330": "#version 330\n", "GLSL ES 300": "#version 300 es\n"}
BC5_UNORM = 0x8DBD  # GL_COMPRESSED_RG_RGTC2
BC6H_UF16, BC7_UNORM = 0x8E8F, 0x8E8C  # GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT, GL_COMPRESSED_RGBA_BPTC_UNORM
_TEXTURE_2D = 0x0DE1  # GL_TEXTURE_2D
_VERTEX = """
void main() {  // one triangle that covers the picture
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
"""


def compiled(context: moderngl.Context, head: str, fragment: str) -> moderngl.Program:
    """A program that draws the whole picture; `head` is a version and defines."""
    return context.program(vertex_shader=head + _VERTEX, fragment_shader=head + fragment)


def drawn(
    context: moderngl.Context,
    program: moderngl.Program,
    textures: Mapping[str, Floats | moderngl.Texture],
    side: int,
) -> Floats:
    """The shader's answers, (side², 4) float32; `textures`, or arrays (H, W, C), by their samplers' names."""
    for unit, (name, values) in enumerate(textures.items()):
        texture = values if isinstance(values, moderngl.Texture) else _uploaded(context, values)
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)  # what lies about this must not matter
        texture.use(unit)
        program[name] = unit
    target = context.framebuffer([context.texture((side, side), 4, dtype="f4")])
    target.use()
    context.vertex_array(program, []).render(vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(-1, 4)


def fetched(context: moderngl.Context, texture: moderngl.Texture, width: int, height: int) -> Floats:
    """A texture's values as a shader gets them, (height, width, 4) float32."""
    fragment = """
        uniform sampler2D image;
        out vec4 result;
        void main() { result = texelFetch(image, ivec2(gl_FragCoord.xy), 0); }
    """
    side = max(width, height)
    answers = drawn(context, compiled(context, VERSIONS["GLSL 330"], fragment), {"image": texture}, side)
    return answers.reshape(side, side, 4)[:height, :width]


def compressed(
    context: moderngl.Context, kind: int, size: tuple[int, int], blocks: bytes
) -> moderngl.Texture:
    """Blocks of the format `kind` as a texture, which the driver decodes: moderngl knows no such formats."""
    texture = context.texture((4, 4), 4)
    _gl("glBindTexture", ctypes.c_uint, ctypes.c_uint)(_TEXTURE_2D, texture.glo)
    upload = _gl("glCompressedTexImage2D", *[ctypes.c_uint] * 7, ctypes.c_char_p)
    upload(_TEXTURE_2D, 0, kind, *size, 0, len(blocks), blocks)
    if context.error != "GL_NO_ERROR":
        raise ValueError(f"format {kind:#x}, size {size}, {len(blocks)} bytes: the driver refused them")
    return texture


def _gl(name: str, *arguments: type) -> ctypes._FuncPointer:
    """A function of the current context."""
    egl = ctypes.CDLL(ctypes.util.find_library("EGL"))
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, *arguments)(egl.eglGetProcAddress(name.encode()))


def _uploaded(context: moderngl.Context, values: Floats) -> moderngl.Texture:
    height, width, channels = values.shape
    data = np.ascontiguousarray(values).tobytes()
    return context.texture((width, height), channels, data, dtype=f"f{values.dtype.itemsize}", alignment=1)
