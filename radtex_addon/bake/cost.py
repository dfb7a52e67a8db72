# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake costs at most; computed by `cost` in `forms/NAME/form.py`, or inherited from the buckets."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from ..formats.image_files import Shapes
from .spec import BakeSpec

_GPU_CHANNELS = 4  # a GPU texture of three channels takes as much memory as one of four


@dataclass(frozen=True)
class Cost:
    """Upper limits for a bake of a square atlas.

    `side`: pixels of the largest image's longer side; `disk`: bytes of all images before compression; `gpu`:
    bytes of the same images as textures without mip levels; `memory`: bytes of main memory during the bake;
    `paths`: camera paths.
    """

    side: int
    disk: int
    gpu: int
    memory: int
    paths: int


def cost_of_images(spec: BakeSpec, shapes: Shapes) -> Cost:
    """The cost of a bake whose images, of floats, have these widths, heights and channels."""
    value = 2 if spec.half else 4
    return Cost(
        side=max(max(shape[:2]) for shape in shapes.values()),
        disk=value * sum(prod(shape) for shape in shapes.values()),
        gpu=value * _GPU_CHANNELS * sum(width * height for width, height, _ in shapes.values()),
        memory=spec.atlas_bytes,
        paths=spec.path_count,
    )
