# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders on a real OpenGL: many lookups at once, one a pixel."""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, TypeAlias

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.containers.texture import Texture as Blocks

VERSIONS = {"GLSL 330": "#version 330\n", "GLSL ES 300": "#version 300 es\n"}
_FORMATS = {  # moderngl knows none of them
    PixelFormat.BC3: 0x83F3,  # GL_COMPRESSED_RGBA_S3TC_DXT5_EXT
    PixelFormat.BC3_SRGB: 0x8C4F,  # GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT
    PixelFormat.BC4: 0x8DBB,  # GL_COMPRESSED_RED_RGTC1
    PixelFormat.BC6H: 0x8E8F,  # GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT
    PixelFormat.BC7: 0x8E8C,  # GL_COMPRESSED_RGBA_BPTC_UNORM
    PixelFormat.BC7_SRGB: 0x8E8D,  # GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM
}
_TEXTURE_2D, _TEXTURE_2D_ARRAY = 0x0DE1, 0x8C1A  # GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY
_TEXTURE_CUBE, _FIRST_FACE = 0x8513, 0x8515  # GL_TEXTURE_CUBE_MAP, GL_TEXTURE_CUBE_MAP_POSITIVE_X
_MAX_LEVEL = 0x813D  # GL_TEXTURE_MAX_LEVEL
_PIXEL_FORMATS = {1: 0x1903, 2: 0x8227, 3: 0x1907, 4: 0x1908}  # GL_RED, GL_RG, GL_RGB, GL_RGBA
_FLOAT_TYPES = {2: 0x140B, 4: 0x1406}  # GL_HALF_FLOAT, GL_FLOAT
_VERTEX = """
void main() {  // one triangle that covers the picture
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
"""

Texture: TypeAlias = moderngl.Texture | moderngl.TextureArray
AnyTexture: TypeAlias = Texture | moderngl.TextureCube


def compiled(context: moderngl.Context, head: str, fragment: str) -> moderngl.Program:
    """A program that draws the whole picture; `head` is a version and defines."""
    return context.program(vertex_shader=head + _VERTEX, fragment_shader=head + fragment)


