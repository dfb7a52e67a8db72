# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC3, which OpenGL calls S3TC DXT5: a colour and an alpha that have nothing to do with one another.

Format: Khronos Data Format Specification 1.3, chapter "S3TC Compressed Texture Image Formats", section "BC3",
https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#S3TC

A block's low word is alpha as BC4 has it, its high word two colours of 5, 6 and 5 bits and an index of two
bits for each pixel: 0 and 1 are the colours, 2 and 3 lie a third and two thirds of the way between them.
"""

from __future__ import annotations

import numpy as np

from ...core.arrays import Bools, Floats
from .bc4 import channel_values, encode_bc4
from .bc7 import PIXELS, SIDE, Blocks, Words, image_of, words_of

_BITS, _SHIFTS = (5, 6, 5), (11, 5, 0)  # of a colour's channels
_LAST = 3  # steps between the two colours
_INDICES = np.array([0, 2, 3, 1], np.uint64)  # by the number of steps
_STEPS = np.array([0, 3, 1, 2], np.float32)  # and the inverse
_ROUNDS = 4  # of least squares
_LIGHT = 0.05  # of a block's greatest weight: pixels of less do not stretch the line


def encode_bc3(image: Floats, weight: Floats) -> Blocks:
    """Blocks (H/4, W/4, 16) of an image (H, W, 4) in 0..1, whose colours count by `weight` (H, W), above 0.

    What is made small is the weighted sum of squared errors. Raises ShapeError for a size that is no multiple
    of 4, InputError for values that are not numbers.
    """
    alpha = encode_bc4(image[..., 3:])
    values = np.clip(_squares(image[..., :3]), 0, 1).astype(np.float32)
    first, last, steps = _fitted(values, _squares(weight[..., None])[0].astype(np.float32))
    word = np.zeros(values.shape[2], np.uint64)
    for channel, (bits, shift) in enumerate(zip(_BITS, _SHIFTS, strict=True)):
        for end, place in ((first, 0), (last, 16)):
            code = np.rint(end[channel] * (2**bits - 1)).astype(np.uint64)
            word |= code << np.uint64(shift + place)
    for pixel in range(PIXELS):
        word |= _INDICES[steps[pixel].astype(np.intp)] << np.uint64(32 + 2 * pixel)
    words: Words = np.stack([words_of(alpha, 1)[0], word])
    return np.ascontiguousarray(words.T.astype("<u8")).view(np.uint8).reshape(*alpha.shape[:2], PIXELS)


def decode_bc3(blocks: Blocks) -> Floats:
    """The image (H, W, 4) float32 in 0..1 of blocks (H/4, W/4, 16), not rounded between a block's colours.

    Raises ShapeError for another shape or type.
    """
    low, word = words_of(blocks)
    ends = np.empty((2, 3, word.size), np.float32)
    for channel, (bits, shift) in enumerate(zip(_BITS, _SHIFTS, strict=True)):
        for end in range(2):
            code = (word >> np.uint64(shift + 16 * end)) & np.uint64(2**bits - 1)
            ends[end, channel] = code.astype(np.float32) / (2**bits - 1)
    shifts = np.arange(32, 64, 2, dtype=np.uint64)[:, None]
    steps = _STEPS[((word >> shifts) & np.uint64(3)).astype(np.intp)] / _LAST
    colours = ends[0][:, None] * (1 - steps) + ends[1][:, None] * steps
    return image_of(np.concatenate([colours, channel_values(low[None])]), blocks)


def _squares(image: Floats) -> Floats:
    """Pixels (C, 16, N) of an image (H, W, C)."""
    height, width, channels = image.shape
    squares = image.reshape(height // SIDE, SIDE, width // SIDE, SIDE, channels)
    return squares.transpose(4, 1, 3, 0, 2).reshape(channels, PIXELS, -1)


def _fitted(values: Floats, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Representable ends (3, N) and steps (16, N) from the first to the last that come near (3, 16, N)."""
    total = weight.sum(axis=0)
    mean = (values * weight).sum(axis=1) / total
    centred = values - mean[:, None]
    covariance = np.einsum("apn,bpn->nab", centred * weight, centred)
    axis = np.linalg.eigh(covariance)[1][:, :, -1].T  # eigh's values ascend
    place = np.where(weight > _LIGHT * weight.max(axis=0), (centred * axis[:, None]).sum(axis=0), 0)
    ends = [mean + axis * place.min(axis=0), mean + axis * place.max(axis=0)]
    least = np.full(values.shape[2], np.inf, np.float32)
    best = [np.zeros_like(mean), np.zeros_like(mean), np.zeros_like(weight)]
    for _ in range(_ROUNDS):
        first, last = (_rounded(end) for end in ends)
        along = last - first
        length = np.maximum((along * along).sum(axis=0), np.float32(1e-9))
        foot = ((values - first[:, None]) * along[:, None]).sum(axis=0) / length
        steps = np.clip(np.rint(foot * _LAST), 0, _LAST)
        share = steps / _LAST
        wrong = first[:, None] + along[:, None] * share - values
        error = (wrong * wrong * weight).sum(axis=(0, 1))
        better: Bools = error < least
        for kept, other in zip((least, *best), (error, first, last, steps), strict=True):
            np.copyto(kept, other, where=better)
        ends = _least_squares(values, weight, share, mean)
    return best[0], best[1], best[2]


def _least_squares(values: Floats, weight: Floats, share: Floats, mean: Floats) -> list[Floats]:
    """The ends (3, N) that suit the shares (16, N) best; the mean where all of these are alike."""
    near, far = (1 - share) * weight, share * weight
    first, both, last = (
        (near * (1 - share)).sum(axis=0),
        (near * share).sum(axis=0),
        (far * share).sum(axis=0),
    )
    determinant = first * last - both * both
    told = determinant > 1e-6 * weight.sum(axis=0) ** 2
    divisor = np.where(told, determinant, 1)
    right, left = (far * values).sum(axis=1), (near * values).sum(axis=1)
    return [
        np.where(told, (last * left - both * right) / divisor, mean),
        np.where(told, (first * right - both * left) / divisor, mean),
    ]


def _rounded(end: Floats) -> Floats:
    """The nearest colours (3, N) of 5, 6 and 5 bits."""
    most = np.array([2**bits - 1 for bits in _BITS], np.float32)[:, None]
    return np.clip(np.rint(end * most), 0, most) / most
