# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC4, BC6H's mode 11 and BC7's mode 6: decoded by the book, and encoded as near as can be."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.codecs.bc4 import decode_bc4, encode_bc4
from radtex_addon.formats.codecs.bc6h import MOST, decode_bc6h, encode_bc6h
from radtex_addon.formats.codecs.bc7 import Blocks, decode_bc7, encode_bc7

STEP = 1 / 255
WEIGHTS = (0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64)
Book = list[list[float]]


def taking(block: bytes) -> Callable[[int], int]:
    """A function that takes so many bits off a block, the lowest first."""
    left = int.from_bytes(block, "little")

    def take(count: int) -> int:
        nonlocal left
        value, left = left & ((1 << count) - 1), left >> count
        return value

    return take


def bc4_book(block: bytes) -> Book:
    """Sixteen pixels in 255ths, as the specification's tables have them."""
    channels = []
    for begin in range(0, len(block), 8):
        first, last = block[begin : begin + 2]
        bits = int.from_bytes(block[begin + 2 : begin + 8], "little")
        if first > last:
            levels = [(first * (7 - k) + last * k, 7) for k in (0, 7, 1, 2, 3, 4, 5, 6)]
        else:
            levels = [(first * (5 - k) + last * k, 5) for k in (0, 5, 1, 2, 3, 4)] + [(0, 1), (255, 1)]
        channels.append([float(Fraction(*levels[bits >> 3 * pixel & 7])) for pixel in range(16)])
    return [list(pixel) for pixel in zip(*channels, strict=True)]


def bc6h_book(block: bytes) -> Book:
    """Mode 11 bit by bit: sixteen RGB pixels in half floats' bits."""
    take = taking(block)

    def unquantised(code: int) -> int:
        return {0: 0, 1023: 0xFFFF}.get(code, ((code << 16) + 0x8000) >> 10)

    assert take(5) == 3
    first, last = ([unquantised(take(10)) for _ in range(3)] for _ in range(2))
    indices = [take(3), *(take(4) for _ in range(15))]
    return [
        [((((64 - w) * a + w * b + 32) >> 6) * 31) >> 6 for a, b in zip(first, last, strict=True)]
        for w in (WEIGHTS[index] for index in indices)
    ]


def bc7_book(block: bytes) -> Book:
    """Mode 6 bit by bit: sixteen RGBA pixels of 8 bits."""
    take = taking(block)
    assert take(7) == 64
    ends = [[take(7) << 1, take(7) << 1] for _ in range(4)]
    shared = [take(1), take(1)]
    indices = [take(3), *(take(4) for _ in range(15))]
    return [
        [((64 - w) * (a | shared[0]) + w * (b | shared[1]) + 32) >> 6 for a, b in ends]
        for w in (WEIGHTS[index] for index in indices)
    ]


def bits(image: Floats) -> Floats:
    """The bits of half floats as numbers: the measure in which BC6H's encoder fits."""
    return image.astype(np.float16).view(np.uint16).astype(np.float64)


def codes(image: Floats) -> Floats:
    """255ths."""
    return image.astype(np.float64) * 255


@dataclass(frozen=True, eq=False)
class Codec:
    """`measure` gives what the `book` has; in the first byte of our mode `mode` is what `mask` leaves."""

    encode: Callable[[Floats], Blocks]
    decode: Callable[[Blocks], Floats]
    channels: int
    book: Callable[[bytes], Book]
    measure: Callable[[Floats], Floats] = codes
    most: float = 1.0
    mask: int = 0xFF
    mode: int = 0

    def random_blocks(self, seed: int = 1, rows: int = 8, columns: int = 8) -> Blocks:
        """Any blocks of our mode: all other bits are free."""
        size = 8 if self.channels == 1 else 16
        blocks = np.random.default_rng(seed).integers(0, 256, (rows, columns, size), np.uint8)
        blocks[..., 0] = (blocks[..., 0] & self.mask) | self.mode
        return blocks

    def again(self, image: Floats) -> Floats:
        return self.decode(self.encode(image.astype(np.float32)))


BC4 = Codec(encode_bc4, decode_bc4, 1, bc4_book)
BC6H = Codec(encode_bc6h, decode_bc6h, 3, bc6h_book, bits, MOST, 0xE0, 0b00011)
BC7 = Codec(encode_bc7, decode_bc7, 4, bc7_book, mask=0x80, mode=0x40)
each = pytest.mark.parametrize("codec", [BC4, BC6H, BC7], ids=["BC4", "BC6H", "BC7"])
lines = pytest.mark.parametrize("codec", [BC6H, BC7], ids=["BC6H", "BC7"])  # between two ends of all channels


