# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""KTX 2.0 files: 2D textures and arrays with mip levels, optionally compressed by Zstandard.

Format: KTX File Format Specification 2.0, https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html
The first row is the bottom one: KTXorientation is "ru".

The basic data format descriptor describes the pixels: Khronos Data Format Specification 1.3, chapter 5
"Khronos Basic Data Format Descriptor Block", for RGB9E5 its section "Shared exponent example";
https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html
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
from .texture import Encoded, PixelFormat

_VERSION = 2  # of the descriptor block
_RGBSDA = 1  # colour model of pixels
_MODELS = {  # and of blocks
    PixelFormat.BC3: 130,
    PixelFormat.BC3_SRGB: 130,
    PixelFormat.BC4: 131,
    PixelFormat.BC6H: 133,
    PixelFormat.BC7: 134,
    PixelFormat.BC7_SRGB: 134,
}
_BT709, _LINEAR, _SRGB = 1, 1, 2  # primaries, transfer functions
_PREMULTIPLIED = 1  # the only flag
_ALPHA = 15  # channel number; red, green and blue are 0, 1 and 2, the whole of a BC6H block is 0
_LINEARLY, _EXPONENT, _SIGNED, _FLOAT = 0x10, 0x20, 0x40, 0x80  # qualifiers, in the channel's byte
_MOST = 2**32 - 1  # what 1 is in blocks of whole numbers
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


class _Sample(NamedTuple):
    """One component in a pixel or block; its values `lower` and `upper` mean 0 or -1, and 1."""

    offset: int
    bits: int
    channel: int
    lower: int
    upper: int


def descriptor(pixel_format: PixelFormat, premultiplied: bool) -> bytes:
    """The descriptor, its total size first, for Rec.709, linear or sRGB, in pixels or blocks, or for words.

    It is the same for supercompressed files, as in the KTX specification since revision 4.
    """
    samples = _SAMPLES[pixel_format]
    size = 24 + 16 * len(samples)
    side = pixel_format.side
    block = struct.pack(
        "<IHH4B4B8B",
        0,  # vendor Khronos, descriptor type basic
        _VERSION,
        size,
        _MODELS.get(pixel_format, _RGBSDA),
        _BT709,
        _SRGB if pixel_format.is_srgb else _LINEAR,
        _PREMULTIPLIED if premultiplied else 0,
        *(side - 1, side - 1, 0, 0),
        *(pixel_format.block_bytes, 0, 0, 0, 0, 0, 0, 0),  # bytes of each plane
    )
    for sample in samples:  # all lie at the pixel's corner: positions are 0
        block += struct.pack(
            "<HBB4x2I", sample.offset, sample.bits - 1, sample.channel, sample.lower, sample.upper
        )
    return struct.pack("<I", 4 + size) + block


def _float_bits(value: float) -> int:
    (bits,) = struct.unpack("<I", struct.pack("<f", value))
    return int(bits)


def _shared_exponent() -> tuple[_Sample, ...]:
    """Each channel's mantissa and exponent; by the specification 8448 at the exponent 15 means 1."""
    samples: tuple[_Sample, ...] = ()
    for channel in range(3):
        mantissa = _Sample(9 * channel, 9, channel, 0, 8448)
        samples = (*samples, mantissa, _Sample(27, 5, channel | _EXPONENT, 15, 31))
    return samples


_SAMPLES = {
    PixelFormat.RGBA16F: tuple(
        _Sample(16 * place, 16, channel | _SIGNED | _FLOAT, _float_bits(-1), _float_bits(1))
        for place, channel in enumerate((0, 1, 2, _ALPHA))
    ),
    PixelFormat.RGBA32F: tuple(
        _Sample(32 * place, 32, channel | _SIGNED | _FLOAT, _float_bits(-1), _float_bits(1))
        for place, channel in enumerate((0, 1, 2, _ALPHA))
    ),
    PixelFormat.RGB9E5: _shared_exponent(),
    PixelFormat.R32UI: (_Sample(0, 32, 0, 0, 1),),
    PixelFormat.RG32UI: (_Sample(0, 32, 0, 0, 1), _Sample(32, 32, 1, 0, 1)),
    PixelFormat.BC6H: (_Sample(0, 128, _FLOAT, _float_bits(0), _float_bits(1)),),
    PixelFormat.BC3: (_Sample(0, 64, _ALPHA, 0, _MOST), _Sample(64, 64, 0, 0, _MOST)),
    PixelFormat.BC3_SRGB: (_Sample(0, 64, _ALPHA | _LINEARLY, 0, _MOST), _Sample(64, 64, 0, 0, _MOST)),
    PixelFormat.BC4: (_Sample(0, 64, 0, 0, _MOST),),
    PixelFormat.BC7: (_Sample(0, 128, 0, 0, _MOST),),
    PixelFormat.BC7_SRGB: (_Sample(0, 128, 0, 0, _MOST),),
}


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
