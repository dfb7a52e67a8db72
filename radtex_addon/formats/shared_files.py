# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake in the shared layout: a sidecar `<name>.<kind>.json` and its images beside it."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core.arrays import Floats
from ..core.errors import FormatError
from ..core.shared import SharedAtlas
from .atomic import replacing
from .exr import Compression, header_text, read_pixels, stored_rows, write_rows
from .packing import (
    COLOUR,
    ENDS,
    IRRADIANCE,
    SURROUNDINGS,
    pack,
    unpack_lobe,
    unpack_surroundings,
)
from .shared_sidecar import SharedSidecar
from .sidecar import Sidecar, read_text


def layer_path(sidecar: Path, layer: str) -> Path:
    """The image of `layer` beside a sidecar's file: Vase.radiance.json has Vase.radiance.colour.exr."""
    return sidecar.with_name(f"{sidecar.stem}.{layer}.exr")


def write_shared(
    path: Path,
    atlas: SharedAtlas,
    bake: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> SharedSidecar:
    """Write the sidecar to `path` and the atlas's images beside it; all of them, or none.

    `bake` says what the atlas does not know of itself; its `layers` and `clamped` are found here, and are in
    the returned sidecar. Values beyond the files' range, infinities included, are clamped to it. Raises
    ShapeError if the atlas does not fit `bake` or the files, BakeError for values that are not numbers and
    where the system refuses.
    """
    sidecar = SharedSidecar.of(atlas, bake)
    stored: dict[str, Floats] = {}
    clamped = 0
    for layer, image in pack(atlas).items():
        stored[layer], beyond = stored_rows(layer_path(path, layer), image, half)
        clamped += beyond
    sidecar = replace(sidecar, bake=replace(sidecar.bake, clamped=clamped))
    text = sidecar.to_json()
    with (
        ExitStack() as files
    ):  # left last first: the sidecar takes its place once all its images are in theirs
        files.enter_context(replacing(path)).write_text(text, encoding="utf-8", newline="\n")
        for layer, rows in stored.items():
            beside = files.enter_context(replacing(layer_path(path, layer)))
            no_light = layer.endswith(ENDS)  # which is all that dwaa's losses are made for
            lossless = no_light and compression is Compression.DWAA
            write_rows(beside, rows, text, Compression.ZIP if lossless else compression)
    return sidecar


def read_shared(path: Path) -> tuple[SharedAtlas, SharedSidecar]:
    """The bake whose sidecar is the file `path`; float32.

    Raises FormatError, with the path, for a sidecar or an image that is missing, damaged, not ours, of a
    newer version, of another bake, or not of the size that the sidecar says.
    """
    sidecar = read_shared_sidecar(path)
    images = {layer: _read_layer(path, sidecar, layer) for layer in sidecar.shapes}
    atlas = SharedAtlas(
        colour=images[COLOUR].astype(np.float32),
        irradiance=images[IRRADIANCE].astype(np.float32),
        falloff=np.array(sidecar.falloff, dtype=np.float32),
        surroundings=unpack_surroundings(images[SURROUNDINGS], sidecar.surroundings, sidecar.levels),
        sharpest=sidecar.sharpest,
        lobes=tuple(
            unpack_lobe(images, axis, sidecar.bake.bucket, sidecar.sharpest) for axis in sidecar.lobes
        ),
    )
    return atlas, sidecar


def read_shared_sidecar(path: Path) -> SharedSidecar:
    """Read a sidecar's file. Raises FormatError, with the path, if it is missing or not of this layout."""
    return SharedSidecar.from_json(read_text(path), str(path))


def _read_layer(path: Path, sidecar: SharedSidecar, layer: str) -> Floats:
    """An image of the sidecar at `path`, as it is stored."""
    image = layer_path(path, layer)
    if SharedSidecar.from_json(header_text(image), f"the header of {image}") != sidecar:
        raise FormatError(
            f"{image} is of another bake than {path}: put one bake's files together, or bake again"
        )
    width, height, channels = sidecar.shapes[layer]
    return read_pixels(image, width, height, [channels])