def spread(values: Floats) -> Floats:
    """An image whose blocks have one value each, of `values` (rows, columns, C)."""
    return values.repeat(4, axis=0).repeat(4, axis=1).astype(np.float32)


@each
def test_any_block_decodes_as_the_specification_says(codec: Codec) -> None:
    blocks = codec.random_blocks(2)
    if codec is BC6H:  # the ends that the rule for all others does not give
        blocks[0, 0, 1:8], blocks[0, 1, 1:8] = 0, 255
    elif codec is not BC7:  # equal ends
        blocks[0, 0, [0, 1, -8, -7]] = 90
    image = codec.decode(blocks)
    assert image.dtype == np.float32
    for row, column in np.ndindex(*blocks.shape[:2]):
        square = image[4 * row : 4 * row + 4, 4 * column : 4 * column + 4].reshape(16, codec.channels)
        book = codec.book(blocks[row, column].tobytes())
        np.testing.assert_allclose(codec.measure(square), book, rtol=0, atol=1e-4)


@each
def test_what_is_beyond_the_range_is_clamped(codec: Codec) -> None:
    image = np.full((4, 8, codec.channels), np.inf, np.float32)
    image[::2, :4] = 2 * codec.most
    image[:, 4:] = -np.inf
    image[::2, 4:], image[1, 4:] = -3, -0.0
    decoded = codec.again(image)
    assert np.all(decoded[:, :4] == codec.most)
    assert np.all(decoded[:, 4:] == 0)


@each
def test_black_and_the_brightest_in_one_block(codec: Codec) -> None:
    image = np.zeros((4, 4, codec.channels), np.float32)
    image[1::2] = codec.most
    off = np.abs(codec.again(image) - image).max()
    assert off <= (1.01 * STEP if codec is BC7 else 0)  # whose ends share their lowest bits


@each
def test_other_images_and_blocks_are_refused(codec: Codec) -> None:
    shape = rf"\(H, W, {codec.channels}\) of floats, got \(4, 4, {codec.channels + 1}\) of float32"
    with pytest.raises(ShapeError, match=shape):
        codec.encode(np.zeros((4, 4, codec.channels + 1), np.float32))
    for wrong in ((6, 8, codec.channels), (8, 6, codec.channels), (8, 8), (0, 8, codec.channels)):
        with pytest.raises(ShapeError):
            codec.encode(np.zeros(wrong, np.float32))
    image = np.zeros((8, 8, codec.channels), np.float32)
    image[3, 4, -1] = np.nan
    with pytest.raises(InputError, match="1 of its values are not numbers"):
        codec.encode(image)
    blocks = codec.random_blocks()
    with pytest.raises(ShapeError, match=rf"\(rows, columns, {blocks.shape[2]}\)"):
        codec.decode(blocks[..., :-1])
    with pytest.raises(ShapeError, match="uint8"):
        codec.decode(blocks.astype(np.int16))


_MODES_OF_BC6H = {0: "mode 1", 1: "mode 2", 2: "mode 3", 0b11110: "mode 10", 0b00111: "mode 12"}
_MODES_OF_BC6H |= {0b01111: "mode 14", 0b10011: "a reserved mode", 0b11111: "a reserved mode"}
_MODES_OF_BC7 = {1 << mode | (0xFE << mode & 0xFF): f"mode {mode}" for mode in (0, 1, 2, 3, 4, 5, 7)}


@pytest.mark.parametrize(
    ("codec", "code", "says"),
    [
        *((BC6H, code | 0xA0, f"of BC6H's {name}:") for code, name in _MODES_OF_BC6H.items()),
        *((BC7, code, f"of BC7's {name}:") for code, name in (_MODES_OF_BC7 | {0: "no mode"}).items()),
    ],
)
def test_other_modes_are_refused_by_name(codec: Codec, code: int, says: str) -> None:
    blocks = codec.random_blocks()
    blocks[3, 2, 0] = code
    with pytest.raises(FormatError, match=f"block 26 is {says}"):
        codec.decode(blocks)


@each
def test_a_million_pixels_take_seconds(codec: Codec) -> None:
    image = np.random.default_rng(10).random((256, 256, codec.channels)).astype(np.float32)
    begin = time.process_time()
    codec.encode(image)
    assert 16 * (time.process_time() - begin) < 10


@lines
def test_what_a_line_can_hold_comes_back(codec: Codec) -> None:
    """Random ends and indices: mostly to the bit, though the search may end beside the best."""
    image = codec.decode(codec.random_blocks(8, 16, 16))
    off = np.abs(codec.measure(codec.again(image)) - codec.measure(image))
    same, rms = np.mean(off < 0.5), np.sqrt(np.mean(off**2))
    print(f"{same:.1%} of random blocks' values come back exactly, rms {rms:.2f}")
    assert same > 0.9
    assert rms < (100 if codec is BC6H else 0.64)


