# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BC7's mode 6: what Pillow decodes, we decode; what is encoded comes back as near as the format can."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.codecs.bc7 import Blocks, decode_bc7, encode_bc7

STEP = 1 / 255


def waves(height: int = 256, width: int = 384) -> Floats:
    """A smooth image (height, width, 4) that uses most of 0..1."""
    y, x = np.mgrid[0:height, 0:width] / 512
    channels = (0.5 + 0.5 * np.sin(7 * x + 3 * y), 0.5 + 0.4 * np.cos(5 * x * y), x * y, 1 - 0.3 * x)
    return np.stack(channels, axis=-1).astype(np.float32)


def psnr(a: Floats, b: Floats) -> float:
    return float(10 * np.log10(1 / np.mean(np.square(a - b, dtype=np.float64))))


def random_blocks(seed: int = 1, rows: int = 8, columns: int = 8) -> Blocks:
    """Any blocks of mode 6: all other bits are free."""
    blocks = np.random.default_rng(seed).integers(0, 256, (rows, columns, 16), np.uint8)
    blocks[..., 0] = (blocks[..., 0] & 0x80) | 0x40
    return blocks


def by_the_book(block: bytes) -> list[list[int]]:
    """Mode 6 bit by bit, as the specification's table has it: sixteen RGBA pixels of 8 bits."""
    bits = int.from_bytes(block, "little")

    def take(count: int) -> int:
        nonlocal bits
        value, bits = bits & ((1 << count) - 1), bits >> count
        return value

    assert take(7) == 64
    ends = [[take(7) << 1, take(7) << 1] for _ in range(4)]
    shared = [take(1), take(1)]
    indices = [take(3), *(take(4) for _ in range(15))]
    weights = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64]
    return [
        [((64 - w) * (a | shared[0]) + w * (b | shared[1]) + 32) >> 6 for a, b in ends]
        for w in (weights[index] for index in indices)
    ]


def test_any_block_decodes_as_the_specification_says() -> None:
    blocks = random_blocks(2)
    image = decode_bc7(blocks)
    assert image.dtype == np.float32
    for row, column in np.ndindex(*blocks.shape[:2]):
        square = image[4 * row : 4 * row + 4, 4 * column : 4 * column + 4].reshape(16, 4)
        np.testing.assert_array_equal(np.rint(square * 255), by_the_book(blocks[row, column].tobytes()))
        np.testing.assert_allclose(square * 255, np.rint(square * 255), atol=1e-4)


def test_a_smooth_image_is_as_good_as_eight_bits() -> None:
    image = waves()
    decoded = decode_bc7(encode_bc7(image))
    rounded = np.rint(image * 255) / 255
    print(f"smooth: {psnr(image, decoded):.1f} dB, 8 bits have {psnr(image, rounded):.1f} dB")
    assert psnr(image, decoded) > psnr(image, rounded) - 4


def test_a_slow_gradient_loses_nothing_to_eight_bits() -> None:
    image = 0.3 + 0.05 * waves()
    decoded = decode_bc7(encode_bc7(image))
    print(f"slow: {psnr(image, decoded):.1f} dB")
    assert psnr(image, decoded) > psnr(image, np.rint(image * 255) / 255) - 1
    assert np.abs(image - decoded).max() < 1.5 * STEP


def test_pixels_on_one_line_lose_what_sixteen_levels_lose() -> None:
    """The levels' spacing over the root of 12, as by any rounding, and that of ends and levels themselves."""
    ends = np.random.default_rng(3).random((2, 256, 1, 4))
    place = np.random.default_rng(4).random((256, 16, 1))
    pixels = ends[0] + (ends[1] - ends[0]) * place
    image = pixels.reshape(256 * 4, 4, 4).astype(np.float32)
    wrong = (decode_bc7(encode_bc7(image)) - image).reshape(256, 16, 4)
    spacing = (ends[1] - ends[0]) / 15
    expected = np.square(spacing).sum() / 12 + 4 * 256 * STEP**2 / 6
    found = np.square(wrong).sum() / 16
    print(f"lines: {found / expected:.2f} of the expected error")
    assert found < expected


def test_noise_is_nearer_than_to_its_blocks_means() -> None:
    """A line explains at least the greatest of four variances, so more than a quarter."""
    image = np.random.default_rng(5).random((64, 64, 4)).astype(np.float32)
    squares = image.reshape(16, 4, 16, 4, 4)
    flat = np.broadcast_to(squares.mean(axis=(1, 3), keepdims=True), squares.shape).reshape(image.shape)
    error = np.square(decode_bc7(encode_bc7(image)) - image).sum()
    print(f"noise: {psnr(image, decode_bc7(encode_bc7(image))):.1f} dB")
    assert error < 0.75 * np.square(flat - image).sum()


def test_one_channel_of_noise_has_sixteen_levels() -> None:
    image = np.zeros((64, 64, 4), np.float32)
    image[..., 2] = np.random.default_rng(6).random((64, 64))
    wrong = decode_bc7(encode_bc7(image)) - image
    assert np.abs(wrong[..., 2]).max() < 1 / 30 + 2.5 * STEP
    assert np.abs(wrong[..., [0, 1, 3]]).max() < 1.5 * STEP


