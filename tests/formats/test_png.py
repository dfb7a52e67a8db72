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
from radtex_addon.formats.containers import png
from radtex_addon.formats.containers.png import encode_png, only_shown


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


@pytest.mark.parametrize("channels", [3, 4])
def test_each_filter_is_what_another_program_undoes(channels: int) -> None:
    """Rows that are best guessed by each of the five filters; also where a picture is filtered in bands."""
    rng = np.random.default_rng(2)
    ramp, noise = np.arange(90) * 2, rng.integers(0, 256, 90)
    halves = [np.concatenate([np.full(45, level), noise[:45]]) for level in (0, 99)]
    rows = [[0] * 90, ramp, noise, noise, (noise + ramp) // 2, noise[::-1], *halves]
    levels = np.stack([np.roll(np.array(rows), shift, axis=1) for shift in range(channels)], axis=-1)
    with pytest.MonkeyPatch.context() as patch:
        for band in (png._BAND, 1, 3 * 90 * channels):
            patch.setattr(png, "_BAND", band)
            shown = np.asarray(Image.open(io.BytesIO(encode_png(levels / 255))))
            np.testing.assert_array_equal(shown, levels)
    packed = encode_png(levels / 255)
    filters = {row[0] for row in raw_rows(packed, 1 + 90 * channels)}
    assert filters == {0, 1, 2, 3, 4}


def raw_rows(file: bytes, length: int) -> list[bytes]:
    """Rows of a file with one IDAT, each with its filter's number before it."""
    begin = file.index(b"IDAT")
    size = int.from_bytes(file[begin - 4 : begin])
    data = zlib.decompress(file[begin + 4 : begin + 4 + size])
    return [data[place : place + length] for place in range(0, len(data), length)]


def test_smooth_pictures_are_small() -> None:
    """Without filters this one has 6,057 bytes."""
    row, column = np.indices((128, 128))
    wave = 0.5 + 0.5 * np.sin(row / 40 + column / 23)
    assert len(encode_png(np.stack([wave, wave**2, 1 - wave], axis=-1))) < 4_500


def test_what_no_renderer_reads_is_left_out_and_nothing_else() -> None:
    plain = encode_png(np.linspace(0, 1, 48).reshape(4, 4, 3))
    head, tail = plain[:33], plain[33:]  # signature and IHDR
    gamma, profile = chunk(b"gAMA", bytes(4)), chunk(b"zTXt", b"Raw profile type exif\0\0" + bytes(900))
    assert only_shown(head + gamma + profile + tail) == plain
    seen, maker = chunk(b"tRNS", bytes(6)), chunk(b"tEXt", b"Copyright\0Somebody")
    assert only_shown(head + maker + profile + seen + tail) == head + maker + seen + tail
    assert only_shown(plain) == plain
    assert only_shown(plain[:60]) == plain[:60]


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
