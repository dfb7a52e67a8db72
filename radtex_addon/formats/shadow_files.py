# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The file of a `shadow` bake: W x H pixels whose channels are 32-bit words, one bit per cell.

Channels are called word0000, word0001 …, so that sorting by name keeps the order of bits.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenEXR

from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.errors import FormatError, InputError, ShapeError
from ..core.shadow import unpack_bits, word_count
from .containers.exr import ATTRIBUTE, Compression, header_text, listed, read_whole
from .disk.atomic import replacing
from .sidecar import Sidecar, read_sidecar
from .sidecar_file import AnySidecar, mismatch_error, opened

KIND = "shadow"
_MOST_CELLS = 512  # along a bucket's side: 8192 channels

_LOSSLESS = {
    Compression.ZIP: OpenEXR.ZIP_COMPRESSION,
    Compression.PIZ: OpenEXR.PIZ_COMPRESSION,
}

Words = npt.NDArray[np.uint32]


def channel_names(bucket: int) -> list[str]:
    """The channels of buckets of `bucket` x `bucket` cells, in order."""
    return [f"word{index:04d}" for index in range(word_count(bucket))]


def write_shadow(
    path: Path, words: Words, sidecar: Sidecar, compression: Compression = Compression.ZIP
) -> None:
    """Write words (H, W, w) of `core.shadow.pack_bits`, row 0 at the bottom.

    The header holds the sidecar. On failure an existing file `path` is unchanged. Raises ShapeError if words
    and sidecar differ in size, InputError for a lossy compression, BakeError where the system refuses.
    """
    expected = (sidecar.height, sidecar.width, word_count(sidecar.bucket))
    if words.shape != expected or words.dtype != np.uint32:
        raise ShapeError(f"words: expected {expected} of uint32, got {words.shape} of {words.dtype}")
    if compression not in _LOSSLESS:
        raise InputError(f"compression {compression} keeps no bits: choose {', '.join(_LOSSLESS)}")
    header = {
        "compression": _LOSSLESS[compression],
        ATTRIBUTE: sidecar.to_json(),
        "type": OpenEXR.scanlineimage,
    }
    rows = words[::-1]
    channels: dict[str, Any] = {
        name: np.ascontiguousarray(rows[..., index])  # OpenEXR ignores strides
        for index, name in enumerate(channel_names(sidecar.bucket))
    }
    with replacing(path) as beside:
        try:
            OpenEXR.File(header, channels).write(str(beside))
        except RuntimeError as error:
            raise OSError(" ".join(str(error).split())) from error


def read_shadow(path: Path) -> tuple[Words, Sidecar]:
    """Read a shadow's EXR: words (H, W, w), row 0 at the bottom, and the sidecar.

    Raises FormatError, with the path, for a file that is missing, damaged, of another kind, or whose size,
    channels or pixels do not match its header.
    """
    sidecar = Sidecar.from_json(header_text(path), f"the header of {path}")
    if sidecar.kind != KIND:
        raise FormatError(f"{path} is of kind {sidecar.kind}, not {KIND}: name a bake of shadows")
    if sidecar.bucket > _MOST_CELLS:
        raise FormatError(f"{path} has buckets of {sidecar.bucket} cells a side, {_MOST_CELLS} are the most")
    names = channel_names(sidecar.bucket)
    pixels, found = read_whole(path)
    if found != names:
        raise FormatError(f"{path} has the channels {listed(found)}, expected {listed(names)}: bake it again")
    expected = (sidecar.height, sidecar.width)
    if pixels.shape[:2] != expected or pixels.dtype != np.uint32:
        size = f"{pixels.shape[1]} x {pixels.shape[0]} pixels of {pixels.dtype}"
        raise FormatError(f"{path} has {size}, its header says {sidecar.width} x {sidecar.height} of uint32")
    return pixels.astype(np.uint32, copy=False), sidecar


def visible_buckets(sidecar: AnySidecar) -> tuple[Floats, Sidecar]:
    """Read a shadow as visibilities, like `exr.read_buckets`: (H*n, W*n, 1) float32, 1 is visible."""
    words, facts = read_shadow_of(sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    seen = (~unpack_bits(words, facts.bucket)).astype(np.float32)[..., None]
    return layout.from_buckets(seen), facts


def read_shadow_of(sidecar: AnySidecar) -> tuple[Words, Sidecar]:
    """`read_shadow` for the EXR beside a sidecar. Raises FormatError if it is of another bake, too."""
    file = opened(sidecar)
    facts, image = read_sidecar(file), file.path.with_suffix(".exr")
    words, inner = read_shadow(image)
    if inner != facts:
        raise mismatch_error(image, file)
    return words, facts
