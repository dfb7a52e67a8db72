# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC5: any block decodes as the specification says; what is encoded is as near as eight levels can be."""

from __future__ import annotations

import time
from fractions import Fraction
from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError, ShapeError
from radtex_addon.formats.codecs.bc5 import decode_bc5, encode_bc5
from radtex_addon.formats.codecs.bc7 import Blocks
from radtex_addon.formats.containers.dds import DdsFormat, write_dds

STEP = 1 / 255


def random_blocks(seed: int = 1, rows: int = 8, columns: int = 8) -> Blocks:
    """Any blocks: about half have six levels. The first has equal ends."""
    blocks = np.random.default_rng(seed).integers(0, 256, (rows, columns, 16), np.uint8)
    blocks[0, 0, [0, 1, 8, 9]] = 90
    return blocks


def spread(values: Floats) -> Floats:
    """An image whose blocks have one value each, of `values` (rows, columns, 2)."""
    return np.repeat(np.repeat(values, 4, axis=0), 4, axis=1).astype(np.float32)


def by_the_book(block: bytes) -> list[Fraction]:
    """One channel's sixteen values in 255ths, as the specification's tables have them."""
    first, last = block[:2]
    bits = int.from_bytes(block[2:], "little")
    if first > last:
        levels = [(first * (7 - k) + last * k, 7) for k in (0, 7, 1, 2, 3, 4, 5, 6)]
    else:
        levels = [(first * (5 - k) + last * k, 5) for k in (0, 5, 1, 2, 3, 4)] + [(0, 1), (255, 1)]
    return [Fraction(*levels[bits >> 3 * pixel & 7]) for pixel in range(16)]


def test_any_block_decodes_as_the_specification_says() -> None:
    blocks = random_blocks()
    image = decode_bc5(blocks)
    assert image.dtype == np.float32
    for row, column in np.ndindex(*blocks.shape[:2]):
        square = image[4 * row : 4 * row + 4, 4 * column : 4 * column + 4].reshape(16, 2)
        for channel in range(2):
            block = blocks[row, column, 8 * channel : 8 * channel + 8].tobytes()
            expected = np.array([float(value / 255) for value in by_the_book(block)], np.float32)
            np.testing.assert_array_equal(square[:, channel], expected)


def test_pillow_decodes_as_we_do_but_cuts_off_to_bytes(tmp_path: Path) -> None:
    blocks = random_blocks(2)
    write_dds(tmp_path / "a.dds", blocks, DdsFormat.BC5_UNORM)
    with Image.open(tmp_path / "a.dds") as image:
        theirs = np.asarray(image)
    np.testing.assert_array_equal(theirs[..., :2], np.floor(decode_bc5(blocks) * 255 + 1e-4))


@pytest.mark.parametrize("seed", range(3))
def test_blocks_of_one_value_are_exact_to_eight_bits(seed: int) -> None:
    """Both channels at once, each of its own value; between 255ths there are seven levels."""
    rng = np.random.default_rng(seed)
    whole = np.stack([np.arange(256), rng.permutation(256)], axis=-1).reshape(16, 16, 2) / 255
    np.testing.assert_array_equal(decode_bc5(encode_bc5(spread(whole))), spread(whole))
    between = spread(rng.random((32, 32, 2)))
    assert np.abs(decode_bc5(encode_bc5(between)) - between).max() <= STEP / 13.9


def test_a_block_of_one_whole_value_is_its_code_twice_and_index_0() -> None:
    values = np.array([[[7, 255], [0, 128]]]) / 255
    codes = np.array([[[7, 255], [0, 128]]], np.uint8)
    expected = np.zeros((1, 2, 2, 8), np.uint8)
    expected[..., :2] = codes[..., None]
    np.testing.assert_array_equal(encode_bc5(spread(values)), expected.reshape(1, 2, 16))


def test_blocks_have_eight_levels_wherever_they_have_two_values() -> None:
    words = encode_bc5(np.random.default_rng(1).random((64, 64, 2)).astype(np.float32)).reshape(-1, 8)
    assert (words[:, 0] > words[:, 1]).all()


