# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Images that were painted and not saved: Blender does not write them into a copy of the file.

Their pixels are written beside the copy, raw, so that the session's images are only read. Tiled images
(UDIM) are the exception: Python sees the pixels of their first tile only, so Blender saves copies of the
tiles, and no longer calls them generated.
"""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bpy  # noqa: TID251  # of this package, handover and images know Blender
import numpy as np

from ..core.errors import FormatError, InputError
from ..formats.containers.numpy_files import read_npy
from ..formats.disk.regular import other_kind, read_regular
from ..formats.json_reader import shown

log = logging.getLogger(__name__)

_LIST = "images.json"
_OWN = re.compile(r"\d+\.(npy|<UDIM>\.(exr|png))", re.ASCII)  # files that are written here
_SIDE = 65536  # pixels of a side at most, Blender's limit


@dataclass(frozen=True)
class _Entry:
    """An image and where its pixels are: (H, W, 4) float32 or uint8, or tiles as image files."""

    name: str
    library: str | None
    file: str
    tiled: bool


def save_unsaved(folder: Path) -> bool:
    """Write the pixels of unsaved images into a new `folder`; returns whether there are any.

    Raises OSError or RuntimeError if that fails.
    """
    entries = []
    for index, image in enumerate(_unsaved()):
        folder.mkdir(exist_ok=True)
        tiled = image.source == "TILED"
        if tiled:
            file = f"{index}.<UDIM>.{'exr' if image.is_float else 'png'}"
            image.save(filepath=str(folder / file), save_copy=True)
        else:
            file = f"{index}.npy"
            np.save(folder / file, _pixels(image))
        entries.append(_Entry(image.name, _library(image), file, tiled))
    if entries:
        listed = json.dumps([asdict(entry) for entry in entries])
        (folder / _LIST).write_text(listed, encoding="utf-8")
    return bool(entries)


def load_unsaved(folder: Path) -> None:
    """Give the open file's images the pixels that `save_unsaved` wrote, and pack them. Raises InputError."""
    try:
        for entry in _entries(folder):
            for image in _named(entry):
                _load(image, folder / entry.file, entry.tiled)
    except (OSError, ValueError, TypeError, RuntimeError, RecursionError, FormatError) as error:
        reason = shown(" ".join(str(error).split()), 300)
        raise InputError(f"{folder} holds no unsaved images ({reason}): hand the scene over again") from error


def _entries(folder: Path) -> list[_Entry]:
    """The entries of the list in the folder. Raises OSError, ValueError for a file that is no such list."""
    found = json.loads(read_regular(folder / _LIST))
    if not isinstance(found, list):
        raise TypeError(f"{_LIST} is no list")
    entries = [_Entry(**entry) for entry in found]
    for entry in entries:
        texts = [entry.name, entry.file] + ([] if entry.library is None else [entry.library])
        if not all(isinstance(text, str) for text in texts) or not isinstance(entry.tiled, bool):
            raise ValueError(f"{_LIST} is no list of images")
        if not _OWN.fullmatch(entry.file):
            raise ValueError(f"{entry.file} is no file of its own")
    return entries


def _unsaved() -> Iterator[Any]:
    image: Any
    for image in bpy.data.images:
        if not image.is_dirty or image.type in {"RENDER_RESULT", "COMPOSITING"}:
            continue
        if image.source in {"FILE", "GENERATED", "TILED"}:
            yield image
        else:
            log.warning("image '%s' has unsaved changes, which the bake will not show: save it", image.name)


def _named(entry: _Entry) -> Iterator[Any]:
    """The image of that name; None if nothing used it and Blender left it out of the file."""
    for image in bpy.data.images:
        if (image.name, _library(image)) == (entry.name, entry.library):
            yield image


def _library(image: Any) -> str | None:
    return None if image.library is None else str(image.library.name)


def _pixels(image: Any) -> Any:
    """The pixels (H, W, channels): bytes for an 8-bit image, which take a quarter of the space of floats."""
    width, height = image.size
    pixels = np.empty((height, width, image.channels), dtype=np.float32)
    image.pixels.foreach_get(pixels.ravel())
    if image.is_float:
        return pixels
    np.multiply(pixels, 255, out=pixels)
    return np.rint(pixels, out=pixels).astype(np.uint8)


def _load(image: Any, file: Path, tiled: bool) -> None:
    if tiled:
        for tile in image.tiles:
            if kind := other_kind(Path(str(file).replace("<UDIM>", str(tile.number)))):
                raise ValueError(f"{file.name} is {kind} and no file")
        image.filepath_raw = str(file)
        image.reload()
    else:
        pixels = read_npy(file, "fu")
        if pixels.ndim != 3 or not 0 < min(pixels.shape) <= max(pixels.shape) <= _SIDE:
            raise ValueError(f"{file.name} holds no image")
        if pixels.dtype not in (np.float32, np.uint8) or pixels.shape[2] not in (1, 2, 3, 4):
            raise ValueError(f"{file.name} holds no image's values")
        height, width, _ = pixels.shape
        image.source = "GENERATED"  # of the right size, whatever is on the disk
        image.generated_width, image.generated_height = width, height
        image.use_generated_float = pixels.dtype == np.float32
        values = pixels if pixels.dtype == np.float32 else pixels.astype(np.float32) / 255
        image.pixels.foreach_set(np.ascontiguousarray(values).ravel())
        image.update()
    image.pack()  # Cycles then takes it from memory, and a saved preview keeps it
