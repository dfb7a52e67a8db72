# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""KTX 2.0 files: 2D textures and arrays with mip levels, optionally compressed by Zstandard.

Format: KTX File Format Specification 2.0, https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html
The first row is the bottom one: KTXorientation is "ru".
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
import zstandard

from ...core.errors import FormatError, InputError
from ...version import VERSION
from ..codecs.bc7 import Blocks
from ..disk.atomic import replacing
from ..disk.memory import check_memory
from ..disk.regular import open_regular
from .ktx2_descriptor import descriptor
from .texture import Encoded, PixelFormat, Texture, blocks_shape, size_misfit

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
_MOST_IN_A_BYTE = 1 << 15  # highest compression ratio: 4 bytes or more of Zstandard hold 128 KiB at most
_MOST_KEYS = 1 << 16  # bytes of key/value data that are read
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


def read_ktx2(path: Path) -> Texture:
    """Read a file of `write_ktx2`.

    Raises FormatError, with the path, for a file that is missing, cut short, no KTX2, too large for this
    machine's memory, or holds anything but a texture as RadTex writes it.
    """
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            header, kind = _read_header(path, file)
            index = _read_index(path, file, header, kind, size)
            _check_descriptor(path, file, header, kind)
            _check_orientation(path, file, header)
            levels = tuple(_read_level(path, file, header, kind, index, level) for level in range(len(index)))
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
    return Texture(kind, header.width, header.height, levels, header.layers > 0)


def _key_values(values: dict[bytes, bytes]) -> bytes:
    """Key/value data, sorted by key, each value ended by a NUL, each pair padded to a multiple of 4 bytes."""
    data = b""
    for key, value in sorted(values.items()):
        pair = key + b"\0" + value + b"\0"
        data += struct.pack("<I", len(pair)) + pair + bytes(-len(pair) % 4)
    return data


def _read_header(path: Path, file: BinaryIO) -> tuple[_Header, PixelFormat]:
    head = file.read(_LAYOUT.size)
    if head[: len(_MAGIC)] != _MAGIC[: len(head)] or not head:
        raise FormatError(f"{path} is not a KTX2 file")
    if len(head) < _LAYOUT.size:
        raise FormatError(f"{path} is cut short: export it again")
    header = _Header._make(_LAYOUT.unpack(head))
    kinds = {number: kind for kind, number in VK_FORMATS.items()}
    if header.vk_format not in kinds:
        raise FormatError(f"{path} holds VkFormat {header.vk_format}: save it as {', '.join(kinds.values())}")
    if header.depth or header.faces != 1:
        raise FormatError(f"{path} is no 2D texture: save it without sides and depth")
    if header.scheme not in (_NONE, _ZSTD):
        raise FormatError(f"{path} is packed by scheme {header.scheme}: pack it by Zstandard or not at all")
    if header.type_size != _TYPE_SIZES[kinds[header.vk_format]] or header.sgd_length:
        raise FormatError(f"{path} is damaged, its header cannot be read: export it again")
    if misfit := size_misfit(header.width, header.height, max(1, header.layers), header.levels):
        raise FormatError(f"{path} has {misfit}")
    return header, kinds[header.vk_format]


def _read_index(path: Path, file: BinaryIO, header: _Header, kind: PixelFormat, size: int) -> list[_Level]:
    """Read and check the level index of a file of `size` bytes, and that the levels fit into memory."""
    length = header.levels * _LEVEL_LAYOUT.size
    data = file.read(length)
    if len(data) < length:
        raise FormatError(f"{path} is cut short: export it again")
    index = [_Level._make(fields) for fields in _LEVEL_LAYOUT.iter_unpack(data)]
    for number, level in enumerate(index):
        expected = int(np.prod(_shape(header, kind, number), dtype=np.int64))
        if level.offset + level.length > size:
            raise FormatError(f"{path} is cut short: export it again")
        possible = level.length * _MOST_IN_A_BYTE if header.scheme else level.length
        packed = header.scheme or level.length == expected
        if level.unpacked != expected or possible < expected or not packed:
            raise FormatError(f"{path} is damaged, its level {number} is not of its size: export it again")
    if max(level.offset + level.length for level in index) != size:
        raise FormatError(f"{path} has more in it than one texture: export it again")
    check_memory(str(path), sum(level.length + level.unpacked for level in index))
    return index


def _shape(header: _Header, kind: PixelFormat, level: int) -> tuple[int, int, int, int]:
    return blocks_shape(kind, header.width, header.height, max(1, header.layers), level)


def _check_descriptor(path: Path, file: BinaryIO, header: _Header, kind: PixelFormat) -> None:
    ours = [descriptor(kind, premultiplied) for premultiplied in (False, True)]
    file.seek(header.dfd_offset)
    if header.dfd_length != len(ours[0]) or file.read(len(ours[0])) not in ours:
        raise FormatError(f"{path} has {kind} that RadTex does not write: export it again")


def _check_orientation(path: Path, file: BinaryIO, header: _Header) -> None:
    file.seek(header.kvd_offset)
    data = file.read(min(header.kvd_length, _MOST_KEYS))
    found = dict(_pairs(data)).get(_ORIENTATION, b"rd").rstrip(b"\0")
    if found != _UPWARDS:
        shown = found[:8].decode("latin-1")
        raise FormatError(f'{path} has the orientation {shown!r}, expected "ru", v upwards: export it again')


def _pairs(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Keys and values; a truncated last value is cut off."""
    place = 0
    while place + 4 <= len(data):
        (length,) = struct.unpack_from("<I", data, place)
        key, _, value = data[place + 4 : place + 4 + length].partition(b"\0")
        yield key, value
        place += 4 + length + -length % 4


def _read_level(
    path: Path, file: BinaryIO, header: _Header, kind: PixelFormat, index: list[_Level], level: int
) -> Blocks:
    file.seek(index[level].offset)
    data = file.read(index[level].length)
    if len(data) != index[level].length:
        raise FormatError(f"{path} was cut short while it was read: export it again")
    if header.scheme == _ZSTD:
        data = _unpacked(path, data, index[level].unpacked)
    return np.frombuffer(data, np.uint8).reshape(_shape(header, kind, level))


def _unpacked(path: Path, data: bytes, size: int) -> bytes:
    try:
        if zstandard.get_frame_parameters(data).content_size == size:
            return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    except zstandard.ZstdError as error:
        raise FormatError(f"{path} is damaged: {error}; export it again") from error
    raise FormatError(f"{path} is damaged, a level unpacks to another size: export it again")
