# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG: what another program reads is what was written."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.errors import ShapeError
from radtex_addon.formats.containers.png import encode_png, without_colour_space


def test_another_program_reads_the_same_levels() -> None:
    """What is beyond 0 and 1 is clipped; only colour pictures can be written."""
    levels = np.random.default_rng(1).integers(0, 256, (5, 7, 3))
    Image.open(io.BytesIO(encode_png(levels / 255))).verify()
    image = Image.open(io.BytesIO(encode_png(levels / 255)))
    assert image.mode == "RGB"
    np.testing.assert_array_equal(np.asarray(image), levels)
    image = Image.open(io.BytesIO(encode_png(np.array([[[-1.0, 0.5, 7.0]]]))))
    assert image.getpixel((0, 0)) == (0, 128, 255)
    for shape in ((4, 4), (4, 4, 2), (0, 4, 3)):
        with pytest.raises(ShapeError):
            encode_png(np.zeros(shape))


def test_a_colour_space_is_left_out_and_nothing_else() -> None:
    plain = encode_png(np.linspace(0, 1, 48).reshape(4, 4, 3))
    gamma = struct.pack(">I4sI", 4, b"gAMA", 45455) + struct.pack(">I", zlib.crc32(b"gAMA\x00\x00\xb1\x8f"))
    head = plain[:33]  # signature and IHDR
    assert without_colour_space(head + gamma + plain[33:]) == plain
    assert without_colour_space(plain) == plain
    assert without_colour_space(plain[:60]) == plain[:60]
