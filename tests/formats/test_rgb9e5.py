# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RGB9E5: known words, the error that nine bits allow, and OpenGL's own decoder."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.codecs.rgb9e5 import MOST, decode_rgb9e5, encode_rgb9e5


def light(shape: tuple[int, int] = (300, 50), seed: int = 1) -> Floats:
    """From 6e-5 to 65000, all channels of one pixel about alike."""
    rng = np.random.default_rng(seed)
    bright = np.exp(rng.uniform(np.log(6e-5), np.log(3e4), (*shape, 1)))
    return (bright * rng.uniform(0.5, 2, (*shape, 3))).astype(np.float32)


@pytest.mark.parametrize(
    ("colour", "word"),
    [
        ((0, 0, 0), 0),
        ((-0.0, -0.0, -0.0), 0),
        ((1, 1, 1), 16 << 27 | 256 << 18 | 256 << 9 | 256),
        ((1, 0.5, 0.25), 16 << 27 | 64 << 18 | 128 << 9 | 256),
        ((0, 0, 65408), 31 << 27 | 511 << 18),
        ((2.0**-24, 0, 0), 1),
        ((0.9995, 0, 0), 16 << 27 | 256),  # rounds to 512 of 2^-9, which needs the next exponent
        ((-1, np.inf, 0), 31 << 27 | 511 << 9),
        ((2.0**-26, 2.0**-26, 2.0**-26), 0),
        ((1e6, 1e6, 1e6), 2**32 - 1),
    ],
)
def test_known_words(colour: tuple[float, ...], word: int) -> None:
    """Red in the lowest nine bits, then green, blue and the exponent, of bias 15."""
    encoded = encode_rgb9e5(np.array(colour, np.float32).reshape(1, 1, 3))
    assert encoded.view("<u4").item() == word
    assert decode_rgb9e5(encoded).max() <= MOST
    if word == 2**32 - 1:
        assert (decode_rgb9e5(encoded) == MOST).all()


def test_no_value_is_off_by_more_than_half_a_step_of_its_pixel() -> None:
    image = light()
    decoded = decode_rgb9e5(encode_rgb9e5(image))
    greatest = image.max(axis=2, keepdims=True)
    assert (np.abs(decoded - image) <= greatest / 511).all()
    stops = np.abs(np.log2(decoded.max(axis=2) / image.max(axis=2)))
    print(f"greatest channel: {stops.max():.4f} stops at most")
    assert stops.max() <= 0.005


def test_words_that_were_decoded_encode_to_the_same_values_and_others_are_refused() -> None:
    words = np.random.default_rng(2).integers(0, 1 << 32, (64, 64), np.uint32)
    decoded = decode_rgb9e5(words.view(np.uint8).reshape(64, 64, 4))
    np.testing.assert_array_equal(decode_rgb9e5(encode_rgb9e5(decoded)), decoded)
    with pytest.raises(ShapeError, match="expected shape"):
        encode_rgb9e5(np.zeros((4, 4, 4), np.float32))
    with pytest.raises(InputError, match="1 of its values are not numbers"):
        encode_rgb9e5(np.array([[[0, np.nan, 1]]], np.float32))
    with pytest.raises(FormatError, match="expected"):
        decode_rgb9e5(np.zeros((4, 4, 3), np.uint8))
