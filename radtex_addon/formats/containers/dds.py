# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""DDS files of one texture: 148 bytes of header, then blocks as a GPU takes them.

Format: https://learn.microsoft.com/windows/win32/direct3ddds/dds-header and .../dds-header-dxt10
"""

from __future__ import annotations

import os
import struct
from enum import IntEnum
from itertools import product
from math import prod
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...core.errors import FormatError, InputError, ShapeError
from ..codecs.bc7 import Blocks, described
from ..disk.atomic import replacing
from ..disk.memory import check_memory
from ..disk.regular import open_regular
from .texture import MOST_PIXELS, Encoded, Form, PixelFormat, Texture, blocks_shape, size_misfit


class DdsFormat(IntEnum):
    """Pixel formats of a file, by their numbers in DXGI_FORMAT."""

    R8G8B8A8_UNORM = 28
    BC3_UNORM = 77
    BC3_UNORM_SRGB = 78
    BC4_UNORM = 80
    BC5_UNORM = 83
    BC6H_UF16 = 95
    BC7_UNORM = 98
    BC7_UNORM_SRGB = 99
    R16G16B16A16_FLOAT = 10

    @property
    def pixel_format(self) -> PixelFormat:
        """The same format as a PixelFormat."""
        return _PIXEL_FORMATS[self]

    @property
    def side(self) -> int:
        """Pixels along a block's side."""
        return self.pixel_format.side

    @property
    def block_bytes(self) -> int:
        """The size of a block."""
        return self.pixel_format.block_bytes


_PIXEL_FORMATS = {
    DdsFormat.R8G8B8A8_UNORM: PixelFormat.RGBA8,
    DdsFormat.BC3_UNORM: PixelFormat.BC3,
    DdsFormat.BC3_UNORM_SRGB: PixelFormat.BC3_SRGB,
    DdsFormat.BC4_UNORM: PixelFormat.BC4,
    DdsFormat.BC5_UNORM: PixelFormat.BC5,
    DdsFormat.BC6H_UF16: PixelFormat.BC6H,
    DdsFormat.BC7_UNORM: PixelFormat.BC7,
    DdsFormat.BC7_UNORM_SRGB: PixelFormat.BC7_SRGB,
    DdsFormat.R16G16B16A16_FLOAT: PixelFormat.RGBA16F,
}
_DDS_FORMATS = {theirs: ours for ours, theirs in _PIXEL_FORMATS.items()}


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
_CUBE_OR_VOLUME = 0x200 | 0x200000  # in caps2
_TEXTURE_2D, _CUBE = 3, 0x4


def write_dds(path: Path, blocks: Blocks, texture_format: DdsFormat) -> None:
    """Write one 2D texture without mipmaps: (H/4, W/4, 16) uint8 of blocks, or (H, W, bytes) of pixels.

    Rows are stored in the given order, top or bottom first. On failure an existing file `path` is unchanged.
    Raises ShapeError for another shape or type, or more than 16384 pixels a side, BakeError where the system
    refuses.
    """
    kind = texture_format
    if blocks.ndim != 3 or blocks.shape[2] != kind.block_bytes or blocks.dtype != np.uint8 or not blocks.size:
        expected = f"(rows, columns, {kind.block_bytes}) of uint8"
        raise ShapeError(f"{path}: expected blocks of shape {expected}, got {described(blocks)}")
    height, width = blocks.shape[0] * kind.side, blocks.shape[1] * kind.side
    if max(height, width) > MOST_PIXELS:
        raise ShapeError(f"{path}: {width} x {height} pixels are too many, {MOST_PIXELS} a side is the most")
    write_texture(path, Texture(kind.pixel_format, width, height, (blocks[None],)))


def write_texture(path: Path, texture: Encoded) -> None:
    """Write a texture with its layers and mip levels; rows stay in their order.

    On failure an existing file `path` is unchanged. Raises InputError for a format that is not written to
    DDS, or if blocks reach beyond the edge, which Direct3D refuses; BakeError where the system refuses.
    """
    form = texture.form
    kind = _DDS_FORMATS.get(form.format)
    if kind is None:
        raise InputError(f"{path}: {form.format} is not written to DDS; choose {', '.join(_DDS_FORMATS)}")
    if form.width % kind.side or form.height % kind.side:
        found = f"{form.width} x {form.height} pixels are no whole blocks of 4 x 4"
        raise InputError(f"{path}: {found}, which Direct3D needs; choose {PixelFormat.RGBA16F}, or KTX2")
    header = _header(kind, form)
    with replacing(path) as beside, beside.open("wb") as file:
        file.write(_LAYOUT.pack(*header))
        for layer, level in product(range(form.layers), range(form.levels)):
            file.writelines(texture.parts(level, layer))