@lines
def test_noise_is_nearer_than_to_its_blocks_means(codec: Codec) -> None:
    """A line explains at least the greatest of the channels' variances."""
    image = np.random.default_rng(5).random((64, 64, codec.channels)).astype(np.float32)
    if codec is BC6H:
        image = np.exp2(16 * image - 8)
    squares = codec.measure(image).reshape(16, 4, 16, 4, -1)
    about_mean = np.square(squares - squares.mean(axis=(1, 3), keepdims=True)).sum()
    error = np.square(codec.measure(codec.again(image)) - codec.measure(image)).sum()
    assert error < (1 - 1 / codec.channels) * about_mean


@given(st.sampled_from([BC6H, BC7]), arrays(np.float32, (4, 4, 4), elements=st.floats(0, 1, width=32)))
def test_no_block_is_worse_than_its_mean(codec: Codec, image: Floats) -> None:
    image = image[..., : codec.channels] * np.float32(codec.most)
    values = codec.measure(image)
    about_mean = np.square(values - values.mean(axis=(0, 1))).sum()
    error = np.square(codec.measure(codec.again(image)) - values).sum()
    # A step of the ends, half of one in BC6H: both ends of the range may be in it.
    assert error <= about_mean + (48 * 24**2 if codec is BC6H else 64 * 1.01)


def test_blocks_do_not_know_each_other() -> None:
    image = np.random.default_rng(9).random((136, 140, 4)).astype(np.float32)
    blocks = encode_bc7(image)
    assert blocks.shape == (34, 35, 16)
    np.testing.assert_array_equal(encode_bc7(image[60:64, 136:140])[0, 0], blocks[15, 34])
    wide = np.concatenate([image.reshape(4, -1, 4)] * 4, axis=1)  # more blocks in a row than go at once
    np.testing.assert_array_equal(encode_bc7(wide)[0, -1], encode_bc7(wide[:, -4:])[0, 0])


# BC4


def test_blocks_of_one_value_are_exact_to_eight_bits() -> None:
    """Between 255ths there are seven levels."""
    whole = spread(np.random.default_rng(1).permutation(256).reshape(16, 16, 1) / 255)
    np.testing.assert_array_equal(BC4.again(whole), whole)
    between = spread(np.random.default_rng(1).random((32, 64, 1)))
    assert np.abs(BC4.again(between) - between).max() <= STEP / 13.9
    codes = np.array([[7, 255, 0, 128]])
    expected = np.zeros((1, 4, 8), np.uint8)  # its code twice and index 0
    expected[..., :2] = codes[..., None]
    np.testing.assert_array_equal(encode_bc4(spread(codes[..., None] / 255)), expected)


def test_what_eight_levels_can_hold_comes_back() -> None:
    """Random ends, at least a few steps apart, and indices, both ends among them."""
    blocks = np.random.default_rng(3).integers(0, 256, (16, 64, 8), np.uint8)
    blocks[..., 1], blocks[..., 0] = blocks[..., 1] % 128, blocks[..., 0] % 120 + 135
    blocks[..., 2] = blocks[..., 2] & 0xC0 | 0b001_000
    image = decode_bc4(blocks)
    np.testing.assert_allclose(BC4.again(image), image, atol=1e-6)
    words = encode_bc4(np.random.default_rng(1).random((64, 128, 1)).astype(np.float32)).reshape(-1, 8)
    assert (words[:, 0] > words[:, 1]).all()  # eight, wherever a block has two values


@given(arrays(np.float32, (4, 4, 1), elements=st.floats(0, 1, width=32)))
def test_no_value_is_further_off_than_half_a_level(image: Floats) -> None:
    """About the ends around all values; what least squares make of a block is no worse on the whole."""
    values = image * 255
    span = np.ceil(values.max(axis=(0, 1))) - np.floor(values.min(axis=(0, 1)))
    wrong = np.square(BC4.again(image) - image).sum(axis=(0, 1))
    assert (wrong <= 16 * np.square((span / 14 + 1e-4) * STEP)).all()


@pytest.mark.parametrize("seed", range(4))
def test_no_other_ends_are_much_better(seed: int) -> None:
    """All pairs of ends for one channel of a block."""
    values = np.random.default_rng(seed).random((4, 4))
    pairs = np.array(list(combinations_with_replacement(range(256), 2))) / 255
    levels = pairs[:, :1] + (pairs[:, 1:] - pairs[:, :1]) * np.arange(8) / 7
    wrong = np.abs(levels[:, None] - values.reshape(16, 1)).min(axis=2)
    best = np.square(wrong).sum(axis=1).min()
    image = values[..., None].astype(np.float32)
    assert np.square(BC4.again(image) - image).sum() < 2 * best


