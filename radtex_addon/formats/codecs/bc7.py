# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC7 by its mode 6, and the code shared with BC6H: a block's pixels are levels on one line between two ends.

Format: Khronos Data Format Specification 1.3, chapter "BPTC Compressed Texture Image Formats", section "BC7",
https://registry.khronos.org/DataFormat/specs/1.3/dataformat.1.3.html#BPTC

A block is 4 x 4 pixels, a line has sixteen levels. Here N blocks are arrays (C, 16, N) of channel, pixel and
block, the pixels row by row; a line's two ends are (2, C, N), and the pixels' indices (level numbers) are
(16, N).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations_with_replacement, product
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ...core.arrays import Bools, Floats, Ints
from ...core.errors import FormatError, InputError, ShapeError

Blocks: TypeAlias = npt.NDArray[np.uint8]  # (rows, columns, 16): the bytes of each block
Words: TypeAlias = npt.NDArray[np.uint64]  # (2, N): the low and the high half of each block

Grid: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""Rounds ends: the next representable values below and above; outside the range both are the last one."""

SIDE, PIXELS, LAST = 4, 16, 15  # pixels along a block's side, pixels in a block, greatest index
WEIGHTS = np.array((0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64), np.float32)  # 64ths
FLAT_INDEX = 5  # for blocks of one value: its weight of 21 mixes values between representable ends

_MODE_BIT = 6  # mode 6 is six zeros and a one
_MOST = 255.0
_AT_ONCE = 4096  # blocks: so few that they stay in the processor's cache
_FIRSTS, _LASTS = (0.0, 1.0, 2.0), (13.0, 14.0, 15.0)  # indices tried for the outermost pixels
_ROUNDS = 3  # of least squares; more bring no measurable gain


def encode_bc7(image: Floats) -> Blocks:
    """Encode an image (H, W, 4) in 0..1 as blocks (H/4, W/4, 16); values outside are clamped.

    Each block uses mode 6: one line through RGBA, ends with seven bits per channel and one that the channels
    share, indices of four bits. The sum of squared errors is minimised with equal weights, so that channels
    may hold any data. A block of one value decodes to the nearest 8-bit values; only if these include both 0
    and 255, one of the two is a step off. Raises ShapeError for another shape or a size that is no multiple
    of 4, InputError for values that are not numbers.
    """
    return encoded(image, 4, 1.0, _words)


def decode_bc7(blocks: Blocks) -> Floats:
    """Decode blocks (H/4, W/4, 16) of mode 6 as a GPU does: an image (H, W, 4) float32 in 0..1, in 255ths.

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


