# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of images and other files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.near_digest import DIGEST
from ..formats.disk.regular import open_regular

_WHOLE = 64 << 20  # bytes: of larger files only evenly spaced slices are read
_SLICES = 64


def file_digest(path: Path) -> str:
    """Digest of a file's size and contents (of large files only slices); "" if it cannot be read."""
    with suppress(OSError), open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        state = hashlib.sha256(str(size).encode())
        for start, length in _slices(size):
            file.seek(start)
            state.update(file.read(length))
        return DIGEST + state.hexdigest()
    return ""


def image_contents(image: Any) -> str:
    """Digests of the pixels of a `bpy.types.Image`: painted and not saved, packed, or in its files."""
    if image.is_dirty and image.source in {"FILE", "GENERATED"} and image.size[0]:
        pixels = np.empty(image.size[0] * image.size[1] * image.channels, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        return DIGEST + hashlib.sha256(pixels.tobytes()).hexdigest()
    packed = [file.packed_file.data for file in image.packed_files if file.packed_file]
    if packed:
        return " ".join(hashlib.sha256(data).hexdigest() for data in packed)
    path = bpy.path.abspath(image.filepath, library=image.library)
    numbers = [str(tile.number) for tile in image.tiles] if image.source == "TILED" else [""]
    return " ".join(file_digest(Path(path.replace("<UDIM>", number))) for number in numbers)


def _slices(size: int) -> Iterator[tuple[int, int]]:
    if size <= _WHOLE:
        yield 0, size
        return
    length = _WHOLE // _SLICES
    for number in range(_SLICES):
        yield (size - length) * number // (_SLICES - 1), length
