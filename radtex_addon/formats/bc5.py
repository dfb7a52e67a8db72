# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC5 without signs (UNORM), which OpenGL calls RGTC2: two channels, each with two ends of its own a block.

Format: Khronos Data Format Specification 1.3, chapter "RGTC Compressed Texture Image Formats", sections "BC4
unsigned" and "BC5 unsigned", https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#RGTC

Each channel is a block of BC4, one word: the ends have eight bits each, a pixel's index has three. Where the
first end is the greater there are eight levels from it to the last, else six, and 0 and 1. Blocks are arrays
as in bc7: N of two channels (2, 16, N), their words (2, N).
"""

from __future__ import annotations

import numpy as np

from ..core.arrays import Bools, Floats, Ints
from .bc7 import PIXELS, Blocks, Words, encoded, image_of, words_of

_MOST = 255
_STEPS, _FEWER_STEPS = 7, 5  # between the ends, of eight levels and of six
_ZERO, _ONE = 6, 7  # indices of 0 and 1 where there are six levels
# By index, how many steps from the last end. Where there are six levels, index 6 is 0 and 7 is 1.
_PLACES = np.array((7, 0, 6, 5, 4, 3, 2, 1), np.uint8)
_FEWER_PLACES = np.array((5, 0, 4, 3, 2, 1, 0, 0), np.uint8)
_INDICES = np.argsort(_PLACES).astype(np.uint8)  # by place
_ROUNDS = 2  # of least squares
_SHIFTS = np.arange(16, 16 + 3 * PIXELS, 3, dtype=np.uint64)[:, None]  # of the indices in a word


def encode_bc5(image: Floats) -> Blocks:
    """Blocks (H/4, W/4, 16) of an image (H, W, 2) in 0..1; what lies outside is clamped.

    Each channel of a block has eight levels between ends of its own, found by least squares, or one where
    both are equal. A block of one value comes back exactly if that is a whole 255th, else to within a 14th of
    one. Raises ShapeError for another shape or a size that is no multiple of 4, InputError for values that
    are not numbers.
    """
    return encoded(image, 2, 1.0, _words)


def decode_bc5(blocks: Blocks) -> Floats:
    """The image (H, W, 2) float32 in 0..1 of any blocks (H/4, W/4, 16), as a GPU has it.

    Levels between the ends are not rounded; decoders of eight bits cut off what is below a 255th. Raises
    ShapeError for another shape or type.
    """
    words = words_of(blocks)
    first, last = ((words[:, None] >> np.uint64(shift)) & np.uint64(_MOST) for shift in (0, 8))
    indices: Ints = ((words[:, None] >> _SHIFTS) & np.uint64(7)).astype(np.uint8)
    eight: Bools = first > last
    values = np.where(
        eight,
        _between(last, first, _PLACES[indices], _STEPS),
        _between(last, first, _FEWER_PLACES[indices], _FEWER_STEPS),
    )
    values[~eight & (indices == _ZERO)] = 0
    values[~eight & (indices == _ONE)] = 1
    return image_of(values, blocks)


def _between(low: Words, high: Words, place: Ints, steps: int) -> Floats:
    """Levels, in 0..1, `place` of `steps` up from ends in 255ths, rounded once."""
    start, span = low.astype(np.float32), high.astype(np.float32) - low.astype(np.float32)
    values: Floats = (start * steps + span * place) / np.float32(_MOST * steps)
    return values


def _words(pixels: Floats) -> Words:
    """Words of pixels (2, 16, N) in 0..1."""
    low, high, place = _fitted(pixels * np.float32(_MOST))
    indices = np.where(low < high, _INDICES[place], 0).astype(np.uint64)
    words: Words = high[:, 0].astype(np.uint64) | low[:, 0].astype(np.uint64) << np.uint64(8)
    words |= np.bitwise_or.reduce(indices << _SHIFTS, axis=1)
    return words


def _fitted(values: Floats) -> tuple[Floats, Floats, Ints]:
    """Ends in whole 255ths, (C, 1, N) each, and places between them that come near values (C, 16, N).

    The ends begin around all values and are then moved by least squares, for as long as that helps.
    """
    low, high = np.floor(values.min(axis=1, keepdims=True)), np.ceil(values.max(axis=1, keepdims=True))
    place, error = _nearest(values, low, high)
    for _ in range(_ROUNDS):
        lower, higher = (np.clip(np.rint(end), 0, _MOST) for end in _least_squares(values, place))
        nearer, less = _nearest(values, lower, higher)
        better: Bools = less < error
        for best, other in ((low, lower), (high, higher), (place, nearer), (error, less)):
            np.copyto(best, other, where=better)
    return low, high, place


def _nearest(values: Floats, low: Floats, high: Floats) -> tuple[Ints, Floats]:
    """The levels nearest to values, as places (C, 16, N), and the sums of squared errors, (C, 1, N)."""
    step = (high - low) / np.float32(_STEPS)
    place = np.clip(np.rint((values - low) / np.where(step > 0, step, 1)), 0, _STEPS)
    wrong = low + place * step - values
    return place.astype(np.uint8), np.square(wrong).sum(axis=1, keepdims=True)


def _least_squares(values: Floats, place: Ints) -> tuple[Floats, Floats]:
    """The ends (C, 1, N), not rounded, that suit the places best; the mean where all places are alike."""
    mean = values.mean(axis=1, keepdims=True)
    middle = place.mean(axis=1, keepdims=True, dtype=np.float32)
    about = place - middle
    square = np.square(about).sum(axis=1, keepdims=True)
    along = np.maximum((about * (values - mean)).sum(axis=1, keepdims=True), 0)
    step = along / np.where(square > 0, square, 1)
    return mean - middle * step, mean + (_STEPS - middle) * step