def test_blocks_of_one_value_are_exact_to_eight_bits() -> None:
    values = np.random.default_rng(7).integers(0, 256, (4096, 4))
    values[:256] = np.arange(256)[:, None]
    values[256:512] = np.arange(256)[:, None] * (1, 0, 0, 1)
    values[512:768] = 255 - np.arange(256)[:, None] * (1, 0, 0, 1)
    image = np.repeat(np.repeat(values.reshape(64, 64, 4), 4, axis=0), 4, axis=1) / np.float32(255)
    decoded = np.rint(decode_bc7(encode_bc7(image.astype(np.float32))) * 255)
    wrong = np.abs(decoded - np.rint(image * 255))[::4, ::4].reshape(-1, 4)
    impossible = (values == 0).any(axis=1) & (values == 255).any(axis=1)
    assert wrong[~impossible].max() == 0
    assert impossible.any()
    assert wrong[impossible].max() == 1


def test_what_is_beyond_the_range_is_clamped() -> None:
    image = np.zeros((4, 8, 4), np.float32)
    image[:, :4] = (2, np.inf, 1, 7)
    image[:, 4:] = (-1, -np.inf, -0.0, 0)
    decoded = decode_bc7(encode_bc7(image))
    assert np.all(decoded[:, :4] == 1)
    assert np.all(decoded[:, 4:] == 0)


def test_black_and_white_in_one_block() -> None:
    image = np.zeros((4, 4, 4), np.float32)
    image[1::2] = 1
    assert np.abs(decode_bc7(encode_bc7(image)) - image).max() <= STEP * 1.01


def test_what_a_block_can_hold_comes_back() -> None:
    """Random ends and indices: mostly to the bit, though the search may end beside the best."""
    blocks = random_blocks(8, 16, 16)
    image = decode_bc7(blocks)
    again = decode_bc7(encode_bc7(image))
    kept = np.abs(again - image).reshape(16, 4, 16, 4, 4).max(axis=(1, 3, 4)) < 0.5 * STEP
    print(f"{kept.mean():.1%} of random blocks come back exactly, PSNR {psnr(again, image):.1f} dB")
    assert kept.mean() > 0.85
    assert psnr(again, image) > 52


@given(arrays(np.float32, (4, 4, 4), elements=st.floats(0, 1, width=32)))
def test_no_block_is_worse_than_its_mean(image: Floats) -> None:
    decoded = decode_bc7(encode_bc7(image))
    about_mean = np.square(image - image.mean(axis=(0, 1))).sum()
    assert (
        np.square(decoded - image).sum() <= about_mean + 64 * STEP**2
    )  # a step: both 0 and 255 may be in it


def test_blocks_do_not_know_each_other() -> None:
    image = np.random.default_rng(9).random((136, 140, 4)).astype(np.float32)
    blocks = encode_bc7(image)
    assert blocks.shape == (34, 35, 16)
    np.testing.assert_array_equal(encode_bc7(image[60:64, 136:140])[0, 0], blocks[15, 34])
    wide = np.concatenate([image.reshape(4, -1, 4)] * 4, axis=1)  # more blocks in a row than go at once
    np.testing.assert_array_equal(encode_bc7(wide)[0, -1], encode_bc7(wide[:, -4:])[0, 0])


@pytest.mark.parametrize("mode", [0, 1, 2, 3, 4, 5, 7])
def test_other_modes_are_refused_by_name(mode: int) -> None:
    blocks = random_blocks()
    blocks[3, 2, 0] = (1 << mode) | (0xFE << mode & 0xFF)
    with pytest.raises(FormatError, match=f"block 26 is of BC7's mode {mode}"):
        decode_bc7(blocks)


def test_a_block_without_a_mode_is_refused() -> None:
    with pytest.raises(FormatError, match="no mode"):
        decode_bc7(np.zeros((1, 1, 16), np.uint8))


@pytest.mark.parametrize("shape", [(6, 8, 4), (8, 6, 4), (8, 8, 3), (8, 8), (0, 8, 4)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError):
        encode_bc7(np.zeros(shape, np.float32))


def test_blocks_of_another_shape_or_type_are_refused() -> None:
    with pytest.raises(ShapeError, match="16"):
        decode_bc7(np.zeros((2, 2, 8), np.uint8))
    with pytest.raises(ShapeError, match="uint8"):
        decode_bc7(np.zeros((2, 2, 16), np.int16))


def test_values_that_are_not_numbers_are_refused() -> None:
    image = waves()
    image[3, 4, 1] = np.nan
    with pytest.raises(InputError, match="1 of its values are not numbers"):
        encode_bc7(image)


def test_a_million_pixels_take_seconds() -> None:
    image = np.random.default_rng(10).random((512, 512, 4)).astype(np.float32)
    begin = time.process_time()
    encode_bc7(image)
    seconds = 4 * (time.process_time() - begin)
    print(f"BC7: {seconds:.2f} s of processor time for 1024 x 1024 pixels")
    assert seconds < 10
