# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that an EXR file can hold the pixels that its header announces, before memory is allocated for them.

Format: https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import OpenEXR

from ...core.errors import FormatError
from ..disk.memory import check_memory

_CHUNK = 16  # least bytes of a chunk: its offset in the table, its row number and its length
_LEAST, _MOST = 2, 4  # bytes of a value
_TILE = 1024  # pixels along a side up to which a tile may be larger than the image
_DEFLATE = 1032  # highest compression ratio of deflate

# Rows of a chunk, and the highest compression ratio.
_PACKED = {
    OpenEXR.NO_COMPRESSION: (1, 1),
    OpenEXR.RLE_COMPRESSION: (1, 64),  # two bytes repeat one up to 128 times
    OpenEXR.ZIPS_COMPRESSION: (1, _DEFLATE),
    OpenEXR.ZIP_COMPRESSION: (16, _DEFLATE),
    OpenEXR.PXR24_COMPRESSION: (16, 2 * _DEFLATE),  # drops bits before deflating
    OpenEXR.PIZ_COMPRESSION: (32, 512),  # ten bits repeat two bytes up to 256 times
    OpenEXR.B44_COMPRESSION: (32, 11),  # three bytes hold 4 x 4 halves
    OpenEXR.B44A_COMPRESSION: (32, 11),
    OpenEXR.DWAA_COMPRESSION: (32, 64 * _DEFLATE),  # a block of 8 x 8 is two values
    OpenEXR.DWAB_COMPRESSION: (256, 64 * _DEFLATE),
}
_OTHERS = (256, None)  # newer ones


def check_size(path: Path, headers: Iterable[Mapping[str, Any]]) -> None:
    """Make sure that the file `path` is large enough for the parts with these headers.

    Raises FormatError, with the path, if not, or if the file cannot be read.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
    least = 0
    for header in headers:
        width, height = _extent(header)
        _check_tiles(path, header, width, height)
        values = width * height * len(header["channels"])
        needed = _CHUNK * _chunks(header, width, height)
        _, ratio = _PACKED.get(header["compression"], _OTHERS)
        if ratio is not None and not _is_subsampled(header):
            needed = max(needed, values * _LEAST // ratio)
        least += needed
        if least > size:
            raise FormatError(f"{path} is damaged: {size} bytes cannot hold {width} x {height} pixels")


def _check_tiles(path: Path, header: Mapping[str, Any], width: int, height: int) -> None:
    """Refuse huge tiles: OpenEXR allocates memory for whole tiles, even for a small image."""
    if "tiles" in header:
        x, y = int(header["tiles"].xSize), int(header["tiles"].ySize)
        if x > max(width, _TILE) or y > max(height, _TILE):
            raise FormatError(f"{path} is damaged: tiles of {x} x {y} pixels for {width} x {height}")


def check_memory_for(path: Path, headers: Iterable[Mapping[str, Any]]) -> None:
    """Make sure that all pixels of the file `path` fit into memory at once. Raises FormatError if not."""
    sizes = ((_extent(header), len(header["channels"])) for header in headers)
    check_memory(str(path), sum(width * height * count * _MOST for (width, height), count in sizes))


def _extent(header: Mapping[str, Any]) -> tuple[int, int]:
    (x0, y0), (x1, y1) = header["dataWindow"]
    return int(x1) - int(x0) + 1, int(y1) - int(y0) + 1


def _chunks(header: Mapping[str, Any], width: int, height: int) -> int:
    if header["type"] == OpenEXR.tiledimage:
        tile = header["tiles"]
        return -(-width // max(1, int(tile.xSize))) * -(-height // max(1, int(tile.ySize)))
    rows, _ = _PACKED.get(header["compression"], _OTHERS)
    return -(-height // rows)


def _is_subsampled(header: Mapping[str, Any]) -> bool:
    return any(channel.xSampling != 1 or channel.ySampling != 1 for channel in header["channels"])
