# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Encode PNG images, to embed them in HTML pages and glTF; and leave out what no renderer reads."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

from ...core.arrays import Floats
from ...core.errors import ShapeError

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_EIGHT_BITS = 8
_SHOWN = frozenset((b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND"))
_TEXTS = frozenset((b"tEXt", b"zTXt", b"iTXt"))
_KEPT_TEXTS = frozenset((b"Author", b"Copyright"))  # by their keywords
_BAND = 2**20  # numbers of a picture that are filtered at once
_COLOUR_TYPES = {3: 2, 4: 6}  # by channels: RGB, RGBA

Levels = npt.NDArray[np.integer[Any]]


def encode_png(picture: Floats) -> bytes:
    """Encode a picture (H, W, 3 or 4) of display values in 0..1, the top row first, as a file's bytes.

    The fourth channel is alpha, not premultiplied. Raises ShapeError for another shape.
    Format: https://www.w3.org/TR/png-3
    """
    if picture.ndim != 3 or picture.shape[2] not in _COLOUR_TYPES or 0 in picture.shape:
        raise ShapeError(f"picture: expected shape (H, W, 3 or 4), got {picture.shape}")
    height, width, channels = picture.shape
    band = max(_BAND // (channels * width), 1)
    packer = zlib.compressobj(9, strategy=zlib.Z_FILTERED)
    packed, above = [], np.zeros(channels * width, dtype=np.int16)
    for first in range(0, height, band):
        rows = np.rint(np.clip(picture[first : first + band], 0, 1) * 255).astype(np.int16)
        rows = rows.reshape(len(rows), -1)
        packed.append(packer.compress(_filtered(rows, above, channels).tobytes()))
        above = rows[-1]
    header = struct.pack(">IIBBBBB", width, height, _EIGHT_BITS, _COLOUR_TYPES[channels], 0, 0, 0)
    pixels = b"".join((*packed, packer.flush()))
    return _SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", pixels) + _chunk(b"IEND", b"")


def _filtered(rows: Levels, above: Levels, channels: int) -> Levels:
    """Rows of levels (R, N), each filtered and behind its filter's number: (R, 1 + N).

    `above` is the row before them. Of the five filters each row has the one whose differences from 0 have the
    least sum, as the specification suggests in section 12.7.
    """
    up = np.vstack([above, rows[:-1]])
    left, corner = np.zeros_like(rows), np.zeros_like(rows)
    left[:, channels:], corner[:, channels:] = rows[:, :-channels], up[:, :-channels]
    from_left, from_up = abs(up - corner), abs(left - corner)
    from_corner = abs(left + up - 2 * corner)
    nearest = np.where(from_up <= from_corner, up, corner)
    paeth = np.where((from_left <= from_up) & (from_left <= from_corner), left, nearest)
    guesses = (np.zeros_like(rows), left, up, (left + up) >> 1, paeth)
    tried = np.stack([(rows - guess).astype(np.uint8) for guess in guesses])
    best = np.argmin([np.abs(each.view(np.int8).astype(np.int64)).sum(axis=1) for each in tried], axis=0)
    filtered: Levels = np.column_stack([best.astype(np.uint8), tried[best, np.arange(len(rows))]])
    return filtered


def only_shown(file: bytes) -> bytes:
    """A PNG without what glTF ignores, such as colour spaces, and what no renderer reads, such as profiles.

    Its pixels stay to the last bit, and so does who made it. A file that is cut short stays as it is.
    """
    kept, place = [file[: len(_SIGNATURE)]], len(_SIGNATURE)
    while place + 8 <= len(file):
        end = place + 12 + int.from_bytes(file[place : place + 4])
        if end > len(file):
            return file
        kind, content = file[place + 4 : place + 8], file[place + 8 : end - 4]
        if kind in _SHOWN or (kind in _TEXTS and content.partition(b"\0")[0] in _KEPT_TEXTS):
            kept.append(file[place:end])
        place = end
    return b"".join(kept)


def has_colours_of_eight_bits(file: bytes) -> bool:
    """Whether a file is a PNG of three or four channels, 8 bits each, without a palette."""
    return file.startswith(_SIGNATURE) and file[24:25] == b"\x08" and file[25:26] in (b"\x02", b"\x06")


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
