# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC6H's mode 11: decoded by the book, and light comes back within a fraction of itself."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.codecs.bc6h import MOST, decode_bc6h, encode_bc6h
from radtex_addon.formats.codecs.bc7 import Blocks


def random_blocks(seed: int = 1, rows: int = 8, columns: int = 8) -> Blocks:
    """Any blocks of mode 11: all other bits are free."""
    blocks = np.random.default_rng(seed).integers(0, 256, (rows, columns, 16), np.uint8)
    blocks[..., 0] = (blocks[..., 0] & 0xE0) | 0b00011
    return blocks


def bits(image: Floats) -> Floats:
    """The bits of half floats as numbers: the measure in which the encoder fits."""
    return image.astype(np.float16).view(np.uint16).astype(np.float64)


def light(height: int = 256, width: int = 384) -> Floats:
    """A smooth image (height, width, 3) over about nine octaves."""
    y, x = np.mgrid[0:height, 0:width] / 512
    octave = np.stack([6 * np.sin(4 * x + y), 5 * np.cos(3 * x * y), 8 * x - 4 * y], axis=-1)
    return np.exp2(octave).astype(np.float32)


def by_the_book(block: bytes) -> list[list[int]]:
    """Mode 11 bit by bit, as the specification's table has it: sixteen RGB pixels in half floats' bits."""
    word = int.from_bytes(block, "little")

    def take(count: int) -> int:
        nonlocal word
        value, word = word & ((1 << count) - 1), word >> count
        return value

    def unquantised(code: int) -> int:
        return {0: 0, 1023: 0xFFFF}.get(code, ((code << 16) + 0x8000) >> 10)

    assert take(5) == 3
    first = [unquantised(take(10)) for _ in range(3)]
    last = [unquantised(take(10)) for _ in range(3)]
    indices = [take(3), *(take(4) for _ in range(15))]
    weights = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64]
    return [
        [((((64 - w) * a + w * b + 32) >> 6) * 31) >> 6 for a, b in zip(first, last, strict=True)]
        for w in (weights[index] for index in indices)
    ]


def test_any_block_decodes_as_the_specification_says() -> None:
    blocks = random_blocks(2)
    blocks[0, 0, 1:8], blocks[0, 1, 1:8] = 0, 255  # the ends that the rule for all others does not give
    image = decode_bc6h(blocks)
    assert image.dtype == np.float32
    for row, column in np.ndindex(*blocks.shape[:2]):
        square = image[4 * row : 4 * row + 4, 4 * column : 4 * column + 4].reshape(16, 3)
        np.testing.assert_array_equal(bits(square), by_the_book(blocks[row, column].tobytes()))


def test_smooth_light_comes_back_within_a_small_part_of_itself() -> None:
    image = light()
    relative = np.abs(decode_bc6h(encode_bc6h(image)) - image) / image
    print(f"smooth over 9 octaves: mean {relative.mean():.2%}, worst {relative.max():.1%}")
    assert relative.mean() < 0.015
    slow = 0.3 + 0.02 * light() ** 0.25
    relative = np.abs(decode_bc6h(encode_bc6h(slow)) - slow) / slow
    print(f"slow: mean {relative.mean():.3%}, worst {relative.max():.2%}")
    assert relative.mean() < 0.002
    assert relative.max() < 0.02


def test_noise_is_nearer_than_to_its_blocks_means() -> None:
    """A line explains at least the greatest of three variances, so more than a third."""
    image = np.exp2(np.random.default_rng(5).uniform(-8, 8, (64, 64, 3))).astype(np.float32)
    squares = bits(image).reshape(16, 4, 16, 4, 3)
    about_mean = np.square(squares - squares.mean(axis=(1, 3), keepdims=True)).sum()
    error = np.square(bits(decode_bc6h(encode_bc6h(image))) - bits(image)).sum()
    print(f"noise: {error / about_mean:.0%} of the variance is left")
    assert error < 2 / 3 * about_mean


def test_grey_noise_has_sixteen_levels() -> None:
    octave = np.random.default_rng(6).uniform(-2, 2, (64, 64, 1))
    image = np.repeat(np.exp2(octave), 3, axis=2).astype(np.float32)
    off = np.abs(bits(decode_bc6h(encode_bc6h(image))) - bits(image))
    assert off.max() <= 4096 * 5 / 64 / 2 + 48  # half of the widest spacing, and what the ends are off


