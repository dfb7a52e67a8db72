# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake that has several images: a sidecar, and an EXR beside it for each layer."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

from ..core.arrays import Floats
from ..core.errors import FormatError
from .containers.exr import Compression, stored_rows, write_rows
from .disk.atomic import replacing
from .file_names import is_plain_stem
from .json_reader import shown

Shapes: TypeAlias = dict[str, tuple[int, int, int]]  # width, height and channels of images, by layer


def layer_path(sidecar: Path, layer: str) -> Path:
    """The EXR of `layer` beside a sidecar's file: Vase.radiance.json has Vase.radiance.colour.exr.

    Raises FormatError for a layer of which no file can have the name, as a stranger's sidecar may have them.
    """
    if not is_plain_stem(layer):
        raise FormatError(f"{sidecar} has a layer {shown(json.dumps(layer))}: no file can be called so")
    return sidecar.with_name(f"{sidecar.stem}.{layer}.exr")


def write_images(
    path: Path,
    images: Mapping[str, Floats],
    text_of: Callable[[int], str],
    half: bool,
    compression: Compression,
    no_light: Collection[str],
) -> int:
    """Write the sidecar to `path` and `images` (H, W, C), by layer, beside it; all of them, or none.

    `text_of` gives the sidecar's JSON for the number of values that were clamped to the files' range, which
    is returned. Layers that hold `no_light` are spared DWAA's losses, which are meant for light. Raises
    BakeError for values that are not numbers and where the system refuses.
    """
    stored: dict[str, Floats] = {}
    clamped = 0
    for layer, image in images.items():
        stored[layer], beyond = stored_rows(layer_path(path, layer), image, half)
        clamped += beyond
    text = text_of(clamped)
    # Entered first, left last: the sidecar is renamed after all its images.
    with ExitStack() as files:
        files.enter_context(replacing(path)).write_text(text, encoding="utf-8", newline="\n")
        for layer, rows in stored.items():
            beside = files.enter_context(replacing(layer_path(path, layer)))
            lossless = layer in no_light and compression is Compression.DWAA
            write_rows(beside, rows, text, Compression.ZIP if lossless else compression)
    return clamped
