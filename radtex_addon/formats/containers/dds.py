# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""DDS files of one texture: 148 bytes of header, then blocks as a GPU takes them.

Format: https://learn.microsoft.com/windows/win32/direct3ddds/dds-header and .../dds-header-dxt10
"""

from __future__ import annotations

import struct
from itertools import product
from pathlib import Path
from typing import NamedTuple

from ...core.errors import InputError
from ..disk.atomic import replacing
from .texture import Encoded, PixelFormat, TextureShape

# Numbers in DXGI_FORMAT.
DXGI = {
    PixelFormat.RGBA8: 28,
    PixelFormat.BC3: 77,
    PixelFormat.BC3_SRGB: 78,
    PixelFormat.BC4: 80,
    PixelFormat.BC6H: 95,
    PixelFormat.BC7: 98,
    PixelFormat.BC7_SRGB: 99,
    PixelFormat.RGBA16F: 10,
}


class _Header(NamedTuple):
    """The fields of DDS_HEADER and DDS_HEADER_DXT10, without the reserved ones in the middle."""

    magic: bytes
    size: int
    flags: int
    height: int
    width: int
    pitch: int
    depth: int
    mipmaps: int
    pixel_size: int
    pixel_flags: int
    four_cc: bytes
    bits: int
    red: int
    green: int
    blue: int
    alpha: int
    caps: int
    caps2: int
    caps3: int
    caps4: int
    reserved: int
    dxgi: int
    dimension: int
    misc: int
    layers: int
    misc2: int


_LAYOUT = struct.Struct("<4s7I44x2I4s5I5I5I")
_MAGIC, _SIZE, _PIXEL_SIZE = b"DDS ", 124, 32
_FLAGS = 0x1 | 0x2 | 0x4 | 0x1000  # the header has capabilities, height, width, a pixel format
_PITCH, _LINEAR_SIZE = 0x8, 0x80000  # flags too: `pitch` is the bytes of a row, or of the whole image
_FOUR_CC, _DX10 = 0x4, b"DX10"
_TEXTURE = 0x1000
_MIPMAPPED, _MIPMAPS = 0x20000, 0x8 | 0x400000  # in flags, and in caps: one of several surfaces, with mipmaps
_TEXTURE_2D = 3


def write_texture(path: Path, texture: Encoded) -> None:
    """Write a texture with its layers and mip levels; rows stay in their order.

    On failure an existing file `path` is unchanged. Raises InputError for a format that is not written to
    DDS, or if blocks reach beyond the edge, which Direct3D refuses; BakeError where the system refuses.
    """
    form = texture.form
    if form.format not in DXGI:
        raise InputError(f"{path}: {form.format} is not written to DDS; choose {', '.join(DXGI)}")
    if form.width % form.format.side or form.height % form.format.side:
        found = f"{form.width} x {form.height} pixels are no whole blocks of 4 x 4"
        raise InputError(f"{path}: {found}, which Direct3D needs; choose {PixelFormat.RGBA16F}, or KTX2")
    with replacing(path) as beside, beside.open("wb") as file:
        file.write(_LAYOUT.pack(*_header(form)))
        for layer, level in product(range(form.layers), range(form.levels)):
            file.writelines(texture.parts(level, layer))


def _header(form: TextureShape) -> _Header:
    packed, mipmapped = form.format.side > 1, form.levels > 1
    pitch = form.nbytes(0) // form.layers if packed else form.width * form.format.block_bytes
    return _Header(
        magic=_MAGIC,
        size=_SIZE,
        flags=_FLAGS | (_LINEAR_SIZE if packed else _PITCH) | (_MIPMAPPED if mipmapped else 0),
        height=form.height,
        width=form.width,
        pitch=pitch,
        depth=0,
        mipmaps=form.levels,
        pixel_size=_PIXEL_SIZE,
        pixel_flags=_FOUR_CC,
        four_cc=_DX10,
        **dict.fromkeys(("bits", "red", "green", "blue", "alpha"), 0),
        caps=_TEXTURE | (_MIPMAPS if mipmapped else 0),
        **dict.fromkeys(("caps2", "caps3", "caps4", "reserved"), 0),
        dxgi=DXGI[form.format],
        dimension=_TEXTURE_2D,
        misc=0,
        layers=form.layers,
        misc2=0,  # the meaning of alpha is unspecified: old readers refuse anything else
    )
