# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenEXR files: the atlas, and the renders that Blender writes.

An EXR's first row is the top one, ours is the bottom one (v = 0): rows are flipped here and nowhere else.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenEXR

from ...core import large_arrays
from ...core.arrays import Floats
from ...core.colour_spaces import REC_709
from ...core.errors import BakeError, FormatError, ShapeError
from ..disk.atomic import replacing
from ..disk.regular import open_regular
from ..sidecar import Sidecar, read_sidecar
from ..sidecar_file import AnySidecar, mismatch_error, opened
from .compression import Compression as Compression  # noqa: PLC0414  # for those who write EXR files
from .exr_size import check_memory_for, check_size

HALF_MOST = 65504.0  # the largest finite half float
ATTRIBUTE = "radtex"  # the header attribute that holds the sidecar's JSON

CHANNELS = {4: "RGBA", 3: "RGB", 1: "Y"}  # channel names by the number of channels
_MAGIC = bytes((0x76, 0x2F, 0x31, 0x01))
_ORDER = "RGBXYZWUVA"  # order of a layer's channels
_FLAT = (OpenEXR.scanlineimage, OpenEXR.tiledimage)  # not deep
_DWAA_LOSS = 0.05
_ROWS = 64  # rows converted at once


_COMPRESSIONS = {
    Compression.ZIP: OpenEXR.ZIP_COMPRESSION,
    Compression.PIZ: OpenEXR.PIZ_COMPRESSION,
    Compression.DWAA: OpenEXR.DWAA_COMPRESSION,
}


