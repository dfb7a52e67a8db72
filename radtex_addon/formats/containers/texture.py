# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""GPU textures: pixel format, mip levels and layers; encoding from images and decoding."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import prod
from typing import Protocol

import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError, ShapeError
from ..codecs.bc6h import MOST, decode_bc6h, encode_bc6h
from ..codecs.bc7 import Blocks, described
from ..codecs.rgb9e5 import decode_rgb9e5, encode_rgb9e5

MOST_PIXELS = 16384  # a side: the limit of Direct3D 11 and of every GPU that supports it
MOST_LAYERS = 2048  # of an array: the limit of the same GPUs

_SRGB = "_SRGB"
_PACKED = ("BC3", "BC3_SRGB", "BC4", "BC5", "BC6H", "BC7", "BC7_SRGB")
_BYTES = {
    "RGBA16F": 8,
    "RGB9E5": 4,
    "RGBA8": 4,
    "R32UI": 4,
    "RG32UI": 8,
    "BC4": 8,
}  # of a pixel, or a block of 4 x 4 pixels; other blocks have 16


class PixelFormat(StrEnum):
    """How pixels or blocks are stored. BC6H is the unsigned variant; UI are unsigned integers.

    Colours of the SRGB variants are decoded by the GPU before it filters them; alpha is linear in all.
    """

    RGBA16F = "RGBA16F"
    RGB9E5 = "RGB9E5"
    BC6H = "BC6H"
    BC3 = "BC3"
    BC3_SRGB = "BC3_SRGB"
    BC4 = "BC4"
    BC5 = "BC5"
    BC7 = "BC7"
    BC7_SRGB = "BC7_SRGB"
    RGBA8 = "RGBA8"
    RGBA32F = "RGBA32F"
    R32UI = "R32UI"
    RG32UI = "RG32UI"

    @property
    def side(self) -> int:
        """Pixels along a block's side."""
        return 4 if self in _PACKED else 1

    @property
    def block_bytes(self) -> int:
        """The size of a block."""
        return _BYTES.get(self, 16)

    @property
    def is_srgb(self) -> bool:
        """Whether the GPU decodes its colours."""
        return self.endswith(_SRGB)

    @property
    def without_srgb(self) -> PixelFormat:
        """The same blocks or pixels, whose colours the GPU does not decode."""
        return PixelFormat(self.removesuffix(_SRGB))


ENCODED = (PixelFormat.RGBA16F, PixelFormat.RGB9E5, PixelFormat.BC6H)  # the formats for light


@dataclass(frozen=True)
class TextureShape:
    """A texture without its contents: `layers` x `levels` images, the largest of width x height pixels.

    Level L has max(1, width >> L) x max(1, height >> L) pixels. Raises ShapeError beyond the limits of GPUs.
    """

    format: PixelFormat
    width: int
    height: int
    layers: int = 1
    levels: int = 1
    is_array: bool = False

    def __post_init__(self) -> None:
        if misfit := size_misfit(self.width, self.height, self.layers, self.levels):
            raise ShapeError(f"texture: {misfit}")
        if self.layers > 1 and not self.is_array:
            raise ShapeError(f"texture: {self.layers} layers make an array")

    def shape(self, level: int) -> tuple[int, int, int, int]:
        """Shape of a level's blocks: layers, rows, columns, bytes of a block."""
        return blocks_shape(self.format, self.width, self.height, self.layers, level)

    def nbytes(self, level: int) -> int:
        """Bytes of a level, with all its layers."""
        return prod(self.shape(level))


class Encoded(Protocol):
    """A texture whose blocks can be read piece by piece."""

    @property
    def form(self) -> TextureShape:
        """Format, size, layers and levels."""

    def parts(self, level: int, layer: int) -> Iterator[memoryview]:
        """Yield the bytes of one layer of a level in pieces, from the first row on."""


@dataclass(frozen=True, eq=False)
class Texture:
    """A 2D texture, or an array of such, of `width` x `height` pixels.

    `levels` are the mip levels, the largest first, each (layers, rows, columns, bytes of a block) uint8. Rows
    are in the order of the file: ours begin with the bottom one. Raises ShapeError for levels of other shapes
    and beyond the limits of GPUs.
    """

    format: PixelFormat
    width: int
    height: int
    levels: tuple[Blocks, ...]
    is_array: bool = False

    def __post_init__(self) -> None:
        form = self.form
        for level, blocks in enumerate(self.levels):
            expected = form.shape(level)
            if blocks.shape != expected or blocks.dtype != np.uint8:
                raise ShapeError(f"level {level}: expected {expected} of uint8, got {described(blocks)}")

    @property
    def form(self) -> TextureShape:
        """Format, size, layers and levels."""
        count = len(self.levels)
        return TextureShape(self.format, self.width, self.height, self.layers, count, self.is_array)

    @property
    def layers(self) -> int:
        """Number of images of a level: 1 if the texture is no array."""
        return len(self.levels[0]) if self.levels else 0

    @property
    def nbytes(self) -> int:
        """Bytes of GPU memory."""
        return sum(blocks.nbytes for blocks in self.levels)

    def parts(self, level: int, layer: int) -> Iterator[memoryview]:
        """The bytes of one layer of a level, in one piece."""
        yield np.ascontiguousarray(self.levels[level][layer]).data


