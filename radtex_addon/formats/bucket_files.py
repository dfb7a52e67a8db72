# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake in the bucket layout: a sidecar `<name>.<kind>.json`, the atlas and its layers.

The number of samples of each texel, if they differ, is a line of text in the sidecar: run-length encoded, row
by row from the bottom: "16x1200 24x30 16x15018" means 1200 texels with 16 samples per cell, then 30 with 24,
and so on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.errors import BakeError, FormatError, ShapeError
from .containers.exr import CHANNELS, Compression, header_text, read_pixels
from .containers.exr_rows import BandWriter, ImageRows, open_rows
from .disk.atomic import replacing
from .image_files import layer_path
from .sidecar import Sidecar, read_sidecar
from .sidecar_file import AnySidecar, SidecarFile, mismatch_error, opened

_RUN = re.compile(r"([1-9]\d{0,17})x([1-9]\d{0,9})")
BASE = "base"  # the only layer with one value per texel instead of a bucket
_NO_LIGHT = ("normal", "rest")  # have signed values, while DWAA's losses are meant for light
_COLOURS = 3


def write_buckets(
    path: Path,
    atlas: Floats,
    layers: Mapping[str, Floats],
    bake: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> Sidecar:
    """`write_bands` for an atlas (H*n, W*n, 1, 3 or 4) and layers that are completely in memory."""
    images = {"": atlas, **layers}
    steps = write_bands(path, lambda: iter([images]), tuple(layers), bake, half, compression)
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            written: Sidecar = stop.value
            return written


def write_bands(
    path: Path,
    bands: Callable[[], Iterator[Mapping[str, Floats]]],
    layers: Sequence[str],
    bake: Sidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> Generator[int, None, Sidecar]:
    """Write the sidecar to `path`, the atlas and its layers beside it: all files, or none.

    Yields the number of rows of texels done. `bands` returns bands of rows from the top down, each a part of
    the atlas, named "", and of all `layers`: (h*n, W*n, 1, 3 or 4) and (h*n, W*n, 3), for the base (h, W, 3);
    row 0 is the lowest, light is scene-linear Rec.709. It is called again if values were clamped. Values
    beyond the files' range, infinities included, are clamped to it. Returns `bake` with the layers' names and
    the number of clamped values. Raises ShapeError for an image of another size, BakeError for values that
    are not numbers and where the system refuses.
    """
    sidecar = replace(bake, layers=tuple(layers))
    with ExitStack() as files:  # entered first, left last: the sidecar is renamed after its images
        text = files.enter_context(replacing(path))
        images = {name: files.enter_context(replacing(image_path(path, name))) for name in ("", *layers)}
        clamped = yield from _fill(path, images, bands(), sidecar, half, compression)
        if clamped:  # the headers, at the beginning of the files, must hold the number: write all again
            sidecar = replace(sidecar, clamped=clamped)
            yield from _fill(path, images, bands(), sidecar, half, compression)
        text.write_text(sidecar.to_json(), encoding="utf-8", newline="\n")
    return sidecar


def _fill(
    sidecar_path: Path,
    images: Mapping[str, Path],
    bands: Iterator[Mapping[str, Floats]],
    sidecar: Sidecar,
    half: bool,
    compression: Compression,
) -> Generator[int, None, int]:
    """Write all images; yields the number of rows of texels done, returns that of clamped values."""
    writers: dict[str, BandWriter] = {}
    done = 0
    for band in bands:
        rows = len(band[""]) // sidecar.bucket
        for name, path in images.items():
            _check_shape(name, band[name], sidecar, rows)
            if name not in writers:
                lossless = name in _NO_LIGHT and compression is Compression.DWAA
                packing = Compression.ZIP if lossless else compression
                width, height = size_of(sidecar, name)
                channels = band[name].shape[2]
                text = sidecar.to_json()
                writers[name] = BandWriter(path, width, height, channels, text, half, packing)
            if wrong := int(np.count_nonzero(np.isnan(band[name]))):
                image = image_path(sidecar_path, name)
                raise BakeError(
                    f"{image} was not written: {wrong} of its values are not numbers; bake it again"
                )
            writers[name].write(band[name])
        done += rows
        yield done
    if done != sidecar.height:
        raise ShapeError(f"the atlas: expected {sidecar.height} rows of texels, got {done}")
    for writer in writers.values():
        writer.close()
    return sum(writer.clamped for writer in writers.values())


def _check_shape(name: str, image: Floats, sidecar: Sidecar, rows: int) -> None:
    cells = 1 if name == BASE else sidecar.bucket
    allowed = CHANNELS if not name else (_COLOURS,)
    expected = (rows * cells, sidecar.width * cells)
    if image.ndim != 3 or image.shape[:2] != expected or image.shape[2] not in allowed:
        what = f"layer {name}" if name else "the atlas"
        raise ShapeError(f"{what}: expected shape {(*expected, *allowed)}, got {image.shape}")


def read_layer(sidecar: AnySidecar, layer: str) -> Floats:
    """Read a layer of a bake as it is stored, row 0 at the bottom.

    (H*n, W*n, 3), or (H, W, 3) for the base. Raises FormatError, with the path, for a layer that the bake
    does not have, and as `exr.read_buckets` does.
    """
    file = opened(sidecar)
    facts, image = read_sidecar(file), image_path(file.path, layer)
    if layer not in facts.layers:
        known = ", ".join(facts.layers) or "none"
        raise FormatError(f"{file} has no layer {layer}: its layers are {known}")
    if Sidecar.from_json(header_text(image), f"the header of {image}") != facts:
        raise mismatch_error(image, file)
    return read_pixels(image, *size_of(facts, layer), [_COLOURS])


def image_path(path: Path, layer: str) -> Path:
    """The path of a layer's image beside the sidecar `path`; of the atlas for the layer ""."""
    return layer_path(path, layer) if layer else path.with_suffix(".exr")


def size_of(bake: Sidecar, layer: str) -> tuple[int, int]:
    """Width and height in pixels of a layer's image."""
    cells = 1 if layer == BASE else bake.bucket
    return bake.width * cells, bake.height * cells


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


def count_text(counts: Ints) -> str:
    """Encode samples (H, W), row 0 at v = 0, as text; empty if all are equal."""
    flat = counts.ravel()
    starts = np.flatnonzero(np.concatenate([[True], flat[1:] != flat[:-1]]))
    if len(starts) == 1:
        return ""
    lengths = np.diff([*starts, len(flat)])
    return " ".join(f"{value}x{length}" for value, length in zip(flat[starts], lengths, strict=True))


def read_counts(text: str, width: int, height: int, source: str) -> Ints:
    """Inverse of `count_text`: samples (H, W). Raises FormatError, with the `source`, if malformed."""
    runs = [_RUN.fullmatch(word) for word in text.split(" ")]
    pairs = [(int(run[1]), int(run[2])) for run in runs if run is not None]
    told = sum(length for _, length in pairs)
    if len(pairs) < len(runs) or told != width * height:
        raise FormatError(
            f'{source} has a "texel_samples" that does not tell {width} x {height} texels: bake it again'
        )
    values, lengths = zip(*pairs, strict=True)
    return np.repeat(np.array(values, dtype=np.int64), lengths).reshape(height, width)
