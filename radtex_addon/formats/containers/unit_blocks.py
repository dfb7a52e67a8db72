# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures of values in 0..1, in blocks: what light is in a range of its own, and what is no light."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError, ShapeError
from ..codecs.bc3 import decode_bc3, encode_bc3
from ..codecs.bc4 import decode_bc4, encode_bc4
from ..codecs.bc7 import SIDE, Blocks, decode_bc7, encode_bc7
from ..codecs.srgb import from_srgb, to_srgb
from .texture import PixelFormat, Texture

CHANNELS = {
    PixelFormat.BC3: 4,
    PixelFormat.BC3_SRGB: 4,
    PixelFormat.BC4: 1,
    PixelFormat.BC7: 4,
    PixelFormat.BC7_SRGB: 4,
}
_AT_ONCE = 1 << 18  # pixels


def encode_units(
    levels: Sequence[Floats], pixel_format: PixelFormat, weight: Floats | None = None
) -> Texture:
    """Encode mip levels (H, W, C) of linear values in 0..1, the largest first; C is that of CHANNELS.

    Values outside are clamped. Blocks that reach beyond an edge repeat the last pixels. `weight` (H, W),
    above 0, tells how much the first level's colours count in BC3. Raises InputError for other formats and
    for values that are not numbers, ShapeError for images of other shapes.
    """
    channels = CHANNELS.get(pixel_format)
    if channels is None:
        raise InputError(f"{pixel_format} does not hold values in 0..1: choose {', '.join(CHANNELS)}")
    for image in levels:
        if image.ndim != 3 or image.shape[2] != channels or not image.size:
            raise ShapeError(f"image: expected shape (H, W, {channels}), got {image.shape}")
    weights = [weight, *([None] * (len(levels) - 1))]
    blocks = [
        np.concatenate(list(_bands(image, pixel_format, by)))[None]
        for image, by in zip(levels, weights, strict=True)
    ]
    height, width = levels[0].shape[:2]
    return Texture(pixel_format, width, height, tuple(blocks))


def decode_units(texture: Texture) -> tuple[Floats, ...]:
    """Decode the mip levels of a texture that is no array: linear values (H, W, C) float32 in 0..1.

    Raises InputError for formats that `encode_units` does not write, FormatError for blocks that it does not.
    """
    if texture.format not in CHANNELS:
        raise InputError(f"{texture.format} does not hold values in 0..1: choose {', '.join(CHANNELS)}")
    found = []
    for level, blocks in enumerate(texture.levels):
        image = _decoded(blocks[0], texture.format)
        found.append(image[: max(1, texture.height >> level), : max(1, texture.width >> level)])
    return tuple(found)


def _bands(image: Floats, pixel_format: PixelFormat, weight: Floats | None) -> Iterator[Blocks]:
    """Encode some rows at a time, which bounds what that takes beside the image."""
    rows = max(1, _AT_ONCE // image.shape[1] // SIDE) * SIDE
    for first in range(0, len(image), rows):
        band = _filled(image[first : first + rows])
        by = None if weight is None else _filled(weight[first : first + rows])
        yield _encoded(band, pixel_format, by)


def _encoded(image: Floats, pixel_format: PixelFormat, weight: Floats | None) -> Blocks:
    if pixel_format is PixelFormat.BC4:
        return encode_bc4(image)
    if pixel_format.is_srgb:
        image = np.dstack([to_srgb(image[..., :3]), image[..., 3]])
    if pixel_format.without_srgb is PixelFormat.BC3:
        return encode_bc3(image, np.ones(image.shape[:2], np.float32) if weight is None else weight)
    return encode_bc7(image)


def _decoded(blocks: Blocks, pixel_format: PixelFormat) -> Floats:
    if pixel_format is PixelFormat.BC4:
        return decode_bc4(blocks)
    bc3 = pixel_format.without_srgb is PixelFormat.BC3
    image = decode_bc3(blocks) if bc3 else decode_bc7(blocks)
    if pixel_format.is_srgb:
        image = np.dstack([from_srgb(image[..., :3]), image[..., 3]])
    return image


def _filled(image: Floats) -> Floats:
    """An image (H, W, ...) to whole blocks, by its last column and row again."""
    more = [(0, -size % SIDE) for size in image.shape[:2]]
    return np.pad(image, more + [(0, 0)] * (image.ndim - 2), mode="edge")
