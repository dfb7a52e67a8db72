# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC7 by its mode 6, and what BC6H shares with it: pixels of a square on one line of levels.

Format: Khronos Data Format Specification 1.3, chapter "BPTC Compressed Texture Image Formats", section "BC7",
https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#BPTC

A block is 4 x 4 pixels, a line has sixteen levels. Here N blocks are arrays (C, 16, N) of channel, pixel and
block, the pixels row by row; a line's two ends are (2, C, N) and the pixels' places on it, their indices, are
(16, N).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations_with_replacement, product
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..core.arrays import Bools, Floats, Ints
from ..core.errors import FormatError, InputError, ShapeError

Blocks: TypeAlias = npt.NDArray[np.uint8]  # (rows, columns, 16): the bytes of each block
Words: TypeAlias = npt.NDArray[np.uint64]  # (2, N): the low and the high half of each block

Grid: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""What an end can be: the representable values below and above; beyond the range both are the last one."""

SIDE, PIXELS, LAST = 4, 16, 15  # of a block, its pixels, their greatest index
WEIGHTS = np.array((0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64), np.float32)  # 64ths
FLAT_INDEX = 5  # of blocks of one value, which its weight of 21 can mix from ends further away

_MODE_BIT = 6  # mode 6 is six zeros and a one
_MOST = 255.0
_AT_ONCE = 4096  # blocks: what is at work stays in the processor's cache
_FIRSTS, _LASTS = (0.0, 1.0, 2.0), (13.0, 14.0, 15.0)  # indices of the outermost pixels, as tried
_ROUNDS = 3  # of least squares; more gain nothing that could be measured


def encode_bc7(image: Floats) -> Blocks:
    """Blocks (H/4, W/4, 16) of an image (H, W, 4) in 0..1; what lies outside is clamped.

    Each block is of mode 6: one line through RGBA, ends of seven bits a channel and one that its channels
    share, indices of four bits. Channels count alike, so that they may hold any data; what is made small is
    the sum of squared errors. A block of one value comes back as the nearest 8-bit one; only where it has
    both 0 and 255 in it one of them is a step off. Raises ShapeError for another shape or a size that is no
    multiple of 4, InputError for values that are not numbers.
    """
    return encoded(image, 4, 1.0, _words)


def decode_bc7(blocks: Blocks) -> Floats:
    """The image (H, W, 4) float32 in 0..1 of blocks (H/4, W/4, 16) of mode 6, as a GPU has it: whole 255ths.

    Raises ShapeError for another shape or type, FormatError for blocks of the other modes.
    """
    words = words_of(blocks)
    low, high = words
    _check_mode(low)
    ends = np.empty((2, 4, low.size), np.float32)
    for channel, end in product(range(4), range(2)):
        shared = low >> np.uint64(63) if end == 0 else high & np.uint64(1)
        seven = (low >> np.uint64(7 + 14 * channel + 7 * end)) & np.uint64(127)
        ends[end, channel] = (seven << np.uint64(1)) | shared
    values = mixed(ends, WEIGHTS[indices_of(high)])
    return image_of(values, blocks) / np.float32(_MOST)


def encoded(image: Floats, channels: int, most: float, words: Callable[[Floats], Words]) -> Blocks:
    """Blocks (H/4, W/4, 16) of an image (H, W, channels) clamped to 0..most.

    `words` packs some pixels (channels, 16, N) float32 at a time.

    Raises ShapeError and InputError as `encode_bc7` does.
    """
    _check_image(image, channels)
    height, width = image.shape[0] // SIDE, image.shape[1] // SIDE
    blocks = np.empty((height * width, 2), "<u8")
    rows = max(1, _AT_ONCE // width)
    for first in range(0, height, rows):
        band = np.clip(image[first * SIDE : (first + rows) * SIDE], 0, most) + 0.0  # no -0
        squares = band.astype(np.float32).reshape(-1, SIDE, width, SIDE, channels)
        pixels = squares.transpose(4, 1, 3, 0, 2).reshape(channels, PIXELS, -1)
        for begin in range(0, pixels.shape[2], _AT_ONCE):
            some = words(np.ascontiguousarray(pixels[:, :, begin : begin + _AT_ONCE]))
            place = first * width + begin
            blocks[place : place + some.shape[1]] = some.T
    return blocks.view(np.uint8).reshape(height, width, PIXELS)


def words_of(blocks: Blocks) -> Words:
    """Words (2, N) of blocks (rows, columns, 16). Raises ShapeError for another shape or type."""
    if blocks.ndim != 3 or blocks.shape[2] != PIXELS or blocks.dtype != np.uint8:
        raise ShapeError(f"blocks: expected shape (rows, columns, 16) of uint8, got {described(blocks)}")
    return np.ascontiguousarray(blocks).view("<u8").reshape(-1, 2).T.astype(np.uint64)


def image_of(values: Floats, blocks: Blocks) -> Floats:
    """The image (H, W, C) of `values` (C, 16, N), the pixels of `blocks`."""
    rows, columns = blocks.shape[:2]
    squares = values.reshape(-1, SIDE, SIDE, rows, columns).transpose(3, 1, 4, 2, 0)
    return squares.reshape(rows * SIDE, columns * SIDE, -1)


def fitted(
    values: Floats, grids: Sequence[tuple[Grid, Grid]], flats: Callable[[Floats], Sequence[Floats]]
) -> tuple[Floats, Ints]:
    """Ends and indices that come near `values` (C, 16, N) float32; the first pixel's index is below 8.

    The line begins along the principal axis and is then moved by least squares. `grids` are the choices for
    the two ends, each of which is tried. `flats` gives ends for blocks of one value (C, N) at FLAT_INDEX.
    """
    mean = values.mean(axis=1)
    middle = np.full(values.shape[1:], FLAT_INDEX, np.uint8)
    best = _Best(values)
    for ends in flats(mean):
        best.offer(ends, middle)
    centred = values - mean[:, None]
    indices = _start(centred)
    for _ in range(_ROUNDS):
        line, form, _ = _least_squares(centred, indices)
        for pair in grids:
            ends = _rounded(line + mean, form, pair)
            best.offer(ends, nearest(values, ends))
        indices = best.indices
    return _anchored(best.ends, best.indices)


def mixed(ends: Floats, weights: Floats) -> Floats:
    """The values (C, 16, N) between ends at weights (16, N) in 64ths, rounded as the specification says.

    All of it is whole numbers below 2^24, which float32 holds exactly.
    """
    first, last = ends[0, :, None], ends[1, :, None]
    values: Floats = (last - first) * weights
    values += first * 64 + 32
    values *= 1 / 64
    return np.floor(values, out=values)


def nearest(values: Floats, ends: Floats) -> Ints:
    """Indices (16, N) uint8 of the levels nearest to the values' feet on the line."""
    along = ends[1] - ends[0]
    scale = LAST / np.maximum((along * along).sum(axis=0), np.float32(1e-12))
    along = along * scale
    start = (ends[0] * along).sum(axis=0)
    place = values[0] * along[0]
    for channel in range(1, len(values)):
        place += values[channel] * along[channel]
    place -= start
    np.rint(place, out=place)
    indices: Ints = np.clip(place, 0, LAST, out=place).astype(np.uint8)
    return indices


