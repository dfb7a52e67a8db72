# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unsigned BC6H (UF16), by the mode that Direct3D calls 11: light in one byte per pixel.

Format: Khronos Data Format Specification 1.3, chapter "BPTC Compressed Texture Image Formats", section
"BC6H", https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#BPTC

A line's ends have ten bits per channel, spread over 0..65535; a value x on the line is the half float whose
bits are floor(31 x / 64). So the fit works on the bits of half floats: about logarithmic, linear below 6e-5.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from ...core.arrays import Floats, Ints
from ...core.errors import FormatError
from .bc7 import (
    FLAT_INDEX,
    WEIGHTS,
    Blocks,
    Words,
    encoded,
    fitted,
    image_of,
    indices_of,
    indices_word,
    mixed,
    words_of,
)

MOST = 65504.0  # the largest finite half float, which is the format's largest value too

_MODE, _MODE_BITS = 0b00011, 5
_END_BITS = 10
_LAST_CODE = 1023
_STEP = 64.0  # between neighbouring ends
_BITS_PER_UNIT = 31 / 64  # a half float's bits in one of a line's 65535 units


def encode_bc6h(image: Floats) -> Blocks:
    """Encode a linear image (H, W, 3), clamped to 0..65504, as blocks (H/4, W/4, 16).

    Minimises the squared error of the half floats' bits. Neighbouring ends are 31 of these apart: a 66th to a
    33rd of a value. A block of one value from 1e-4 to 3e4 decodes exactly, rounded to a half float. Raises
    ShapeError for another shape or a size that is no multiple of 4, InputError for values that are not
    numbers.
    """
    return encoded(image, 3, MOST, _words)


def decode_bc6h(blocks: Blocks) -> Floats:
    """Decode blocks (H/4, W/4, 16) of mode 11 exactly as a GPU does: an image (H, W, 3) float32.

    Raises ShapeError for another shape or type, FormatError for blocks of the other modes.
    """
    low, high = words_of(blocks)
    _check_mode(low)
    fields = [low >> np.uint64(_MODE_BITS + _END_BITS * field) for field in range(6)]
    fields[5] |= high << np.uint64(9)  # the last field's highest bit is the high word's lowest
    codes = (np.stack(fields) & np.uint64(_LAST_CODE)).astype(np.float32)
    ends = _unquantised(codes).reshape(2, 3, -1)
    values = mixed(ends, WEIGHTS[indices_of(high)])
    bits = np.floor(values * np.float32(_BITS_PER_UNIT)).astype(np.uint16)
    return image_of(bits.view(np.float16).astype(np.float32), blocks)


def _words(pixels: Floats) -> Words:
    """Encode linear pixels (3, 16, N) in 0..MOST as words."""
    bits = pixels.astype(np.float16).view(np.uint16).astype(np.float32)
    values = (bits + 0.5) / np.float32(_BITS_PER_UNIT) - np.float32(0.5)  # the middle of what becomes `bits`
    ends, indices = fitted(values, [(_grid, _grid)], _flats)
    codes = np.floor(ends / np.float32(_STEP)).astype(np.uint64).reshape(6, -1)
    low = np.full(codes.shape[1], _MODE, np.uint64)
    for field in range(6):
        low |= codes[field] << np.uint64(_MODE_BITS + _END_BITS * field)
    high = indices_word(indices) | (codes[5] >> np.uint64(9))
    return np.stack([low, high])


def _unquantised(codes: Floats) -> Floats:
    """Ends in 0..65535 for codes in 0..1023: the middles of 1024 steps; the first is 0, the last 65535."""
    middles = codes * np.float32(_STEP) + np.float32(_STEP / 2)
    return np.where(codes <= 0, 0, np.where(codes >= _LAST_CODE, 65535, middles)).astype(np.float32)


def _grid(ends: Floats) -> tuple[Floats, Floats]:
    below = np.clip(np.floor((ends - _STEP / 2) / _STEP), 0, _LAST_CODE)
    return _unquantised(below), _unquantised(np.minimum(below + 1, _LAST_CODE))


def _flats(value: Floats) -> list[Floats]:
    """Ends of a line whose level FLAT_INDEX is `value`, as far as the range allows."""
    code = np.clip(np.rint((value - _STEP / 2) / _STEP), 0, _LAST_CODE)
    off = np.clip(np.rint(value - _unquantised(code)), -_STEP / 2, _STEP / 2).astype(np.int64)
    steps = _mixtures()[:, off + int(_STEP) // 2]
    return [_unquantised(np.clip(code + steps, 0, _LAST_CODE))]


@cache
def _mixtures() -> Ints:
    """Steps (2, 65) of both ends away from a code, so that level FLAT_INDEX moves by -32 .. 32 units.

    The ends' weights, 43 and 21, have no common divisor, so that such steps exist for every number of units.
    """
    second = int(WEIGHTS[FLAT_INDEX])
    reach = np.arange(-int(_STEP) // 2, int(_STEP) // 2 + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(reach, reach))
    moved = (int(_STEP) - second) * x + second * y
    far = np.where(moved == reach[:, None], np.maximum(np.abs(x), np.abs(y)), reach.size)
    chosen = far.argmin(axis=1)
    return np.stack([x[chosen], y[chosen]])


def _check_mode(low: npt.NDArray[np.uint64]) -> None:
    others = np.flatnonzero((low & np.uint64(31)) != _MODE)
    if others.size:
        prefix, rest = int(low[others[0]]) & 3, int(low[others[0]]) >> 2 & 7
        number = (1, 2, 3 + rest, 11 + rest)[prefix]  # as Direct3D counts the tables' rows
        mode = f"mode {number}" if number <= 14 else "a reserved mode"
        raise FormatError(
            f"block {others[0]} is of BC6H's {mode}: only mode 11 can be read, as RadTex writes it"
        )