# BC6H


def light(height: int = 256, width: int = 384) -> Floats:
    """A smooth image (height, width, 3) over about nine octaves."""
    y, x = np.mgrid[0:height, 0:width] / 512
    octave = np.stack([6 * np.sin(4 * x + y), 5 * np.cos(3 * x * y), 8 * x - 4 * y], axis=-1)
    return np.exp2(octave).astype(np.float32)


def test_smooth_light_comes_back_within_a_small_part_of_itself() -> None:
    image = light()
    relative = np.abs(BC6H.again(image) - image) / image
    assert relative.mean() < 0.015
    slow = 0.3 + 0.02 * image**0.25
    relative = np.abs(BC6H.again(slow) - slow) / slow
    assert relative.mean() < 0.002
    assert relative.max() < 0.02


def test_grey_noise_has_sixteen_levels() -> None:
    octave = np.random.default_rng(6).uniform(-2, 2, (64, 64, 1))
    image = np.repeat(np.exp2(octave), 3, axis=2).astype(np.float32)
    off = np.abs(bits(BC6H.again(image)) - bits(image))
    assert off.max() <= 4096 * 5 / 64 / 2 + 48  # half of the widest spacing, and what the ends are off


def test_blocks_of_one_value_are_exact_half_floats() -> None:
    """Zero and the largest too; what lies about them is at most half a step of an end off."""
    octave = np.random.default_rng(7).uniform(np.log2(1e-4), np.log2(3e4), (64, 64, 3))
    image = spread(np.exp2(octave).astype(np.float16))
    np.testing.assert_array_equal(BC6H.again(image), image)
    ends = np.array((0, MOST, 6e-8, 1e-6, 3e-5, 6e-5, 4e4, 6e4, 65472), np.float32)
    image = spread(ends[None, :, None].repeat(3, axis=2))
    decoded = BC6H.again(image)
    np.testing.assert_array_equal(decoded[:, :8], image[:, :8])
    assert np.abs(bits(decoded) - bits(image)).max() <= 24


# BC7


def test_a_smooth_image_is_nearly_as_good_as_eight_bits() -> None:
    y, x = np.mgrid[0:256, 0:384] / 512
    waves = (0.5 + 0.5 * np.sin(7 * x + 3 * y), 0.5 + 0.4 * np.cos(5 * x * y), x * y, 1 - 0.3 * x)
    whole = np.stack(waves, axis=-1).astype(np.float32)
    for image, decibels in ((whole, 4), (0.3 + 0.05 * whole, 1)):
        wrong, rounded = BC7.again(image) - image, np.rint(image * 255) / 255 - image
        assert 10 * np.log10(np.mean(wrong**2) / np.mean(rounded**2)) < decibels
        assert np.abs(wrong).max() < 1.5 * STEP or image is whole


def test_pixels_on_one_line_lose_what_sixteen_levels_lose() -> None:
    """The levels' spacing over the root of 12, as by any rounding, and that of ends and levels themselves."""
    ends = np.random.default_rng(3).random((2, 256, 1, 4))
    place = np.random.default_rng(4).random((256, 16, 1))
    image = (ends[0] + (ends[1] - ends[0]) * place).reshape(256 * 4, 4, 4)
    wrong = np.square(BC7.again(image) - image).sum() / 16
    assert wrong < np.square((ends[1] - ends[0]) / 15).sum() / 12 + 4 * 256 * STEP**2 / 6


def test_one_channel_of_noise_has_sixteen_levels() -> None:
    image = np.zeros((64, 64, 4), np.float32)
    image[..., 2] = np.random.default_rng(6).random((64, 64))
    wrong = BC7.again(image) - image
    assert np.abs(wrong[..., 2]).max() < 1 / 30 + 2.5 * STEP
    assert np.abs(wrong[..., [0, 1, 3]]).max() < 1.5 * STEP


def test_bc7s_blocks_of_one_value_are_exact_to_eight_bits() -> None:
    values = np.random.default_rng(7).integers(0, 256, (4096, 4))
    values[:256] = np.arange(256)[:, None]
    values[256:512] = np.arange(256)[:, None] * (1, 0, 0, 1)
    values[512:768] = 255 - np.arange(256)[:, None] * (1, 0, 0, 1)
    decoded = np.rint(BC7.again(spread(values.reshape(64, 64, 4) / np.float32(255))) * 255)
    wrong = np.abs(decoded[::4, ::4].reshape(-1, 4) - values)
    impossible = (values == 0).any(axis=1) & (values == 255).any(axis=1)
    assert wrong[~impossible].max() == 0
    assert impossible.any()
    assert wrong[impossible].max() == 1
