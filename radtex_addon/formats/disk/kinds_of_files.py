# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check by its first bytes that a file is what a scene uses it as: image, font, volume or IES file.

An untrusted .blend may name any file on this machine as an image, and Blender packs it without a check.
"""

from __future__ import annotations

import os
import re
import struct
from enum import StrEnum
from pathlib import Path
from typing import BinaryIO

from .regular import open_regular

_HEAD = 64  # bytes that are enough to identify all but IES files
_IES_MOST = 1 << 20  # bytes; even large IES files have only some ten thousand
_TILT = re.compile(rb"^TILT ?=", re.MULTILINE)

_IMAGES = (
    *(b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0", b"MM\0*", b"II+\0", b"MM\0+", b"v/1\x01"),
    *(
        b"#?RADIANCE",
        b"#?RGBE",
        b"SDPX",
        b"XPDS",
        b"\x80*_\xd7",
        b"\xd7_*\x80",
        b"8BPS",
        b"DDS ",
        b"\x01\xda",
    ),
    *(b"\0\0\0\x0cjP  ", b"\xff\x4f\xff\x51"),
)
_FONTS = (
    *(b"\0\x01\0\0", b"OTTO", b"ttcf\0", b"true\0", b"typ1\0", b"wOFF", b"wOF2"),
    *(b"%!PS-AdobeFont", b"%!FontType", b"\x80\x01"),
)
_BITMAPS = (12, 16, 40, 52, 56, 64, 108, 124)  # header sizes of Windows bitmaps, in bytes
_VOLUME = b" BDV\0\0\0\0"  # of OpenVDB


class FileKind(StrEnum):
    """The kind of file that a scene expects."""

    IMAGE = "image"
    FONT = "font"
    VOLUME = "OpenVDB file"
    LAMP_SHAPE = "IES file"


def open_of_kind(path: Path, kind: FileKind) -> BinaryIO:
    """Open a regular file after checking its first bytes.

    Raises OSError if it cannot be opened or is no regular file, ValueError, with a reason, for another kind.
    """
    file = open_regular(path)
    try:
        found = _is(file, kind)
        file.seek(0)
    except BaseException:
        file.close()
        raise
    if not found:
        file.close()
        raise ValueError(f"it is no {kind}")
    return file


def _is(file: BinaryIO, kind: FileKind) -> bool:
    size = os.fstat(file.fileno()).st_size
    head = file.read(_HEAD)
    if kind is FileKind.VOLUME:
        return head.startswith(_VOLUME)
    if kind is FileKind.FONT:
        return head.startswith(_FONTS)
    if kind is FileKind.LAMP_SHAPE:
        return (
            size <= _IES_MOST
            and _TILT.search((head + file.read(_IES_MOST)).replace(b"\r", b"\n")) is not None
        )
    riff = head[:4] == b"RIFF" and head[8:12] == b"WEBP"
    boxed = head[4:8] == b"ftyp" and head[8:12] in (b"avif", b"avis")
    bitmap = head[:2] == b"BM" and int.from_bytes(head[14:18], "little") in _BITMAPS
    return head.startswith(_IMAGES) or riff or boxed or bitmap or _is_targa(head, size)


def _is_targa(head: bytes, size: int) -> bool:
    """Whether a file may be Targa, which has no magic bytes: check its header and size."""
    if len(head) < 18:
        return False
    _, palette, kind, _, colours, bits = struct.unpack_from("<BBBHHB", head)
    width, height, depth, form = struct.unpack_from("<HHBB", head, 12)
    packed = kind in (9, 10, 11)
    if palette not in (0, 1) or not (kind in (1, 2, 3) or packed) or depth not in (8, 15, 16, 24, 32):
        return False
    if form & 0xC0 or not width or not height or (palette and bits not in (15, 16, 24, 32)):
        return False
    pixels = width * height * -(-depth // 8)
    least = 18 + colours * (bits // 8) * palette + (pixels // 128 if packed else pixels)
    return bool(size >= least)
