# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The basic data format descriptor of a KTX2 file, which describes its pixels.

Format: Khronos Data Format Specification 1.3, chapter 5 "Khronos Basic Data Format Descriptor Block", for
RGB9E5 its section "Shared exponent example"; https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from .texture import PixelFormat

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
