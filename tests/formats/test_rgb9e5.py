# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RGB9E5: known words, the error that nine bits allow, and OpenGL's own decoder."""

from __future__ import annotations

import ctypes

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.codecs.bc7 import Blocks
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
    ],
)
def test_known_words(colour: tuple[float, ...], word: int) -> None:
    """Red in the lowest nine bits, then green, blue and the exponent, of bias 15."""
    encoded = encode_rgb9e5(np.array(colour, np.float32).reshape(1, 1, 3))
    assert encoded.view("<u4").item() == word


def test_no_value_is_off_by_more_than_half_a_step_of_its_pixel() -> None:
    image = light()
    decoded = decode_rgb9e5(encode_rgb9e5(image))
    greatest = image.max(axis=2, keepdims=True)
    assert (np.abs(decoded - image) <= greatest / 511).all()
    stops = np.abs(np.log2(decoded.max(axis=2) / image.max(axis=2)))
    print(f"greatest channel: {stops.max():.4f} stops at most")
    assert stops.max() <= 0.005


def test_dark_and_bright_values_lie_on_the_formats_ends() -> None:
    dark = np.full((1, 1, 3), 2.0**-26, np.float32)
    assert not decode_rgb9e5(encode_rgb9e5(dark)).any()
    bright = np.full((1, 1, 3), 1e6, np.float32)
    assert (decode_rgb9e5(encode_rgb9e5(bright)) == MOST).all()


def test_words_that_were_decoded_encode_to_the_same_values() -> None:
    words = np.random.default_rng(2).integers(0, 1 << 32, (64, 64), np.uint32)
    decoded = decode_rgb9e5(words.view(np.uint8).reshape(64, 64, 4))
    np.testing.assert_array_equal(decode_rgb9e5(encode_rgb9e5(decoded)), decoded)


def test_opengl_decodes_as_we_do() -> None:
    words = np.random.default_rng(3).integers(0, 1 << 32, (32, 48), np.uint32)
    pixels = words.view(np.uint8).reshape(32, 48, 4)
    with moderngl.create_context(standalone=True, backend="egl"):  # type: ignore[arg-type]  # wrong stub
        theirs = drawn_by_opengl(pixels)
    np.testing.assert_array_equal(theirs, decode_rgb9e5(pixels))


def drawn_by_opengl(pixels: Blocks) -> Floats:
    """The image (H, W, 3) float32 of pixels given to the current context as they are."""
    texture_2d, rgb, rgb9_e5, packed, floats = 0x0DE1, 0x1907, 0x8C3D, 0x8C3E, 0x1406
    opengl = ctypes.CDLL("libGL.so.1")
    height, width = pixels.shape[:2]
    data, image = pixels.tobytes(), np.full((height, width, 3), np.nan, np.float32)
    name = ctypes.c_uint()
    opengl.glGenTextures(1, ctypes.byref(name))
    opengl.glBindTexture(texture_2d, name)
    opengl.glTexImage2D(texture_2d, 0, rgb9_e5, width, height, 0, rgb, packed, data)
    opengl.glGetTexImage(texture_2d, 0, rgb, floats, image.ctypes.data_as(ctypes.c_void_p))
    assert opengl.glGetError() == 0
    return image


def test_what_is_no_light_is_refused() -> None:
    with pytest.raises(ShapeError, match="expected shape"):
        encode_rgb9e5(np.zeros((4, 4, 4), np.float32))
    with pytest.raises(InputError, match="1 of its values are not numbers"):
        encode_rgb9e5(np.array([[[0, np.nan, 1]]], np.float32))
    with pytest.raises(FormatError, match="expected"):
        decode_rgb9e5(np.zeros((4, 4, 3), np.uint8))
