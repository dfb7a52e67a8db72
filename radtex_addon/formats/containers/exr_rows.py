# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex's images in bands of rows, written and read: an atlas may be larger than memory."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import Imath
import numpy as np
import OpenEXR

from ...core.arrays import Floats
from ...core.colour_spaces import REC_709
from ...core.errors import FormatError
from ..disk.memory import check_memory
from .exr import ATTRIBUTE, CHANNELS, HALF_MOST, Compression, check_channels, headers_of, hushed, one_line

_COMPRESSIONS = {
    Compression.ZIP: Imath.Compression.ZIP_COMPRESSION,
    Compression.PIZ: Imath.Compression.PIZ_COMPRESSION,
    Compression.DWAA: Imath.Compression.DWAA_COMPRESSION,
}
# OpenEXR's module writes zeros as chromaticities when it writes by rows.
_NO_CHROMATICITIES = b"chromaticities\0chromaticities\0" + struct.pack("<i8f", 32, *[0.0] * 8)
_HEADER_BYTES = 1 << 20  # more than any header of ours
_BAND_BYTES = 1 << 24  # size of a band as float32
_CHUNK = 32  # rows that most compressions pack together: bands of whole chunks are unpacked only once
_TYPES: dict[str, type[np.floating[Any]]] = {"HALF": np.float16, "FLOAT": np.float32}


class BandWriter:
    """Writes `height` rows of `width` pixels directly to `path`, with the sidecar's `text` in the header.

    Raises OSError where the system refuses.
    """

    def __init__(
        self, path: Path, width: int, height: int, channels: int, text: str, half: bool, packing: Compression
    ) -> None:
        """Begin the file; the number of `channels` is 1, 3 or 4."""
        self.clamped = 0
        self._path, self._names, self._height = path, CHANNELS[channels], height
        self._dtype = np.float16 if half else np.float32
        self._most = HALF_MOST if half else float(np.finfo(np.float32).max)
        self._kind = Imath.PixelType(Imath.PixelType.HALF if half else Imath.PixelType.FLOAT)
        header = OpenEXR.Header(width, height)
        header["channels"] = {name: Imath.Channel(self._kind) for name in self._names}
        header["compression"] = Imath.Compression(_COMPRESSIONS[packing])
        header["chromaticities"] = Imath.Chromaticities(*[Imath.V2f(0.0, 0.0)] * 4)
        header[ATTRIBUTE] = text.encode()
        with _as_os_errors():
            self._file = OpenEXR.OutputFile(str(path), header)

    def write(self, rows: Floats) -> None:
        """Write rows (h, W, C) below the previous ones, row 0 the lowest; values are clamped to the range."""
        self.clamped += int(np.count_nonzero(np.abs(rows) > self._most))
        stored = np.clip(rows[::-1], -self._most, self._most).astype(self._dtype)
        pixels = {name: stored[..., place].tobytes() for place, name in enumerate(self._names)}
        with _as_os_errors():
            self._file.writePixels(pixels, len(rows))

    def close(self) -> None:
        """Finish the file, and check that it is complete: OpenEXR does not report failures of last writes."""
        with _as_os_errors():
            self._file.close()
            _set_chromaticities(self._path)
            written = OpenEXR.InputFile(str(self._path))
            written.channel(self._names[0], self._kind, self._height - 1, self._height - 1)
            written.close()


@contextmanager
def _as_os_errors() -> Iterator[None]:
    """Turn errors into OSError: OpenEXR raises several types, depending on where it fails."""
    try:
        yield
    except (RuntimeError, TypeError, ValueError) as error:
        raise OSError(" ".join(str(error).split()).rstrip(".")) from error


def _set_chromaticities(path: Path) -> None:
    with path.open("r+b") as file:
        place = file.read(_HEADER_BYTES).find(_NO_CHROMATICITIES)
        if place >= 0:
            file.seek(place + len(_NO_CHROMATICITIES) - 32)
            file.write(struct.pack("<8f", *REC_709))


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