def indices_word(indices: Ints) -> npt.NDArray[np.uint64]:
    """The high word (N,) without its lowest bit: the first index has three bits, the others have four."""
    word: npt.NDArray[np.uint64] = indices[0].astype(np.uint64) << np.uint64(1)
    for pixel in range(1, PIXELS):
        word |= indices[pixel].astype(np.uint64) << np.uint64(4 * pixel)
    return word


def indices_of(high: npt.NDArray[np.uint64]) -> Ints:
    """Indices (16, N) in the blocks' high words (N,)."""
    shifts = np.arange(0, 4 * PIXELS, 4, dtype=np.uint64)[:, None]
    indices: npt.NDArray[np.uint64] = (high >> shifts) & np.uint64(LAST)
    indices[0] >>= np.uint64(1)
    return indices.astype(np.uint8)


def described(array: npt.NDArray[np.generic]) -> str:
    """For messages, such as "(4, 4, 16) of uint8"."""
    return f"{array.shape} of {array.dtype}"


class _Best:
    """The ends and indices with the least squared error of those that were offered, for each block."""

    def __init__(self, values: Floats) -> None:
        channels, pixels, count = values.shape
        self._values = values
        self._error = np.full(count, np.inf, np.float32)
        self.ends: Floats = np.zeros((2, channels, count), np.float32)
        self.indices: Ints = np.zeros((pixels, count), np.uint8)

    def offer(self, ends: Floats, indices: Ints) -> None:
        wrong = mixed(ends, _weights(indices))
        wrong -= self._values
        wrong *= wrong
        error = wrong.sum(axis=(0, 1))
        better: Bools = error < self._error
        np.copyto(self._error, error, where=better)
        np.copyto(self.ends, ends, where=better)
        np.copyto(self.indices, indices, where=better)


def _weights(indices: Ints) -> Floats:
    """WEIGHTS[indices], float32, by arithmetic: several times as fast as looking it up."""
    weights = indices * np.float32(64 / LAST)
    return np.rint(weights, out=weights)


def _start(centred: Floats) -> Ints:
    """Indices along the axis of greatest variance of values about their mean.

    The outermost pixels need not have the outermost levels: of several spreads the one is taken whose best
    line leaves the least error.
    """
    channels, _, count = centred.shape
    covariance = np.empty((count, channels, channels), np.float32)
    for row, column in combinations_with_replacement(range(channels), 2):
        product_sum = (centred[row] * centred[column]).sum(axis=0)
        covariance[:, row, column] = covariance[:, column, row] = product_sum
    axis = np.linalg.eigh(covariance)[1][:, :, -1].T  # eigh's values ascend
    place = (centred * axis[:, None]).sum(axis=0)
    place -= place.min(axis=0)
    place /= np.maximum(place.max(axis=0), np.float32(1e-12))
    best: Ints = np.zeros(place.shape, np.uint8)
    most = np.full(count, -1, np.float32)
    for first, last in product(_FIRSTS, _LASTS):
        indices = np.rint(place * (last - first) + first).astype(np.uint8)
        explained = _least_squares(centred, indices)[2]
        better: Bools = explained > most
        np.copyto(most, explained, where=better)
        np.copyto(best, indices, where=better)
    return best