def test_what_a_block_can_hold_comes_back() -> None:
    """Random ends, at least a few steps apart, and indices, both ends among them."""
    rng = np.random.default_rng(3)
    blocks = rng.integers(0, 256, (512, 2, 8), np.uint8)
    blocks[..., 1], blocks[..., 0] = blocks[..., 1] % 128, blocks[..., 0] % 120 + 135
    blocks[..., 2] = blocks[..., 2] & 0xC0 | 0b001_000
    image = decode_bc5(blocks.reshape(16, 32, 16))
    again = decode_bc5(encode_bc5(image))
    np.testing.assert_allclose(again, image, atol=1e-6)


def test_channels_do_not_know_each_other() -> None:
    rng = np.random.default_rng(4)
    first, last = rng.random((2, 32, 32)).astype(np.float32)
    both = encode_bc5(np.stack([first, last], axis=-1))
    np.testing.assert_array_equal(both[..., :8], encode_bc5(np.stack([first, first], axis=-1))[..., 8:])
    np.testing.assert_array_equal(both[..., 8:], encode_bc5(np.stack([last, first], axis=-1))[..., :8])


@given(arrays(np.float32, (4, 4, 2), elements=st.floats(0, 1, width=32)))
def test_no_value_is_further_off_than_half_a_level(image: Floats) -> None:
    """About the ends around all values; what least squares make of a block is no worse on the whole."""
    values = image * 255
    span = np.ceil(values.max(axis=(0, 1))) - np.floor(values.min(axis=(0, 1)))
    wrong = np.square(decode_bc5(encode_bc5(image)) - image).sum(axis=(0, 1))
    assert (wrong <= 16 * np.square((span / 14 + 1e-4) * STEP)).all()


@pytest.mark.parametrize("seed", range(4))
def test_no_other_ends_are_much_better(seed: int) -> None:
    """All pairs of ends for one channel of a block."""
    values = np.random.default_rng(seed).random((4, 4))
    pairs = np.array(list(combinations_with_replacement(range(256), 2))) / 255
    levels = pairs[:, :1] + (pairs[:, 1:] - pairs[:, :1]) * np.arange(8) / 7
    wrong = np.abs(levels[:, None] - values.reshape(16, 1)).min(axis=2)
    best = np.square(wrong).sum(axis=1).min()
    image = np.stack([values, values], axis=-1).astype(np.float32)
    found = np.square(decode_bc5(encode_bc5(image)) - image)[..., 0].sum()
    print(f"block {seed}: {found / best:.2f} of the least error")
    assert found < 2 * best


def test_what_is_beyond_the_range_is_clamped() -> None:
    image = np.zeros((4, 8, 2), np.float32)
    image[:, :4] = (2, np.inf)
    image[:, 4:] = (-1, -np.inf)
    decoded = decode_bc5(encode_bc5(image))
    assert np.all(decoded[:, :4] == 1)
    assert np.all(decoded[:, 4:] == 0)


def test_black_and_white_in_one_block() -> None:
    image = np.zeros((4, 4, 2), np.float32)
    image[1::2, :, 0] = 1
    np.testing.assert_array_equal(decode_bc5(encode_bc5(image)), image)


@pytest.mark.parametrize("shape", [(6, 8, 2), (8, 6, 2), (8, 8, 4), (8, 8), (0, 8, 2)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError):
        encode_bc5(np.zeros(shape, np.float32))


def test_blocks_of_another_shape_or_type_are_refused() -> None:
    with pytest.raises(ShapeError, match="16"):
        decode_bc5(np.zeros((2, 2, 8), np.uint8))
    with pytest.raises(ShapeError, match="uint8"):
        decode_bc5(np.zeros((2, 2, 16), np.int16))


def test_values_that_are_not_numbers_are_refused() -> None:
    image = np.zeros((8, 8, 2), np.float32)
    image[3, 4, 1] = np.nan
    with pytest.raises(InputError, match="1 of its values are not numbers"):
        encode_bc5(image)


def test_a_million_pixels_take_seconds() -> None:
    image = np.random.default_rng(10).random((1024, 1024, 2)).astype(np.float32)
    begin = time.process_time()
    encode_bc5(image)
    seconds = time.process_time() - begin
    print(f"BC5: {seconds:.2f} s of processor time for 1024 x 1024 pixels")
    assert seconds < 5
