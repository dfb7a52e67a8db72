# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write an OpenEXR file in bands from the top row downwards, so that it may be larger than memory."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import Imath
import numpy as np
import OpenEXR

from ...core.arrays import Floats
from ...core.colour_spaces import REC_709
from .exr import ATTRIBUTE, CHANNELS, HALF_MOST, Compression

_COMPRESSIONS = {
    Compression.ZIP: Imath.Compression.ZIP_COMPRESSION,
    Compression.PIZ: Imath.Compression.PIZ_COMPRESSION,
    Compression.DWAA: Imath.Compression.DWAA_COMPRESSION,
}
# OpenEXR's module writes zeros as chromaticities when it writes by rows.
_NO_CHROMATICITIES = b"chromaticities\0chromaticities\0" + struct.pack("<i8f", 32, *[0.0] * 8)
_HEADER_BYTES = 1 << 20  # more than any header of ours


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
