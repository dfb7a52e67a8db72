# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""KTX 2.0 files: 2D textures and arrays with mip levels, optionally compressed by Zstandard.

Format: KTX File Format Specification 2.0, https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html
The first row is the bottom one: KTXorientation is "ru".
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import zstandard

from ...core.errors import InputError
from ...version import VERSION
from ..disk.atomic import replacing
from .ktx2_descriptor import descriptor
from .texture import Encoded, PixelFormat

VK_FORMATS = {  # VkFormat
    PixelFormat.RGBA16F: 97,
    PixelFormat.RGB9E5: 123,
    PixelFormat.BC3: 137,
    PixelFormat.BC3_SRGB: 138,
    PixelFormat.BC4: 139,
    PixelFormat.BC6H: 143,
    PixelFormat.BC7: 145,
    PixelFormat.BC7_SRGB: 146,
    PixelFormat.R32UI: 98,
    PixelFormat.RG32UI: 101,
    PixelFormat.RGBA32F: 109,
}

_TYPE_SIZES = dict.fromkeys(VK_FORMATS, 1) | {  # blocks have 1
    PixelFormat.RGBA16F: 2,
    PixelFormat.RGB9E5: 4,
    PixelFormat.R32UI: 4,
    PixelFormat.RG32UI: 4,
    PixelFormat.RGBA32F: 4,
}
_MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"
_NONE, _ZSTD = 0, 2  # supercompression schemes
_EFFORT = 9  # Zstandard's level
_AT_ONCE = 1 << 25  # bytes: smaller levels are compressed in one piece
_ORIENTATION, _UPWARDS = b"KTXorientation", b"ru"


class _Header(NamedTuple):
    """The header of a file, up to the level index."""

    magic: bytes
    vk_format: int
    type_size: int
    width: int
    height: int
    depth: int
    layers: int
    faces: int
    levels: int
    scheme: int
    dfd_offset: int
    dfd_length: int
    kvd_offset: int
    kvd_length: int
    sgd_offset: int
    sgd_length: int


class _Level(NamedTuple):
    """A mip level's entry in the level index: place and length in the file, uncompressed length."""

    offset: int
    length: int
    unpacked: int


_LAYOUT = struct.Struct("<12s13I2Q")
_LEVEL_LAYOUT = struct.Struct("<3Q")


def write_ktx2(path: Path, texture: Encoded, zstd: bool = True, premultiplied: bool = True) -> None:
    """Write a texture of one of VK_FORMATS, its rows in their order, which must begin at the bottom.

    `zstd` compresses it without loss; `premultiplied` declares that RGBA16F has associated alpha. On failure
    an existing file `path` is unchanged. Raises InputError for another format, BakeError where the system
    refuses.
    """
    form = texture.form
    kind = form.format
    if kind not in VK_FORMATS:
        raise InputError(f"{path}: {kind} is not written to KTX2; choose {', '.join(VK_FORMATS)}")
    dfd = descriptor(kind, premultiplied and kind is PixelFormat.RGBA16F)
    kvd = _key_values({_ORIENTATION: _UPWARDS, b"KTXwriter": f"RadTex {VERSION}".encode()})
    dfd_offset = _LAYOUT.size + form.levels * _LEVEL_LAYOUT.size
    header = _Header(
        magic=_MAGIC,
        vk_format=VK_FORMATS[kind],
        type_size=_TYPE_SIZES[kind],
        width=form.width,
        height=form.height,
        depth=0,
        layers=form.layers if form.is_array else 0,
        faces=1,
        levels=form.levels,
        scheme=_ZSTD if zstd else _NONE,
        dfd_offset=dfd_offset,
        dfd_length=len(dfd),
        kvd_offset=dfd_offset + len(dfd),
        kvd_length=len(kvd),
        sgd_offset=0,
        sgd_length=0,
    )
    alignment = 1 if zstd else max(kind.block_bytes, 4)  # the least common multiple: both are powers of 2
    index: list[_Level] = []
    with replacing(path) as beside, beside.open("wb") as file:
        file.seek(dfd_offset)
        file.write(dfd + kvd)
        for level in reversed(range(form.levels)):  # the smallest comes first in the file
            file.write(bytes(-file.tell() % alignment))
            begin, size = file.tell(), form.nbytes(level)
            parts = (part for layer in range(form.layers) for part in texture.parts(level, layer))
            file.writelines(_packed(parts, size) if zstd else parts)
            index.insert(0, _Level(begin, file.tell() - begin, size))
        file.seek(0)
        file.write(_LAYOUT.pack(*header))
        file.writelines(_LEVEL_LAYOUT.pack(*level) for level in index)


def _packed(parts: Iterable[memoryview], size: int) -> Iterator[bytes]:
    """Compress `size` bytes by Zstandard; small levels in one piece, which compresses a little better."""
    packer = zstandard.ZstdCompressor(level=_EFFORT, write_checksum=True, write_content_size=True)
    if size <= _AT_ONCE:
        yield packer.compress(b"".join(parts))
        return
    stream = packer.compressobj(size=size)
    for part in parts:
        yield stream.compress(part)
    yield stream.flush()


def _key_values(values: dict[bytes, bytes]) -> bytes:
    """Key/value data, sorted by key, each value ended by a NUL, each pair padded to a multiple of 4 bytes."""
    data = b""
    for key, value in sorted(values.items()):
        pair = key + b"\0" + value + b"\0"
        data += struct.pack("<I", len(pair)) + pair + bytes(-len(pair) % 4)
    return data