def test_blocks_of_one_value_are_exact_half_floats() -> None:
    octave = np.random.default_rng(7).uniform(np.log2(1e-4), np.log2(3e4), (64, 64, 3))
    values = np.exp2(octave).astype(np.float16).astype(np.float32)
    image = np.repeat(np.repeat(values, 4, axis=0), 4, axis=1)
    np.testing.assert_array_equal(decode_bc6h(encode_bc6h(image)), image)


def test_the_ends_of_the_range() -> None:
    """Zero and the largest are exact; what lies about them is at most half a step of an end off."""
    row = np.array((0, MOST, 6e-8, 1e-6, 3e-5, 6e-5, 4e4, 6e4, 65472), np.float32)
    image: Floats = np.repeat(np.repeat(row[None, :, None], 4, axis=1), 4, axis=0).repeat(3, axis=2)
    decoded = decode_bc6h(encode_bc6h(image))
    np.testing.assert_array_equal(decoded[:, :8], image[:, :8])
    assert np.abs(bits(decoded) - bits(image)).max() <= 24


def test_what_is_beyond_the_range_is_clamped() -> None:
    image = np.full((4, 8, 3), np.inf, np.float32)
    image[::2, :4] = 1e9
    image[:, 4:] = (-3, -np.inf, -0.0)
    decoded = decode_bc6h(encode_bc6h(image))
    assert np.all(decoded[:, :4] == MOST)
    assert np.all(decoded[:, 4:] == 0)


def test_black_and_the_brightest_in_one_block() -> None:
    image = np.zeros((4, 4, 3), np.float32)
    image[1::2] = MOST
    np.testing.assert_array_equal(decode_bc6h(encode_bc6h(image)), image)


@given(arrays(np.float32, (4, 4, 3), elements=st.floats(0, MOST, width=32)))
def test_no_block_is_worse_than_its_mean(image: Floats) -> None:
    about_mean = np.square(bits(image) - bits(image).mean(axis=(0, 1))).sum()
    error = np.square(bits(decode_bc6h(encode_bc6h(image))) - bits(image)).sum()
    assert error <= about_mean + 48 * 24**2  # half a step of the ends, which is what the range's ends have


def test_what_a_block_can_hold_comes_back() -> None:
    """Random ends and indices: mostly to the bit, though the search may end beside the best."""
    image = decode_bc6h(random_blocks(8, 16, 16))
    off = np.abs(bits(decode_bc6h(encode_bc6h(image))) - bits(image))
    same, rms = np.mean(off == 0), np.sqrt(np.mean(off**2))
    print(f"{same:.1%} of random blocks' values come back exactly, rms {rms:.1f} bits")
    assert same > 0.85
    assert rms < 100  # of 31743


@pytest.mark.parametrize(
    ("code", "name"),
    [
        (0b00000, "mode 1"),
        (0b00001, "mode 2"),
        (0b00010, "mode 3"),
        (0b11110, "mode 10"),
        (0b00111, "mode 12"),
        (0b01111, "mode 14"),
        (0b10011, "a reserved mode"),
        (0b11111, "a reserved mode"),
    ],
)
def test_other_modes_are_refused_by_name(code: int, name: str) -> None:
    blocks = random_blocks()
    blocks[1, 2, 0] = code | 0xA0
    with pytest.raises(FormatError, match=f"block 10 is of BC6H's {name}:"):
        decode_bc6h(blocks)


@pytest.mark.parametrize("shape", [(6, 8, 3), (8, 6, 3), (8, 8, 4), (8, 8), (8, 0, 3)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError):
        encode_bc6h(np.zeros(shape, np.float32))


def test_values_that_are_not_numbers_are_refused() -> None:
    image = light()
    image[3, 4] = np.nan
    with pytest.raises(InputError, match="3 of its values are not numbers"):
        encode_bc6h(image)


def test_a_million_pixels_take_seconds() -> None:
    image = np.random.default_rng(10).random((512, 512, 3)).astype(np.float32)
    begin = time.process_time()
    encode_bc6h(image)
    seconds = 4 * (time.process_time() - begin)
    print(f"BC6H: {seconds:.2f} s of processor time for 1024 x 1024 pixels")
    assert seconds < 10