def drawn(
    context: moderngl.Context,
    program: moderngl.Program,
    textures: Mapping[str, Floats | Texture],
    side: int,
) -> Floats:
    """The shader's answers, (side², 4) float32; `textures`, or arrays (H, W, C), by their samplers' names."""
    for unit, (name, values) in enumerate(textures.items()):
        texture = _uploaded(context, values) if isinstance(values, np.ndarray) else values
        texture.use(unit)
        program[name] = unit
    target = context.framebuffer([context.texture((side, side), 4, dtype="f4")])
    target.use()
    context.vertex_array(program, []).render(vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(-1, 4)


def set_values(program: moderngl.Program, values: Mapping[str, Any]) -> None:
    """Set those uniforms that the program has: vectors, or lists of such."""
    for name, value in values.items():
        if name in program:
            program[name] = uniform(value)


def uniform(value: Sequence[Any]) -> Any:
    """A vector, or a list of such, as moderngl wants it: a list of one without its brackets."""
    rows = [tuple(row) for row in value] if isinstance(value[0], list) else [tuple(value)]
    return rows if len(rows) > 1 else rows[0]


def mipmapped(context: moderngl.Context, chain: Sequence[Floats], minified: int) -> Texture:
    """A texture of mip levels (H, W, C), or an array texture of such (layers, H, W, C), clamped to its edge.

    `minified` is the filter for minification, one of moderngl's; magnified it is linear.
    """
    first = np.ascontiguousarray(chain[0])
    *layers, height, width, channels = first.shape
    kind = f"f{first.dtype.itemsize}"
    texture: Texture
    if layers:
        texture = context.texture_array(
            (width, height, layers[0]), channels, first.tobytes(), alignment=1, dtype=kind
        )
    else:
        texture = context.texture((width, height), channels, first.tobytes(), alignment=1, dtype=kind)
    if len(chain) > 1:
        texture.build_mipmaps(0, len(chain) - 1)  # makes room; what is in it is overwritten
    for level, image in enumerate(chain[1:], start=1):
        _write_level(context, texture, level, image)
    texture.filter = (minified, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def _write_level(context: moderngl.Context, texture: Texture, level: int, image: Floats) -> None:
    """A level of any texture: moderngl writes none of an array's."""
    target = _TEXTURE_2D_ARRAY if isinstance(texture, moderngl.TextureArray) else _TEXTURE_2D
    size = image.shape[-2::-1]
    _gl("glBindTexture", ctypes.c_uint, ctypes.c_uint)(target, texture.glo)
    _gl("glPixelStorei", ctypes.c_uint, ctypes.c_int)(0x0CF5, 1)  # GL_UNPACK_ALIGNMENT
    upload = _gl(f"glTexSubImage{len(size)}D", *[ctypes.c_uint] * (4 + 2 * len(size)), ctypes.c_char_p)
    kind = (_PIXEL_FORMATS[image.shape[-1]], _FLOAT_TYPES[image.dtype.itemsize])
    upload(target, level, *[0] * len(size), *size, *kind, np.ascontiguousarray(image).tobytes())
    if context.error != "GL_NO_ERROR":
        raise ValueError(f"level {level} of {size}: the driver refused it")


def in_blocks(context: moderngl.Context, blocks: Blocks, minified: int, cube: bool = False) -> AnyTexture:
    """A texture of blocks with its levels, or an array; six layers are a `cube`'s faces. Clamped to its edge.

    `minified` as of `mipmapped`. Raises ValueError for blocks that the driver refuses.
    """
    texture: AnyTexture
    if cube:
        target, texture = _TEXTURE_CUBE, context.texture_cube((4, 4), 4)
    elif blocks.is_array:
        target, texture = _TEXTURE_2D_ARRAY, context.texture_array((4, 4, 1), 4)
    else:
        target, texture = _TEXTURE_2D, context.texture((4, 4), 4)
    _gl("glBindTexture", ctypes.c_uint, ctypes.c_uint)(target, texture.glo)
    size, kind = ctypes.c_uint, _FORMATS[blocks.format]
    for number, level in enumerate(blocks.levels):
        sides = (max(1, blocks.width >> number), max(1, blocks.height >> number))
        if target == _TEXTURE_2D_ARRAY:
            upload = _gl("glCompressedTexImage3D", *[size] * 8, ctypes.c_char_p)
            upload(target, number, kind, *sides, len(level), 0, level.nbytes, level.tobytes())
            continue
        upload = _gl("glCompressedTexImage2D", *[size] * 7, ctypes.c_char_p)
        for face, part in enumerate(level):
            where = _FIRST_FACE + face if cube else target
            upload(where, number, kind, *sides, 0, part.nbytes, part.tobytes())
    _gl("glTexParameteri", size, size, ctypes.c_int)(target, _MAX_LEVEL, len(blocks.levels) - 1)
    if context.error != "GL_NO_ERROR":
        raise ValueError(f"{blocks.format}, {blocks.width} x {blocks.height}: the driver refused it")
    texture.filter = (minified, moderngl.LINEAR)
    if not isinstance(texture, moderngl.TextureCube):
        texture.repeat_x = texture.repeat_y = False
    return texture


def cube_of_levels(context: moderngl.Context, chain: Sequence[Floats]) -> moderngl.TextureCube:
    """A cube's levels (6, M, M, 3), trilinear, as half floats."""
    first = np.ascontiguousarray(chain[0], np.float16)
    side = first.shape[1]
    texture = context.texture_cube((side, side), 3, first.tobytes(), alignment=1, dtype="f2")
    texture.build_mipmaps(0, len(chain) - 1)  # makes room; what is in it is overwritten
    upload = _gl("glTexImage2D", *[ctypes.c_uint] * 8, ctypes.c_char_p)
    for level, faces in enumerate(chain[1:], start=1):
        _gl("glBindTexture", ctypes.c_uint, ctypes.c_uint)(_TEXTURE_CUBE, texture.glo)
        _gl("glPixelStorei", ctypes.c_uint, ctypes.c_int)(0x0CF5, 1)  # GL_UNPACK_ALIGNMENT
        for face, image in enumerate(faces):
            values = np.ascontiguousarray(image, np.float16)
            sides = (len(image), len(image))
            upload(
                _FIRST_FACE + face, level, 0x881B, *sides, 0, 0x1907, 0x140B, values.tobytes()
            )  # GL_RGB16F
    if context.error != "GL_NO_ERROR":
        raise ValueError(f"a cube of {side} pixels a side: the driver refused it")
    texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    return texture


def _gl(name: str, *arguments: type) -> ctypes._FuncPointer:
    """A function of the current context."""
    return ctypes.CFUNCTYPE(None, *arguments)(_egl().eglGetProcAddress(name.encode()))


@cache
def _egl() -> ctypes.CDLL:
    egl = ctypes.CDLL(ctypes.util.find_library("EGL") or "libEGL.so.1")
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    return egl


def _uploaded(context: moderngl.Context, values: Floats) -> moderngl.Texture:
    height, width, channels = values.shape
    data = np.ascontiguousarray(values).tobytes()
    texture = context.texture((width, height), channels, data, dtype=f"f{values.dtype.itemsize}", alignment=1)
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)  # what lies about this must not matter
    return texture
