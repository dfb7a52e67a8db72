# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake in buckets: a sidecar `<name>.<kind>.json`, its atlas, and its layers beside them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from ..core.arrays import Floats
from ..core.errors import FormatError, ShapeError
from .atomic import replacing
from .exr import Compression, header_text, read_pixels, stored_rows, write_rows
from .shared_files import layer_path
from .sidecar import Sidecar, read_sidecar

BASE = "base"  # the one layer that has a value for a texel, and no buckets
_NO_LIGHT = ("normal", "rest")  # signed: dwaa's losses are made for light
_COLOURS = 3


def write_buckets(
    path: Path,
    atlas: Floats,
    layers: Mapping[str, Floats],
    bake: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> Sidecar:
    """Write the sidecar to `path`, the atlas (H*n, W*n, 1, 3 or 4) and its layers beside it; all, or none.

    Layers are (H*n, W*n, 3), the base (H, W, 3); row 0 is at the bottom, light is scene-linear Rec.709.
    Values beyond the files' range, infinities included, are clamped to it. Returns `bake` with the layers'
    names and the number of clamped values. Raises ShapeError for an image of another size, BakeError for
    values that are not numbers and where the system refuses.
    """
    named = {"": atlas, **layers}
    stored: dict[str, Floats] = {}
    clamped = 0
    for name, image in named.items():
        channels = image.shape[2:] if not name else (_COLOURS,)
        expected = (*size_of(bake, name)[::-1], *channels)
        if image.shape != expected:
            raise ShapeError(f"{image_path(path, name).name}: expected shape {expected}, got {image.shape}")
        stored[name], beyond = stored_rows(image_path(path, name), image, half)
        clamped += beyond
    sidecar = replace(bake, layers=tuple(layers), clamped=clamped)
    text = sidecar.to_json()
    with ExitStack() as files:  # what is entered first is left last: the sidecar takes its place at the end
        files.enter_context(replacing(path)).write_text(text, encoding="utf-8", newline="\n")
        for name, rows in stored.items():
            lossless = name in _NO_LIGHT and compression is Compression.DWAA
            beside = files.enter_context(replacing(image_path(path, name)))
            write_rows(beside, rows, text, Compression.ZIP if lossless else compression)
    return sidecar


def read_layer(path: Path, layer: str) -> Floats:
    """A layer of the bake whose sidecar is the file `path`, as it is stored, row 0 at the bottom.

    (H*n, W*n, 3), or (H, W, 3) for the base. Raises FormatError, with the path, for a layer that the bake
    does not have, and as `exr.read_buckets` does.
    """
    sidecar, image = read_sidecar(path), image_path(path, layer)
    if layer not in sidecar.layers:
        known = ", ".join(sidecar.layers) or "none"
        raise FormatError(f"{path} has no layer {layer}: its layers are {known}")
    if Sidecar.from_json(header_text(image), f"the header of {image}") != sidecar:
        raise FormatError(
            f"{image} is of another bake than {path}: put one bake's files together, or bake again"
        )
    return read_pixels(image, *size_of(sidecar, layer), [_COLOURS])


def image_path(path: Path, layer: str) -> Path:
    """The image of a layer beside the sidecar `path`; of the atlas itself for none."""
    return layer_path(path, layer) if layer else path.with_suffix(".exr")


def size_of(bake: Sidecar, layer: str) -> tuple[int, int]:
    """Width and height in pixels of a layer's image."""
    cells = 1 if layer == BASE else bake.bucket
    return bake.width * cells, bake.height * cells
