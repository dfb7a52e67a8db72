# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake weighs: on disk as it is, and on a GPU by the format that a game would give its textures."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from ..core.arrays import Floats
from ..formats.condensed_sizes import Shapes, texture_bytes, texture_format
from ..formats.containers.exr import read_pixels
from .finished import Finished

_HALF_PIXEL = 8  # bytes: four half floats, for no GPU has three
_SHARED_EXPONENT_PIXEL = 4  # RGB9E5
_BLOCK, _BLOCK_SIDE = 16, 4  # BC6H: bytes of a block of 4 x 4 pixels


@dataclass(frozen=True)
class ImageSize:
    """An image's bytes; `rgb9e5` and `bc6h` are None where the format cannot hold what is in it.

    Neither has an alpha, and RGB9E5 has no values below 0.
    """

    name: str
    width: int
    height: int
    disk: int
    rgba16f: int
    rgb9e5: int | None
    bc6h: int | None


@dataclass(frozen=True)
class TextureSize:
    """A condensed bake's texture: bytes of its file, and on a GPU, which takes it as it is stored."""

    name: str
    width: int
    height: int
    format: str
    disk: int
    gpu: int


def sizes_of(bake: Finished) -> list[ImageSize] | list[TextureSize]:
    """Every image of a bake. Raises FormatError where one cannot be read."""
    return image_sizes(bake) if bake.budget is None else texture_sizes(bake)


def texture_sizes(bake: Finished) -> list[TextureSize]:
    """Every texture of a condensed bake, in the files' order."""
    return [
        TextureSize(
            name=texture.name,
            width=shape[0],
            height=shape[1],
            format=texture_format(layer).name,
            disk=texture.stat().st_size,
            gpu=texture_bytes({layer: shape}),
        )
        for texture, (layer, shape) in zip(bake.images, _shapes(bake).items(), strict=True)
    ]


def image_sizes(bake: Finished) -> list[ImageSize]:
    """Every image of a bake that is not condensed. Raises FormatError where one cannot be read."""
    sizes = []
    for image, (width, height, _) in zip(bake.images, _shapes(bake).values(), strict=True):
        pixels = read_pixels(image, width, height)
        opaque = pixels.shape[2] < 4 or bool((pixels[..., 3] == 1).all())
        sizes.append(
            ImageSize(
                name=image.name,
                width=width,
                height=height,
                disk=image.stat().st_size,
                rgba16f=width * height * _HALF_PIXEL,
                rgb9e5=width * height * _SHARED_EXPONENT_PIXEL if opaque and _positive(pixels) else None,
                bc6h=ceil(width / _BLOCK_SIDE) * ceil(height / _BLOCK_SIDE) * _BLOCK if opaque else None,
            )
        )
    return sizes


def gpu_bytes(bake: Finished, texels: int = 1, cells: int = 1) -> int:
    """Bytes on a GPU as RGBA16F; with `texels` and `cells` times as many along a side.

    A condensed bake's textures are counted as they are stored.
    """
    shapes = _shapes(bake, texels, cells)
    if bake.budget is not None:
        return texture_bytes(shapes)
    return sum(width * height * _HALF_PIXEL for width, height, _ in shapes.values())


def _shapes(bake: Finished, texels: int = 1, cells: int = 1) -> Shapes:
    """Width, height and channels of each image by its layer, in the order of `bake.images`."""
    return bake.form.shapes(bake.path, texels, cells)


def _positive(pixels: Floats) -> bool:
    return bool((pixels[..., :3].astype(np.float32) >= 0).all())