def read_dds(path: Path) -> tuple[DdsFormat, Blocks, int, int]:
    """Read a file of `write_dds`: format, blocks with their rows as stored, width and height in pixels.

    The last blocks of a row and a column may reach beyond the width and height. Raises FormatError, with the
    path, for a file that is missing, cut short, no DDS, or holds anything but one 2D texture of our formats.
    """
    kind, texture = _read(path, alone=True)
    return kind, texture.levels[0][0], texture.width, texture.height


def read_texture(path: Path) -> Texture:
    """Read a file of `write_texture`; a single layer is never read as an array.

    Raises FormatError as `read_dds` does, and for a file too large for this machine's memory.
    """
    return _read(path, alone=False)[1]


def _read(path: Path, alone: bool) -> tuple[DdsFormat, Texture]:
    """The texture of a file; with `alone`, layers and mip levels are refused."""
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            header, kind = _checked(path, file.read(_LAYOUT.size), size, alone)
            shapes = _shapes(header, kind)
            levels = tuple(np.empty(shape, np.uint8) for shape in shapes)
            parts = [level[layer] for layer in range(header.layers) for level in levels]
            got = sum(file.readinto(part.data) for part in parts)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
    if got != sum(level.nbytes for level in levels):
        raise FormatError(f"{path} was cut short while it was read: bake it again")
    return kind, Texture(kind.pixel_format, header.width, header.height, levels, header.layers > 1)


def _header(kind: DdsFormat, form: Form) -> _Header:
    packed, mipmapped = kind.side > 1, form.levels > 1
    pitch = form.nbytes(0) // form.layers if packed else form.width * kind.block_bytes
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
        dxgi=int(kind),
        dimension=_TEXTURE_2D,
        misc=0,
        layers=form.layers,
        misc2=0,  # the meaning of alpha is unspecified: old readers refuse anything else
    )


def _shapes(header: _Header, kind: DdsFormat) -> list[tuple[int, int, int, int]]:
    """Shapes of the levels' blocks; a file without mipmaps may give their number as 0."""
    width, height, count = header.width, header.height, max(1, header.mipmaps)
    return [blocks_shape(kind.pixel_format, width, height, header.layers, level) for level in range(count)]


def _checked(path: Path, head: bytes, size: int, alone: bool) -> tuple[_Header, DdsFormat]:
    """Check the header of a file of `size` bytes that begins with `head`; returns it and the format."""
    if head[: len(_MAGIC)] != _MAGIC[: len(head)] or not head:
        raise FormatError(f"{path} is not a DDS file")
    if len(head) < _LAYOUT.size:
        raise FormatError(f"{path} is cut short: bake it again")
    header = _Header._make(_LAYOUT.unpack(head))
    if header.size != _SIZE or header.pixel_size != _PIXEL_SIZE:
        raise FormatError(f"{path} is damaged, its header cannot be read: bake it again")
    kind = _kind(path, header)
    if header.dimension != _TEXTURE_2D or header.misc & _CUBE or header.caps2 & _CUBE_OR_VOLUME:
        raise FormatError(f"{path} is no single 2D texture: save it without sides and depth")
    if alone and (header.layers != 1 or header.mipmaps > 1):
        raise FormatError(f"{path} is no single 2D texture: save it without mipmaps and layers")
    if misfit := size_misfit(header.width, header.height, header.layers, max(1, header.mipmaps)):
        raise FormatError(f"{path} has {misfit}")
    expected = _LAYOUT.size + sum(prod(shape) for shape in _shapes(header, kind))
    if size != expected:
        wrong = "is cut short" if size < expected else "has more in it than one texture"
        raise FormatError(f"{path} {wrong}: {size} bytes, its header says {expected}; bake it again")
    check_memory(str(path), size)
    return header, kind


def _kind(path: Path, header: _Header) -> DdsFormat:
    known = {int(kind): kind for kind in DdsFormat}
    if header.pixel_flags & _FOUR_CC and header.four_cc == _DX10 and header.dxgi in known:
        return known[header.dxgi]
    found = "an older DDS format"
    if header.pixel_flags & _FOUR_CC:
        found = f'"{header.four_cc.decode("latin-1")}"'
        if header.four_cc == _DX10:
            found = f"DXGI format {header.dxgi}"
    raise FormatError(f"{path} holds {found}: save it as {', '.join(kind.name for kind in DdsFormat)}")
