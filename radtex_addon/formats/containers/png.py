# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Encode PNG images, to embed them in HTML pages and glTF; and leave out what glTF has no use for."""

from __future__ import annotations

import struct
import zlib

import numpy as np

from ...core.arrays import Floats
from ...core.errors import ShapeError

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_EIGHT_BITS = 8
_IGNORED = frozenset((b"gAMA", b"cHRM", b"iCCP", b"pHYs", b"acTL", b"fcTL", b"fdAT"))
_COLOUR_TYPES = {3: 2, 4: 6}  # by channels: RGB, RGBA


def encode_png(picture: Floats) -> bytes:
    """Encode a picture (H, W, 3 or 4) of display values in 0..1, the top row first, as a file's bytes.

    The fourth channel is alpha, not premultiplied. Raises ShapeError for another shape.
    Format: https://www.w3.org/TR/png-3
    """
    if picture.ndim != 3 or picture.shape[2] not in _COLOUR_TYPES or 0 in picture.shape:
        raise ShapeError(f"picture: expected shape (H, W, 3 or 4), got {picture.shape}")
    height, width, channels = picture.shape
    levels = np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8)
    rows = np.zeros(
        (height, 1 + channels * width), dtype=np.uint8
    )  # each row begins with its filter: 0, none
    rows[:, 1:] = levels.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, _EIGHT_BITS, _COLOUR_TYPES[channels], 0, 0, 0)
    pixels = zlib.compress(rows.tobytes(), 9)
    return _SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", pixels) + _chunk(b"IEND", b"")


def without_colour_space(file: bytes) -> bytes:
    """A PNG without what it says of its colour space, its pixels' shape and animation, which glTF ignores.

    A file that is cut short stays as it is.
    """
    kept, place = [file[: len(_SIGNATURE)]], len(_SIGNATURE)
    while place + 8 <= len(file):
        end = place + 12 + int.from_bytes(file[place : place + 4])
        if end > len(file):
            return file
        if file[place + 4 : place + 8] not in _IGNORED:
            kept.append(file[place:end])
        place = end
    return b"".join(kept)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