def write_atlas(
    path: Path,
    pixels: Floats,
    sidecar: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> Sidecar:
    """Write an atlas (H*n, W*n, C), row 0 at the bottom, scene-linear Rec.709; C is 1, 3 or 4.

    Values beyond the file's range, infinities included, are clamped to it. Returns the sidecar with the
    number of clamped values, as in the header; write that beside the image. On failure an existing file
    `path` is unchanged. Raises ShapeError if pixels and sidecar differ in size, BakeError for values that are
    not numbers and where the system refuses.
    """
    expected = (sidecar.height * sidecar.bucket, sidecar.width * sidecar.bucket)
    if pixels.ndim != 3 or pixels.shape[:2] != expected or pixels.shape[2] not in CHANNELS:
        raise ShapeError(f"atlas pixels: expected shape {(*expected, '1, 3 or 4')}, got {pixels.shape}")
    rows, clamped = stored_rows(path, pixels, half)
    sidecar = replace(sidecar, clamped=clamped)
    with replacing(path) as beside:
        write_rows(beside, rows, sidecar.to_json(), compression)
    return sidecar


def read_atlas(path: Path) -> tuple[Floats, Sidecar]:
    """Read an atlas's pixels (H*n, W*n, C), float16 or float32 as stored, and the sidecar in its header.

    Row 0 is at the bottom. Raises FormatError, with the path, for a file that is missing, cut short, too
    large for this machine's memory, not an EXR, not ours, of a newer version, or not as its header says.
    """
    sidecar = Sidecar.from_json(header_text(path), f"the header of {path}")
    width, height = sidecar.width * sidecar.bucket, sidecar.height * sidecar.bucket
    return read_pixels(path, width, height), sidecar


def read_buckets(sidecar: AnySidecar) -> tuple[Floats, Sidecar]:
    """`read_atlas` for the image beside a sidecar. Raises FormatError if it is of another bake, too."""
    file = opened(sidecar)
    facts, image = read_sidecar(file), file.path.with_suffix(".exr")
    pixels, inner = read_atlas(image)
    if inner != facts:
        raise mismatch_error(image, file)
    return pixels, facts


def header_text(path: Path) -> str:
    """The sidecar's JSON in the header of a RadTex image. Raises FormatError as `read_atlas` does."""
    header = headers_of(path)[0]
    if ATTRIBUTE not in header:
        raise FormatError(f'{path} has no header attribute "{ATTRIBUTE}": it is no RadTex atlas')
    try:
        return str(header[ATTRIBUTE])
    except UnicodeDecodeError as error:
        raise FormatError(f'{path} is damaged: its attribute "{ATTRIBUTE}" is not text') from error


def stored_size(path: Path) -> tuple[int, int]:
    """Width and height of an image in pixels. Raises FormatError as `read_atlas` does."""
    (x0, y0), (x1, y1) = headers_of(path)[0]["dataWindow"]
    return int(x1) - int(x0) + 1, int(y1) - int(y0) + 1


def loss_of(compression: Compression | None) -> float:
    """Largest relative difference that lossy compression makes between two equal values."""
    return _DWAA_LOSS if compression is Compression.DWAA else 0.0


def stored_compression(path: Path) -> Compression | None:
    """An image's compression, None if RadTex does not use it. Raises FormatError as `read_atlas` does."""
    packed = headers_of(path)[0].get("compression")
    return next((ours for ours, theirs in _COMPRESSIONS.items() if theirs == packed), None)


def read_pixels(path: Path, width: int, height: int, channels: Iterable[int] = CHANNELS) -> Floats:
    """Read the pixels (height, width, C) of a RadTex image, float16 or float32 as stored.

    Row 0 is at the bottom. `channels` are the allowed numbers of channels. Raises FormatError as `read_atlas`
    does.
    """
    headers = headers_of(path)
    count = check_channels(path, headers, channels)
    pixels = _layers(path, headers)[""]
    if pixels.shape != (height, width, count) or pixels.dtype not in (np.float16, np.float32):
        found = f"{pixels.shape[1]} x {pixels.shape[0]} pixels of {pixels.dtype}"
        raise FormatError(f"{path} has {found}, its header says {width} x {height} floats")
    return pixels[::-1]


def read_render(path: Path) -> dict[str, Floats]:
    """Read all layers of an image that Blender wrote: name -> (H, W, C) float32, row 0 at the bottom.

    A layer's name is its channels' names up to the last dot, such as "ViewLayer.Combined"; its channels are
    in the order RGBA, XYZW or UV. An image without layers is called "". Raises FormatError as `read_atlas`.
    """
    layers = _layers(path, headers_of(path))
    return {name: pixels[::-1].astype(np.float32, copy=False) for name, pixels in layers.items()}


def read_stamps(path: Path) -> dict[str, str]:
    """Read the text metadata of an image that Blender wrote, by name: "Note", "Frame", "Software".

    Raises FormatError as `read_atlas` does.
    """
    try:
        return {name: word for name, word in headers_of(path)[0].items() if isinstance(word, str)}
    except UnicodeDecodeError as error:
        raise FormatError(f"{path} is damaged: its header holds what is not text") from error


def read_whole(path: Path) -> tuple[npt.NDArray[Any], list[str]]:
    """Read the pixels (H, W, C) of an image of one layer, as stored, and its channels' names, sorted.

    Row 0 is at the bottom; channels other than RGBA come in the sorted order. Raises FormatError as
    `read_atlas` does.
    """
    headers = headers_of(path)
    names = _channel_names(headers)
    layers = _layers(path, headers)
    if len(layers) != 1:
        raise FormatError(f"{path} has several layers, expected one: bake it again")
    return next(iter(layers.values()))[::-1], names


def stored_rows(path: Path, pixels: Floats, half: bool) -> tuple[Floats, int]:
    """Convert pixels (H, W, C) to the rows for `write_rows`, and count the values that had to be clamped.

    `path` is for errors only. Raises BakeError for values that are not numbers.
    """
    kind = np.float16 if half else np.float32
    most = HALF_MOST if half else float(np.finfo(np.float32).max)
    rows: Floats = large_arrays.empty(pixels.shape, kind)
    clamped = wrong = 0
    for first in range(0, len(pixels), _ROWS):
        some = pixels[::-1][first : first + _ROWS]
        wrong += int(np.count_nonzero(np.isnan(some)))
        clamped += int(np.count_nonzero(np.abs(some) > most))
        rows[first : first + _ROWS] = np.clip(some, -most, most)
    if wrong:
        raise BakeError(f"{path} was not written: {wrong} of its values are not numbers; bake it again")
    return rows, clamped


def write_rows(path: Path, rows: Floats, text: str, compression: Compression) -> None:
    """Write the rows of `stored_rows` directly to `path`, with the sidecar's `text` in the header.

    Raises OSError where the system refuses.
    """
    header = {
        "compression": _COMPRESSIONS[compression],
        "chromaticities": REC_709,
        ATTRIBUTE: text,
        "type": OpenEXR.scanlineimage,
    }
    channels = CHANNELS[rows.shape[2]]
    image = np.ascontiguousarray(rows[..., 0] if channels == "Y" else rows)  # OpenEXR ignores strides
    try:
        OpenEXR.File(header, {channels: image}).write(str(path))
    except RuntimeError as error:
        raise OSError(one_line(error)) from error


def listed(names: list[str]) -> str:
    """Channel names for a message; of many only the first and the last."""
    return ", ".join(names) if len(names) < 5 else f"{names[0]} … {names[-1]}"


def check_channels(path: Path, headers: Iterable[dict[str, Any]], counts: Iterable[int]) -> int:
    """Number of channels of an image. Raises FormatError if it is none of `counts`, or for other names."""
    named = _channel_names(headers)
    allowed = [CHANNELS[count] for count in counts]
    if named not in (sorted(names) for names in allowed):
        raise FormatError(f"{path} has the channels {listed(named)}, expected {' or '.join(allowed)}")
    return len(named)


def _channel_names(headers: Iterable[dict[str, Any]]) -> list[str]:
    """Channel names of all parts, sorted. Raises UnicodeDecodeError."""
    return sorted(channel.name for header in headers for channel in header["channels"])


def headers_of(path: Path) -> list[dict[str, Any]]:
    """Read the parts' headers, and check that the file is a flat EXR large enough for its pixels.

    Raises FormatError, with the path, if not.
    """
    try:
        with open_regular(path) as file:
            magic = file.read(len(_MAGIC))
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
    if magic != _MAGIC:
        raise FormatError(f"{path} is not an OpenEXR file")
    try:
        with hushed():
            parts = OpenEXR.File(str(path), header_only=True).parts
        headers: list[dict[str, Any]] = [part.header for part in parts]
        _channel_names(headers)
    except (RuntimeError, ValueError) as error:
        raise FormatError(f"{path} is damaged: {one_line(error)}") from error
    if not headers:
        raise FormatError(f"{path} is damaged: it has no image in it")
    if any(header["type"] not in _FLAT for header in headers):
        raise FormatError(f"{path} is a deep image: flat ones can be read")
    check_size(path, headers)
    return headers


def _layers(path: Path, headers: list[dict[str, Any]]) -> dict[str, Floats]:
    """Images of all parts, name -> (H, W, C), as stored and with the top row first.

    OpenEXR's module joins R, G, B and A itself; other channels come separately and are joined here.
    """
    check_memory_for(path, headers)
    try:
        with hushed():
            parts: list[Any] = OpenEXR.File(str(path)).parts
    except (RuntimeError, ValueError) as error:
        raise FormatError(f"{path} is damaged: {one_line(error)}") from error
    if len(parts) != len(headers):  # the module drops parts whose pixels it cannot read
        raise FormatError(f"{path} is damaged: its pixels cannot be read; it may be cut short")
    layers: dict[str, Floats] = {}
    loose: dict[str, dict[str, Floats]] = {}
    for name, channel in ((name, channel) for part in parts for name, channel in part.channels.items()):
        layer, _, last = name.rpartition(".")
        if channel.pixels.ndim == 3:
            layers[layer if last in ("RGB", "RGBA") else name] = channel.pixels
        else:
            loose.setdefault(layer, {})[last] = channel.pixels
    for layer, channels in loose.items():
        if len({channel.shape for channel in channels.values()}) > 1:
            raise FormatError(f"{path} has channels of several sizes: save it without subsampling")
        ordered = sorted(channels, key=lambda last: (_ORDER.find(last), last))
        layers[layer] = np.stack([channels[last] for last in ordered], axis=-1)
    return layers


@contextmanager
def hushed() -> Iterator[None]:
    """Suppress what OpenEXR's module and C code print about damaged files: our errors report them."""
    with redirect_stdout(io.StringIO()), _hushed_errors():
        yield


@contextmanager
def _hushed_errors() -> Iterator[None]:
    try:
        before = os.dup(2)
    except OSError:  # a program without standard error
        yield
        return
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        with Path(os.devnull).open("w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(before, 2)
        os.close(before)


def one_line(error: Exception) -> str:
    """The message of OpenEXR's error as one line."""
    return " ".join(str(error).split()).rstrip(".") or type(error).__name__
