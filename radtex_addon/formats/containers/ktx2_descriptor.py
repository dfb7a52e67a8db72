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
_RGBSDA, _BC6H = 1, 133  # colour models
_BT709, _LINEAR = 1, 1  # primaries, transfer function
_PREMULTIPLIED = 1  # the only flag
_ALPHA = 15  # channel number; red, green and blue are 0, 1 and 2, the whole of a BC6H block is 0
_EXPONENT, _SIGNED, _FLOAT = 0x20, 0x40, 0x80  # qualifiers, in the same byte as the channel


class _Sample(NamedTuple):
    """One component in a pixel or block; its values `lower` and `upper` mean 0 or -1, and 1."""

    offset: int
    bits: int
    channel: int
    lower: int
    upper: int


def descriptor(pixel_format: PixelFormat, premultiplied: bool) -> bytes:
    """The descriptor, its total size first, for linear Rec.709 in RGBA16F, RGB9E5 or BC6H, or for words.

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
        _BC6H if pixel_format is PixelFormat.BC6H else _RGBSDA,
        _BT709,
        _LINEAR,
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
    PixelFormat.RGB9E5: _shared_exponent(),
    PixelFormat.R32UI: (_Sample(0, 32, 0, 0, 1),),
    PixelFormat.RG32UI: (_Sample(0, 32, 0, 0, 1), _Sample(32, 32, 1, 0, 1)),
    PixelFormat.BC6H: (_Sample(0, 128, _FLOAT, _float_bits(0), _float_bits(1)),),
}
