# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Unsigned BC4 (UNORM), in OpenGL RGTC1: one channel, with two ends of its own in each block.

Format: Khronos Data Format Specification 1.3, chapter "RGTC Compressed Texture Image Formats", section "BC4
unsigned", https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#RGTC

A block is one word: the ends have eight bits each, a pixel's index has three. If the first end is greater
than the last, there are eight levels between them, else six, and 0 and 1. Blocks are arrays as in bc7: N
blocks of C channels, which have nothing to do with each other, (C, 16, N), their words (C, N).
"""

from __future__ import annotations

import numpy as np

from ...core.arrays import Bools, Floats, Ints
from .bc7 import PIXELS, Blocks, Words, encoded, image_of, words_of

_MOST = 255
_STEPS, _FEWER_STEPS = 7, 5  # between the ends, of eight levels and of six
_ZERO, _ONE = 6, 7  # indices of 0 and 1 where there are six levels
# For each index, the number of steps from the last end. With six levels index 6 means 0 and 7 means 1.
_PLACES = np.array((7, 0, 6, 5, 4, 3, 2, 1), np.uint8)
_FEWER_PLACES = np.array((5, 0, 4, 3, 2, 1, 0, 0), np.uint8)
_INDICES = np.argsort(_PLACES).astype(np.uint8)  # by place
_ROUNDS = 2  # of least squares
_SHIFTS = np.arange(16, 16 + 3 * PIXELS, 3, dtype=np.uint64)[:, None]  # of the indices in a word


def encode_bc4(image: Floats) -> Blocks:
    """Encode an image (H, W, 1) in 0..1 as blocks (H/4, W/4, 8); values outside are clamped.

    A block has eight levels between two ends, found by least squares, or one level if the ends are equal. A
    block of one value decodes exactly if that is a multiple of 1/255, else to within 1/14 of 1/255. Raises
    ShapeError for another shape or a size that is no multiple of 4, InputError for values that are not
    numbers.
    """
    return encoded(image, 1, 1.0, channel_words, 1)


def decode_bc4(blocks: Blocks) -> Floats:
    """Decode any blocks (H/4, W/4, 8) as a GPU does: an image (H, W, 1) float32 in 0..1.

    Levels between the ends are not rounded, while 8-bit decoders round them down to multiples of 1/255.
    Raises ShapeError for another shape or type.
    """
    return image_of(channel_values(words_of(blocks, 1)), blocks)


def channel_values(words: Words) -> Floats:
    """Decode words (C, N): pixels (C, 16, N) float32 in 0..1."""
    first, last = ((words[:, None] >> np.uint64(shift)) & np.uint64(_MOST) for shift in (0, 8))
    indices: Ints = ((words[:, None] >> _SHIFTS) & np.uint64(7)).astype(np.uint8)
    eight: Bools = first > last
    values: Floats = np.where(
        eight,
        _between(last, first, _PLACES[indices], _STEPS),
        _between(last, first, _FEWER_PLACES[indices], _FEWER_STEPS),
    )
    values[~eight & (indices == _ZERO)] = 0
    values[~eight & (indices == _ONE)] = 1
    return values


def _between(low: Words, high: Words, place: Ints, steps: int) -> Floats:
    """Levels in 0..1: `place` of `steps` steps from low to high, which are in 255ths; rounded only once."""
    start, span = low.astype(np.float32), high.astype(np.float32) - low.astype(np.float32)
    values: Floats = (start * steps + span * place) / np.float32(_MOST * steps)
    return values


def channel_words(pixels: Floats) -> Words:
    """Encode pixels (2, 16, N) in 0..1 as words."""
    low, high, place = _fitted(pixels * np.float32(_MOST))
    indices = np.where(low < high, _INDICES[place], 0).astype(np.uint64)
    words: Words = high[:, 0].astype(np.uint64) | low[:, 0].astype(np.uint64) << np.uint64(8)
    words |= np.bitwise_or.reduce(indices << _SHIFTS, axis=1)
    return words


def _fitted(values: Floats) -> tuple[Floats, Floats, Ints]:
    """Fit ends in whole 255ths, (C, 1, N) each, and places between them to values (C, 16, N).

    The ends begin at the least and greatest values and are refined by least squares where that helps.
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
    """The places (C, 16, N) of the levels nearest to values, and the sums of squared errors (C, 1, N)."""
    step = (high - low) / np.float32(_STEPS)
    place = np.clip(np.rint((values - low) / np.where(step > 0, step, 1)), 0, _STEPS)
    wrong = low + place * step - values
    return place.astype(np.uint8), np.square(wrong).sum(axis=1, keepdims=True)


def _least_squares(values: Floats, place: Ints) -> tuple[Floats, Floats]:
    """Least-squares ends (C, 1, N) for the places, not rounded; the mean where all places are equal."""
    mean = values.mean(axis=1, keepdims=True)
    middle = place.mean(axis=1, keepdims=True, dtype=np.float32)
    about = place - middle
    square = np.square(about).sum(axis=1, keepdims=True)
    along = np.maximum((about * (values - mean)).sum(axis=1, keepdims=True), 0)
    step = along / np.where(square > 0, square, 1)
    return mean - middle * step, mean + (_STEPS - middle) * step
