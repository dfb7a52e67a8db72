# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the images of a bake in the bucket layout in bands of rows."""

from __future__ import annotations

from pathlib import Path

from ..core.errors import FormatError
from .bucket_files import image_path, size_of
from .containers.exr import header_text
from .containers.image_rows import ImageRows, open_rows
from .sidecar import Sidecar, read_sidecar

_COLOURS = 3


def open_buckets(path: Path) -> tuple[ImageRows, Sidecar]:
    """`exr.read_buckets` for reading in bands of rows. Raises FormatError as that does."""
    sidecar = read_sidecar(path)
    return open_rows(_checked(path, sidecar, ""), *size_of(sidecar, "")), sidecar


def open_layer(path: Path, layer: str) -> ImageRows:
    """`bucket_files.read_layer` for reading in bands of rows. Raises FormatError as that does."""
    sidecar = read_sidecar(path)
    if layer not in sidecar.layers:
        known = ", ".join(sidecar.layers) or "none"
        raise FormatError(f"{path} has no layer {layer}: its layers are {known}")
    return open_rows(_checked(path, sidecar, layer), *size_of(sidecar, layer), [_COLOURS])


def _checked(path: Path, sidecar: Sidecar, layer: str) -> Path:
    """The path of a layer's image. Raises FormatError if its header does not match the sidecar."""
    image = image_path(path, layer)
    if Sidecar.from_json(header_text(image), f"the header of {image}") != sidecar:
        raise FormatError(
            f"{image} is of another bake than {path}: put one bake's files together, or bake again"
        )
    return image