def _least_squares(centred: Floats, indices: Ints) -> tuple[Floats, Floats, Floats]:
    """The ends (2, C, N) that suit the indices best, what errors in them cost, and what they explain.

    An error of (x, y) in a channel's ends costs form[0] x² + 2 form[1] x y + form[2] y², form being (3, N).
    Explained (N,) is by how much the sum of squares is less than about the mean. `centred` are values about
    their mean; where all indices are alike both ends are that mean.
    """
    second = _weights(indices)
    second *= 1 / 64
    total = second.sum(axis=0)
    square = (second * second).sum(axis=0)
    form = np.stack([PIXELS - 2 * total + square, total - square, square])
    right = (centred * second).sum(
        axis=1
    )  # about the mean the sum at the first end is minus that at the last
    determinant = form[0] * form[2] - form[1] ** 2
    scale = np.where(determinant > 1e-3, right / np.maximum(determinant, np.float32(1e-3)), 0)
    ends = np.stack([-(form[2] + form[1]) * scale, (form[0] + form[1]) * scale])
    return ends, form, (right * (ends[1] - ends[0])).sum(axis=0)


def _rounded(line: Floats, form: Floats, grids: tuple[Grid, Grid]) -> Floats:
    """Representable ends (2, C, N) about those of `line`: of the four each channel can have, the cheapest."""
    best: Floats = np.empty_like(line)
    least = np.full(line.shape[1:], np.inf, np.float32)
    for first, last in product(grids[0](line[0]), grids[1](line[1])):
        x, y = first - line[0], last - line[1]
        cost = form[0] * x * x + 2 * form[1] * x * y + form[2] * y * y
        cheaper: Bools = cost < least
        np.copyto(least, cost, where=cheaper)
        np.copyto(best[0], first, where=cheaper)
        np.copyto(best[1], last, where=cheaper)
    return best


def _anchored(ends: Floats, indices: Ints) -> tuple[Floats, Ints]:
    """The same, its ends exchanged where the first index would need its fourth bit, which is not stored."""
    turned: Bools = indices[0] > LAST // 2
    return np.where(turned, ends[::-1], ends), np.where(turned, LAST - indices, indices)


def _words(pixels: Floats) -> Words:
    """Words of pixels (4, 16, N) in 0..1."""
    values = pixels * np.float32(_MOST)
    grids = [partial(_grid, shared=shared) for shared in range(2)]
    ends, indices = fitted(values, list(product(grids, grids)), _flats)
    codes = ends.astype(np.uint64)
    low = np.full(values.shape[2], 1 << _MODE_BIT, np.uint64)
    for channel, end in product(range(4), range(2)):
        low |= (codes[end, channel] >> np.uint64(1)) << np.uint64(7 + 14 * channel + 7 * end)
    low |= (codes[0, 0] & np.uint64(1)) << np.uint64(63)
    high = indices_word(indices) | (codes[1, 0] & np.uint64(1))
    return np.stack([low, high])


def _grid(ends: Floats, shared: int) -> tuple[Floats, Floats]:
    """Ends in 255ths whose lowest bit is `shared`."""
    below = np.floor((ends - shared) / 2) * 2 + shared
    return np.clip(below, shared, 254 + shared), np.clip(below + 2, shared, 254 + shared)


def _flats(value: Floats) -> list[Floats]:
    """Ends about `value` in whole 255ths: a step to both sides where its lowest bit is not the shared one."""
    whole = np.rint(value)
    apart = [np.abs(whole % 2 - shared) for shared in range(2)]
    return [
        np.clip(np.stack([whole - step, whole + step]), shared, 254 + shared)
        for shared, step in enumerate(apart)
    ]


def _check_image(image: Floats, channels: int) -> None:
    if image.ndim != 3 or image.shape[2] != channels or image.dtype.kind != "f":
        raise ShapeError(f"image: expected shape (H, W, {channels}) of floats, got {described(image)}")
    height, width = image.shape[:2]
    if not height or not width or height % SIDE or width % SIDE:
        raise ShapeError(f"image: expected a size of whole blocks of 4 x 4 pixels, got {width} x {height}")
    wrong = np.count_nonzero(np.isnan(image))
    if wrong:
        raise InputError(f"image: {wrong} of its values are not numbers; bake it again")


def _check_mode(low: npt.NDArray[np.uint64]) -> None:
    """Raises FormatError for the first block of another mode, which is the number of zeros before a one."""
    others = np.flatnonzero((low & np.uint64(127)) != 1 << _MODE_BIT)
    if others.size:
        word = int(low[others[0]]) & 255
        mode = f"mode {(word & -word).bit_length() - 1}" if word else "no mode"
        raise FormatError(
            f"block {others[0]} is of BC7's {mode}: only mode 6 can be read, as RadTex writes it"
        )
