# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The most that a bake can cost, known before it starts: as if islands covered all texels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod

from ..core.shared import Axis, level_count
from ..formats.condensed_sizes import CondensedSizes, Shapes, clusters_within, condensed_bytes
from ..formats.packing import COLOUR, IRRADIANCE, LOBE_CHANNELS, SURROUNDINGS, lobe_layer, surroundings_size
from .layers import OF_LAYER, WHOLE, Layer
from .rays import FINER
from .spec import BakeSpec

_LARGEST_BUDGET = 2**40
_GPU_CHANNELS = 4  # a GPU texture of three channels takes as much


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


def cost_of(spec: BakeSpec) -> Cost:
    """The most that a bake of `spec` can cost."""
    shapes = _shapes(spec)
    value = 2 if spec.half else 4
    disk = value * sum(prod(shape) for shape in shapes.values())
    gpu = value * _GPU_CHANNELS * sum(width * height for width, height, _ in shapes.values())
    if spec.condensed:
        sizes = _condensed_sizes(spec)
        shapes = sizes.shapes(sizes.columns)
        disk = gpu = min(condensed_bytes(sizes), spec.budget or _LARGEST_BUDGET)
    side = max(max(shape[:2]) for shape in shapes.values())
    return Cost(side=side, disk=disk, gpu=gpu, memory=spec.atlas_bytes, paths=spec.path_count)


def _shapes(spec: BakeSpec) -> Shapes:
    """Width, height and channels of each image, assuming a square atlas with both lobes."""
    if not spec.form.by_paths:
        side = spec.pixels_a_side
        layers: Shapes = {
            layer: (*((spec.texels,) * 2 if layer is Layer.BASE else (side,) * 2), OF_LAYER)
            for layer in spec.layers
        }
        return {"atlas": (side, side, WHOLE)} | layers
    texels, side, around = spec.texels, spec.pixels_a_side, spec.rays.size
    return {
        COLOUR: (FINER * texels, FINER * texels, 3),
        IRRADIANCE: (texels, texels, 3),
        SURROUNDINGS: (*surroundings_size(around, level_count(around)), 3),
    } | {
        lobe_layer(axis, part): (side, side, channels)
        for axis in Axis
        for part, channels in LOBE_CHANNELS.items()
    }


def _condensed_sizes(spec: BakeSpec) -> CondensedSizes:
    """The sizes with as many clusters as the budget allows, or, without a budget, as there are texels."""
    largest = CondensedSizes(
        width=spec.texels,
        height=spec.texels,
        bucket=spec.bucket,
        colour=(FINER * spec.texels, FINER * spec.texels),
        surroundings=spec.rays.size,
        levels=level_count(spec.rays.size),
        clusters=dict.fromkeys(Axis, 1),
    )
    count = clusters_within(spec.budget or _LARGEST_BUDGET, largest)
    return replace(largest, clusters=dict.fromkeys(Axis, count))