def most_levels(width: int, height: int) -> int:
    """Number of mip levels down to 1 x 1 pixel."""
    return max(width, height).bit_length()


def size_misfit(width: int, height: int, layers: int, levels: int) -> str | None:
    """Why GPUs refuse a texture of this size; None if they accept it."""
    if not (1 <= width <= MOST_PIXELS and 1 <= height <= MOST_PIXELS):
        return f"{width} x {height} pixels, expected 1 to {MOST_PIXELS} a side"
    if not 1 <= layers <= MOST_LAYERS:
        return f"{layers} layers, expected 1 to {MOST_LAYERS}"
    if not 1 <= levels <= most_levels(width, height):
        return f"{levels} mip levels, expected 1 to {most_levels(width, height)}"
    return None


def blocks_shape(
    pixel_format: PixelFormat, width: int, height: int, layers: int, level: int
) -> tuple[int, int, int, int]:
    """The shape of a level's blocks: layers, rows, columns, bytes of a block."""
    side = pixel_format.side
    rows, columns = (-(-max(1, size >> level) // side) for size in (height, width))
    return layers, rows, columns, pixel_format.block_bytes


def encode_texture(images: Sequence[Floats], pixel_format: PixelFormat, is_array: bool = False) -> Texture:
    """Encode mip levels (layers, H, W, C), the largest first, scene-linear; C is 3 or 4.

    With 3 channels, RGBA16F gets an alpha of 1; with 4, the other formats drop alpha. Values beyond the
    format's range are clamped, also below 0 if it is unsigned. Blocks that reach beyond an edge repeat the
    last pixels. Raises ShapeError for images of other shapes, InputError for values that are not numbers and
    for formats that do not hold light.
    """
    if pixel_format not in ENCODED:
        raise InputError(f"{pixel_format} does not hold light: choose {', '.join(ENCODED)}")
    for image in images:
        if image.ndim != 4 or image.shape[3] not in (3, 4) or not image.size:
            raise ShapeError(f"image: expected shape (layers, H, W, 3 or 4), got {image.shape}")
    height, width = images[0].shape[1:3]
    levels = tuple(np.stack([encode_rows(layer, pixel_format) for layer in image]) for image in images)
    return Texture(pixel_format, width, height, levels, is_array)


def decode_texture(texture: Texture) -> list[Floats]:
    """Decode the mip levels (layers, H, W, C), float32; C is 4 for RGBA16F, else 3.

    Raises FormatError for blocks that RadTex does not write, InputError for formats that do not hold light.
    """
    if texture.format not in ENCODED:
        raise InputError(f"{texture.format} does not hold light: choose {', '.join(ENCODED)}")
    images = []
    for level, blocks in enumerate(texture.levels):
        whole = np.stack([_decoded(layer, texture.format) for layer in blocks])
        images.append(whole[:, : max(1, texture.height >> level), : max(1, texture.width >> level)])
    return images


def encode_rows(image: Floats, pixel_format: PixelFormat) -> Blocks:
    """Encode an image (H, W, 3 or 4), or some of its rows, as blocks, as `encode_texture` does."""
    if pixel_format is PixelFormat.RGB9E5:
        return encode_rgb9e5(image[..., :3])
    if pixel_format is PixelFormat.BC6H:
        height, width = image.shape[:2]
        filled = np.pad(image[..., :3], ((0, -height % 4), (0, -width % 4), (0, 0)), mode="edge")
        return encode_bc6h(filled)
    if wrong := np.count_nonzero(np.isnan(image)):
        raise InputError(f"image: {wrong} of its values are not numbers; bake it again")
    half = np.ones((*image.shape[:2], 4), "<f2")
    half[..., : image.shape[2]] = np.clip(image, -MOST, MOST)
    return half.view(np.uint8)


def _decoded(blocks: Blocks, pixel_format: PixelFormat) -> Floats:
    """Decode one layer's blocks to an image."""
    if pixel_format is PixelFormat.RGB9E5:
        return decode_rgb9e5(blocks)
    if pixel_format is PixelFormat.BC6H:
        return decode_bc6h(blocks)
    return np.ascontiguousarray(blocks).view("<f2").astype(np.float32)