def encoded(
    image: Floats, channels: int, most: float, words: Callable[[Floats], Words], count: int = 2
) -> Blocks:
    """Encode an image (H, W, channels), clamped to 0..most, as blocks (H/4, W/4, 8 count).

    `words` encodes blocks of pixels (channels, 16, N) float32, some at a time, as words (count, N).

    Raises ShapeError and InputError as `encode_bc7` does.
    """
    _check_image(image, channels)
    height, width = image.shape[0] // SIDE, image.shape[1] // SIDE
    blocks = np.empty((height * width, count), "<u8")
    rows = max(1, _AT_ONCE // width)
    for first in range(0, height, rows):
        band = np.clip(image[first * SIDE : (first + rows) * SIDE], 0, most) + 0.0  # no -0
        squares = band.astype(np.float32).reshape(-1, SIDE, width, SIDE, channels)
        pixels = squares.transpose(4, 1, 3, 0, 2).reshape(channels, PIXELS, -1)
        for begin in range(0, pixels.shape[2], _AT_ONCE):
            some = words(np.ascontiguousarray(pixels[:, :, begin : begin + _AT_ONCE]))
            place = first * width + begin
            blocks[place : place + some.shape[1]] = some.T
    return blocks.view(np.uint8).reshape(height, width, 8 * count)


def words_of(blocks: Blocks, count: int = 2) -> Words:
    """Words (count, N) of blocks (rows, columns, 8 count). Raises ShapeError for another shape or type."""
    size = 8 * count
    if blocks.ndim != 3 or blocks.shape[2] != size or blocks.dtype != np.uint8:
        raise ShapeError(f"blocks: expected shape (rows, columns, {size}) of uint8, got {described(blocks)}")
    return np.ascontiguousarray(blocks).view("<u8").reshape(-1, count).T.astype(np.uint64)


def image_of(values: Floats, blocks: Blocks) -> Floats:
    """Arrange `values` (C, 16, N), the decoded pixels of `blocks`, as an image (H, W, C)."""
    rows, columns = blocks.shape[:2]
    squares = values.reshape(-1, SIDE, SIDE, rows, columns).transpose(3, 1, 4, 2, 0)
    return squares.reshape(rows * SIDE, columns * SIDE, -1)


def fitted(
    values: Floats, grids: Sequence[tuple[Grid, Grid]], flats: Callable[[Floats], Sequence[Floats]]
) -> tuple[Floats, Ints]:
    """Fit ends and indices to `values` (C, 16, N) float32; the first pixel's index is below 8.

    The line begins along the principal axis and is then refined by least squares. `grids` are the choices of
    grids for the two ends; all are tried. `flats` gives ends for blocks of one value (C, N) at FLAT_INDEX.
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
    """Interpolate between ends at weights (16, N) in 64ths, rounded as in the specification: (C, 16, N).

    All numbers are integers below 2^24, which float32 represents exactly.
    """
    first, last = ends[0, :, None], ends[1, :, None]
    values: Floats = (last - first) * weights
    values += first * 64 + 32
    values *= 1 / 64
    return np.floor(values, out=values)


def nearest(values: Floats, ends: Floats) -> Ints:
    """Indices (16, N) uint8 of the levels nearest to the values' projections onto the line."""
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
    """The high word (N,), its lowest bit 0: the first index has three bits, the others have four."""
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
    """Shape and type for messages, such as "(4, 4, 16) of uint8"."""
    return f"{array.shape} of {array.dtype}"


class _Best:
    """For each block, the ends and indices with the least squared error among the candidates offered."""

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
    """WEIGHTS[indices], float32, computed, which is several times as fast as a lookup."""
    weights = indices * np.float32(64 / LAST)
    return np.rint(weights, out=weights)


def _start(centred: Floats) -> Ints:
    """Initial indices: levels along the axis of greatest variance; `centred` are values minus their mean.

    The outermost pixels need not have the outermost levels: several choices of their indices are tried, and
    the one whose least-squares line leaves the least error is taken.
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
    """Least-squares ends (2, C, N) for the indices; also the cost of errors in the ends, and the gain.

    An error of (x, y) in a channel's ends costs form[0] x² + 2 form[1] x y + form[2] y², form being (3, N).
    The gain (N,) is the reduction of the squared error compared with that about the mean. `centred` are
    values minus their mean; where all indices are equal both ends are the mean.
    """
    second = _weights(indices)
    second *= 1 / 64
    total = second.sum(axis=0)
    square = (second * second).sum(axis=0)
    form = np.stack([PIXELS - 2 * total + square, total - square, square])
    right = (centred * second).sum(
        axis=1
    )  # values about the mean sum to 0: the first end's right-hand side is minus the last one's
    determinant = form[0] * form[2] - form[1] ** 2
    scale = np.where(determinant > 1e-3, right / np.maximum(determinant, np.float32(1e-3)), 0)
    ends = np.stack([-(form[2] + form[1]) * scale, (form[0] + form[1]) * scale])
    return ends, form, (right * (ends[1] - ends[0])).sum(axis=0)


def _rounded(line: Floats, form: Floats, grids: tuple[Grid, Grid]) -> Floats:
    """Round the ends (2, C, N) of `line` to representable ones: per channel, the cheapest of four pairs."""
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
    """Swap the ends where the first index would need its fourth bit, which is not stored."""
    turned: Bools = indices[0] > LAST // 2
    return np.where(turned, ends[::-1], ends), np.where(turned, LAST - indices, indices)


def _words(pixels: Floats) -> Words:
    """Encode pixels (4, 16, N) in 0..1 as words."""
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
    """Round ends down and up to 255ths whose lowest bit is `shared`."""
    below = np.floor((ends - shared) / 2) * 2 + shared
    return np.clip(below, shared, 254 + shared), np.clip(below + 2, shared, 254 + shared)


def _flats(value: Floats) -> list[Floats]:
    """Ends for a constant `value`: in 255ths itself, or a step below and above if its lowest bit differs."""
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
    """Raise FormatError for a block of another mode, whose number is the position of the lowest set bit."""
    others = np.flatnonzero((low & np.uint64(127)) != 1 << _MODE_BIT)
    if others.size:
        word = int(low[others[0]]) & 255
        mode = f"mode {(word & -word).bit_length() - 1}" if word else "no mode"
        raise FormatError(
            f"block {others[0]} is of BC7's {mode}: only mode 6 can be read, as RadTex writes it"
        )
