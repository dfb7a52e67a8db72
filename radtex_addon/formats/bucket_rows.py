# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the images of a bake in the bucket layout in bands of rows."""

from __future__ import annotations

from pathlib import Path

from ..core.errors import FormatError
from .bucket_files import image_path, size_of
from .containers.exr import header_text
from .containers.exr_rows import ImageRows, open_rows
from .sidecar import Sidecar, read_sidecar
from .sidecar_file import AnySidecar, SidecarFile, mismatch_error, opened

_COLOURS = 3


def open_buckets(sidecar: AnySidecar) -> tuple[ImageRows, Sidecar]:
    """`exr.read_buckets` for reading in bands of rows. Raises FormatError as that does."""
    file = opened(sidecar)
    facts = read_sidecar(file)
    return open_rows(_checked(file, facts, ""), *size_of(facts, "")), facts


def open_layer(sidecar: AnySidecar, layer: str) -> ImageRows:
    """`bucket_files.read_layer` for reading in bands of rows. Raises FormatError as that does."""
    file = opened(sidecar)
    facts = read_sidecar(file)
    if layer not in facts.layers:
        known = ", ".join(facts.layers) or "none"
        raise FormatError(f"{file} has no layer {layer}: its layers are {known}")
    return open_rows(_checked(file, facts, layer), *size_of(facts, layer), [_COLOURS])


def _checked(file: SidecarFile, facts: Sidecar, layer: str) -> Path:
    """The path of a layer's image. Raises FormatError if its header does not match the sidecar."""
    image = image_path(file.path, layer)
    if Sidecar.from_json(header_text(image), f"the header of {image}") != facts:
        raise mismatch_error(image, file)
    return image
