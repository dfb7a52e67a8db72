# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""DDS files of one picture: blocks as a GPU takes them, behind 148 bytes of header.

Format: https://learn.microsoft.com/windows/win32/direct3ddds/dds-header and .../dds-header-dxt10
"""

from __future__ import annotations

import os
import struct
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..core.errors import FormatError, ShapeError
from .atomic import replacing
from .bc7 import Blocks, described

MOST_PIXELS = 16384  # a side, as in Direct3D 11 and what every GPU of its time takes


class DdsFormat(IntEnum):
    """What a file holds, by its number in DXGI_FORMAT."""

    R8G8B8A8_UNORM = 28
    BC5_UNORM = 83
    BC6H_UF16 = 95
    BC7_UNORM = 98

    @property
    def side(self) -> int:
        """Pixels along a block's side."""
        return 1 if self is DdsFormat.R8G8B8A8_UNORM else 4

    @property
    def block_bytes(self) -> int:
        """The size of a block."""
        return 4 if self is DdsFormat.R8G8B8A8_UNORM else 16


class _Header(NamedTuple):
    """DDS_HEADER and DDS_HEADER_DXT10, field by field, but for the reserved ones in the middle."""

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
_PITCH, _LINEAR_SIZE = 0x8, 0x80000  # and the bytes of a row, or of all
_FOUR_CC, _DX10 = 0x4, b"DX10"
_TEXTURE = 0x1000
_CUBE_OR_VOLUME = 0x200 | 0x200000  # in caps2
_TEXTURE_2D, _CUBE = 3, 0x4


def write_dds(path: Path, blocks: Blocks, texture_format: DdsFormat) -> None:
    """Write one 2D texture without mipmaps: (H/4, W/4, 16) uint8 of blocks, or (H, W, 4) of R8G8B8A8.

    Rows are stored as given: whether the first is the picture's top or bottom is the caller's business. On
    failure `path` is what it was. Raises ShapeError for another shape or type, or more than 16384 pixels a
    side, BakeError where the system refuses.
    """
    kind = texture_format
    if blocks.ndim != 3 or blocks.shape[2] != kind.block_bytes or blocks.dtype != np.uint8 or not blocks.size:
        expected = f"(rows, columns, {kind.block_bytes}) of uint8"
        raise ShapeError(f"{path}: expected blocks of shape {expected}, got {described(blocks)}")
    height, width = blocks.shape[0] * kind.side, blocks.shape[1] * kind.side
    if max(height, width) > MOST_PIXELS:
        raise ShapeError(f"{path}: {width} x {height} pixels are too many, {MOST_PIXELS} a side is the most")
    header = _header(kind, width, height, blocks.nbytes)
    with replacing(path) as beside, beside.open("wb") as file:
        file.write(_LAYOUT.pack(*header))
        file.write(np.ascontiguousarray(blocks).data)


def read_dds(path: Path) -> tuple[DdsFormat, Blocks, int, int]:
    """What `write_dds` wrote: format, blocks with their rows as stored, width and height in pixels.

    The last blocks of a row and a column may reach beyond the width and height. Raises FormatError, with the
    path, for a file that is missing, cut short, no DDS, or holds anything else than one 2D texture of ours.
    """
    try:
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            kind, width, height = _checked(path, file.read(_LAYOUT.size), size)
            rows, columns = -(-height // kind.side), -(-width // kind.side)
            data = np.empty((rows, columns, kind.block_bytes), np.uint8)
            got = file.readinto(data.data)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
    if got != data.nbytes:
        raise FormatError(f"{path} was cut short while it was read: bake it again")
    return kind, data, width, height


def _header(kind: DdsFormat, width: int, height: int, size: int) -> _Header:
    packed = kind.side > 1
    return _Header(
        magic=_MAGIC,
        size=_SIZE,
        flags=_FLAGS | (_LINEAR_SIZE if packed else _PITCH),
        height=height,
        width=width,
        pitch=size if packed else width * kind.block_bytes,
        depth=0,
        mipmaps=1,
        pixel_size=_PIXEL_SIZE,
        pixel_flags=_FOUR_CC,
        four_cc=_DX10,
        **dict.fromkeys(("bits", "red", "green", "blue", "alpha"), 0),
        caps=_TEXTURE,
        **dict.fromkeys(("caps2", "caps3", "caps4", "reserved"), 0),
        dxgi=int(kind),
        dimension=_TEXTURE_2D,
        misc=0,
        layers=1,
        misc2=0,  # what alpha means is unknown: old readers refuse anything else
    )


def _checked(path: Path, head: bytes, size: int) -> tuple[DdsFormat, int, int]:
    """Format, width and height of a file of `size` bytes that begins with `head`, once nothing is amiss."""
    if head[: len(_MAGIC)] != _MAGIC[: len(head)] or not head:
        raise FormatError(f"{path} is not a DDS file")
    if len(head) < _LAYOUT.size:
        raise FormatError(f"{path} is cut short: bake it again")
    header = _Header._make(_LAYOUT.unpack(head))
    if header.size != _SIZE or header.pixel_size != _PIXEL_SIZE:
        raise FormatError(f"{path} is damaged, its header cannot be read: bake it again")
    kind = _kind(path, header)
    one = header.dimension == _TEXTURE_2D and header.layers == 1 and header.mipmaps <= 1
    if not one or header.misc & _CUBE or header.caps2 & _CUBE_OR_VOLUME:
        raise FormatError(f"{path} is no single 2D texture: save it without mipmaps, layers, sides and depth")
    width, height = header.width, header.height
    if not (1 <= width <= MOST_PIXELS and 1 <= height <= MOST_PIXELS):
        raise FormatError(f"{path} has {width} x {height} pixels, expected 1 to {MOST_PIXELS} a side")
    expected = _LAYOUT.size + -(-height // kind.side) * -(-width // kind.side) * kind.block_bytes
    if size != expected:
        wrong = "is cut short" if size < expected else "has more in it than one texture"
        raise FormatError(f"{path} {wrong}: {size} bytes, its header says {expected}; bake it again")
    return kind, width, height


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
