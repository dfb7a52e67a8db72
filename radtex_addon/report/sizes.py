# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The size of a bake, on disk and on a GPU in the formats that games choose; and what showing it takes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil

import numpy as np

from ..core.arrays import Floats
from ..formats.containers.exr import read_pixels
from ..formats.disk.memory import check_allowed
from ..formats.image_files import Shapes
from ..formats.sidecar_file import AnySidecar, opened
from ..forms import form_in
from .finished_bake import Finished

_JUDGED = 16  # bytes per pixel while a report reads the images
_SHOWN = 28  # bytes per pixel in Blender and Cycles together
_HALF_PIXEL = 8  # bytes: four half floats, as GPUs have no format of three
_SHARED_EXPONENT_PIXEL = 4  # RGB9E5
_BLOCK, _BLOCK_SIDE = 16, 4  # BC6H: bytes of a block of 4 x 4 pixels


def check_judged(sidecar: AnySidecar, allowed_mb: int | None) -> None:
    """Make sure that a report fits into memory. Raises as `check_allowed` does, and FormatError."""
    file = opened(sidecar)
    needed = _pixels(file) * _JUDGED
    check_allowed(f"a report on {sidecar}", needed, allowed_mb)


def check_shown(sidecars: Iterable[AnySidecar], allowed_mb: int | None) -> None:
    """Make sure that a render of bakes fits into memory. Raises as `check_allowed` does, and FormatError."""
    named = tuple(sidecars)
    needed = sum(_pixels(sidecar) for sidecar in named) * _SHOWN
    check_allowed(f"a picture of {', '.join(map(str, named))}", needed, allowed_mb)


def _pixels(sidecar: AnySidecar) -> int:
    """The number of pixels in a bake's images, without its extra layers."""
    file = opened(sidecar)
    shapes = form_in(file.facts).shapes(file)
    return sum(width * height for width, height, _ in shapes.values())


@dataclass(frozen=True)
class ImageSize:
    """An image's bytes; `rgb9e5` and `bc6h` are None if the format cannot hold the image's values.

    Neither has an alpha, and RGB9E5 has no values below 0.
    """

    name: str
    width: int
    height: int
    disk: int
    rgba16f: int
    rgb9e5: int | None
    bc6h: int | None


def sizes_of(bake: Finished) -> list[ImageSize]:
    """The sizes of a bake's images. Raises FormatError if one cannot be read."""
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
    """A bake's bytes on a GPU, as RGBA16F.

    `texels` and `cells` are factors of their numbers along a side, for the size of a larger bake.
    """
    shapes = _shapes(bake, texels, cells)
    return sum(width * height * _HALF_PIXEL for width, height, _ in shapes.values())


def _shapes(bake: Finished, texels: int = 1, cells: int = 1) -> Shapes:
    """Width, height and channels of each image by its layer, in the order of `bake.images`."""
    return bake.form.shapes(bake.file, texels, cells)


def _positive(pixels: Floats) -> bool:
    return bool((pixels[..., :3].astype(np.float32) >= 0).all())
