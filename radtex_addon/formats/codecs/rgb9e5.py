# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RGB9E5: light in four bytes per pixel, three mantissas of nine bits that share an exponent of five bits.

Format: Khronos Data Format Specification 1.3, section "Shared exponent formats",
https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html; OpenGL's EXT_texture_shared_exponent
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...core.arrays import Floats
from ...core.errors import FormatError, InputError, ShapeError

MOST = 65408.0  # 511/512 of 2^16

_BITS, _BIAS, _LAST = 9, 15, 511  # a mantissa's bits, the exponent's bias, a mantissa's greatest value
_AT_ONCE = 1 << 16  # pixels: so few that they stay in the processor's cache


def encode_rgb9e5(image: Floats) -> npt.NDArray[np.uint8]:
    """Encode a linear image (H, W, 3), clamped to 0..65408, as bytes (H, W, 4) of little-endian words.

    The error is at most 1/511 of the pixel's greatest value (for that value 0.003 stops), or 2^-25 in pixels
    below 2^-16. Raises ShapeError for another shape, InputError for values that are not numbers.
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype.kind != "f":
        raise ShapeError(f"image: expected shape (H, W, 3) of floats, got {image.shape} of {image.dtype}")
    words = np.empty(image.shape[:2], "<u4")
    rows = max(1, _AT_ONCE // max(1, image.shape[1]))
    for first in range(0, len(image), rows):
        some = image[first : first + rows].astype(np.float32)
        if wrong := np.count_nonzero(np.isnan(some)):
            raise InputError(f"image: {wrong} of its values are not numbers; bake it again")
        words[first : first + rows] = _words(np.clip(some, 0, np.float32(MOST)))
    return words.view(np.uint8).reshape(*image.shape[:2], 4)


def decode_rgb9e5(pixels: npt.NDArray[np.uint8]) -> Floats:
    """Decode pixels (H, W, 4) uint8 to an image (H, W, 3) float32. FormatError for another shape or type."""
    if pixels.ndim != 3 or pixels.shape[2] != 4 or pixels.dtype != np.uint8:
        raise FormatError(f"pixels: expected (H, W, 4) of uint8, got {pixels.shape} of {pixels.dtype}")
    words = np.ascontiguousarray(pixels).view("<u4")
    mantissas = (words >> np.array([0, _BITS, 2 * _BITS], np.uint32)) & np.uint32(_LAST)
    exponent = (words >> np.uint32(3 * _BITS)).astype(np.int32) - _BIAS - _BITS
    return np.ldexp(mantissas.astype(np.float32), exponent)


def _words(light: Floats) -> npt.NDArray[np.uint32]:
    """Words (H, W) of light (H, W, 3) within 0..MOST, float32."""
    red, green, blue = (np.ascontiguousarray(light[..., channel]) for channel in range(3))
    greatest = np.maximum(np.maximum(red, green), blue) + np.float32(0)  # no -0
    exponent = (greatest.view(np.uint32) >> np.uint32(23)).astype(np.int32) - 126  # greatest < 2^exponent
    exponent = np.maximum(exponent, -_BIAS)
    exponent += np.rint(greatest * _scale(exponent)) > _LAST  # where rounding reaches 2^exponent
    scale = _scale(exponent)
    words = (exponent + _BIAS).astype(np.uint32) << np.uint32(3 * _BITS)
    for place, values in enumerate((red, green, blue)):
        words |= np.rint(values * scale).astype(np.uint32) << np.uint32(place * _BITS)
    return words


def _scale(exponent: npt.NDArray[np.int32]) -> Floats:
    """The factor from light to mantissas, 2^(9 - exponent), made from a float32's exponent bits."""
    return ((_BITS + 127 - exponent) << np.int32(23)).view(np.float32)
