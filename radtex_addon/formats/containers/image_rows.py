# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read RadTex's images in bands of rows: an atlas may be larger than memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from ...core.arrays import Floats
from ...core.errors import FormatError
from ..disk.memory import check_memory
from .exr import CHANNELS, check_channels, headers_of, hushed, one_line

_BAND_BYTES = 1 << 24  # size of a band as float32
_CHUNK = 32  # rows that most compressions pack together: bands of whole chunks are unpacked only once
_TYPES: dict[str, type[np.floating[Any]]] = {"HALF": np.float16, "FLOAT": np.float32}


@dataclass(frozen=True)
class ImageRows:
    """An image (height, width, channels) in the file `path`, not in memory."""

    path: Path
    width: int
    height: int
    channels: int

    def bands(self, cells: int = 1) -> Iterator[tuple[int, Floats]]:
        """Yield bands from the bottom up: the first row's number, and rows (k, W, C).

        float16 or float32 as stored. A band has whole texels of `cells` rows. Raises FormatError, with the
        path, for a damaged file.
        """
        row_bytes, names = self.width * self.channels * 4, list(CHANNELS[self.channels])
        step = _step(row_bytes, cells)
        check_memory(str(self.path), step * row_bytes)
        with _opened(self.path) as file:
            with _named(self.path):
                kind, top = _stored(file.header())
            for first in range(0, self.height, step):
                count = min(step, self.height - first)
                lowest = top + self.height - 1 - first
                with _named(self.path):
                    planes = file.channels(names, scanLine1=lowest - count + 1, scanLine2=lowest)
                rows = [np.frombuffer(plane, kind).reshape(count, self.width) for plane in planes]
                yield first, np.stack(rows, axis=-1)[::-1]


def open_rows(path: Path, width: int, height: int, channels: Iterable[int] = tuple(CHANNELS)) -> ImageRows:
    """Open the image `path`, which must have `width` x `height` pixels and one of the numbers of `channels`.

    Checks only the header. Raises FormatError, with the path, as `exr.read_pixels` does for a header, and for
    a file in several parts.
    """
    headers = headers_of(path)
    count = check_channels(path, headers, channels)
    if len(headers) > 1:
        raise FormatError(f"{path} is in several parts, expected one: bake it again")
    with _opened(path) as file, _named(path):
        header = file.header()
        _stored(header)
        low, high = header["dataWindow"].min, header["dataWindow"].max
    size = high.x - low.x + 1, high.y - low.y + 1
    if size != (width, height):
        found = f"{size[0]} x {size[1]} pixels"
        raise FormatError(f"{path} has {found}, its header says {width} x {height} floats")
    return ImageRows(path, width, height, count)


def _step(row_bytes: int, cells: int) -> int:
    """Rows of a band: whole texels, and whole chunks if that is not too large."""
    most = _BAND_BYTES // row_bytes
    unit = int(np.lcm(cells, _CHUNK))
    return most // unit * unit or max(cells, most // cells * cells)


def _stored(header: dict[str, Any]) -> tuple[type[np.floating[Any]], int]:
    """The type of all channels, and the top row's number. Raises ValueError for images that are not ours."""
    kinds = {str(channel.type) for channel in header["channels"].values()}
    steps = {channel.xSampling * channel.ySampling for channel in header["channels"].values()}
    if len(kinds) > 1 or not kinds <= set(_TYPES) or steps != {1}:
        raise ValueError("its channels are not all half floats, or all floats, of one size")
    return _TYPES[kinds.pop()], header["dataWindow"].min.y


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with _named(path):
        file = OpenEXR.InputFile(str(path))
    with closing(file):
        yield file


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Turn OpenEXR's errors into FormatErrors with the path, and suppress its own messages."""
    try:
        with hushed():
            yield
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        raise FormatError(f"{path} is damaged: {one_line(error)}; it may be cut short") from error
