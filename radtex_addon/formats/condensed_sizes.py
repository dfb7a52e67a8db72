# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes of the textures of a condensed bake, for choosing the number of clusters that fits a budget."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from ..core.shared import Axis
from .containers.dds import DdsFormat
from .containers.texture import MOST_PIXELS
from .packing import (
    COLOUR,
    ENDS,
    IRRADIANCE,
    LOBE_CHANNELS,
    SURROUNDINGS,
    TEXTURES,
    WEIGHTS,
    lobe_layer,
    surroundings_size,
)

MOST_CLUSTERS = 65536  # of a lobe: a cluster's index has two bytes

Shapes = dict[str, tuple[int, int, int]]


@dataclass(frozen=True)
class CondensedSizes:
    """The parameters that determine the sizes of a condensed bake's textures.

    `width` x `height` texels of the irradiance and the lobes, `bucket` cells along a side of a bucket without
    its border; `colour` is the colour image's width and height, `surroundings` the cells along a side of the
    sharpest of `levels`; `clusters` is the number of each lobe's clusters, each of 1 + `rank` tiles.
    """

    width: int
    height: int
    bucket: int
    colour: tuple[int, int]
    surroundings: int
    levels: int
    clusters: Mapping[Axis, int]
    rank: int = 2

    @property
    def columns(self) -> int:
        """Number of tiles side by side in textures that RadTex writes."""
        return columns_of(self.clusters.values(), self.rank)

    def shapes(self, columns: int) -> Shapes:
        """Each texture's width, height and channels, in the files' order, without padding to whole blocks."""
        shapes: Shapes = {
            COLOUR: (*self.colour, 3),
            IRRADIANCE: (self.width, self.height, 3),
            SURROUNDINGS: (*surroundings_size(self.surroundings, self.levels), 3),
        }
        side = self.bucket + 2
        for axis, clusters in self.clusters.items():
            rows = -(-clusters * (1 + self.rank) // columns)
            shapes[lobe_layer(axis, WEIGHTS)] = (self.width * texel_pixels(self.rank), self.height, 4)
            for part, textures in TEXTURES.items():
                channels = LOBE_CHANNELS[part] // len(textures)
                for texture in textures:
                    shapes[lobe_layer(axis, texture)] = (columns * side, rows * side, channels)
        return shapes

    def misfit(self, columns: int) -> str | None:
        """Why these sizes cannot be textures; None if they can."""
        if self.rank % 4 != 2:
            return f"a rank of {self.rank}, expected 2, 6, 10 and so on"
        if self.clusters and self.bucket % 4 != 2:
            return f"buckets of {self.bucket} cells a side, expected 2, 6, 10, 14 and so on"
        if max(self.clusters.values(), default=1) > MOST_CLUSTERS:
            return f"more than {MOST_CLUSTERS} clusters"
        for layer, (width, height, _) in self.shapes(columns).items():
            if max(width, height) > MOST_PIXELS:
                return f"more than {MOST_PIXELS} pixels along a side of {layer}"
        return None


def columns_of(clusters: Iterable[int], rank: int) -> int:
    """Number of tiles side by side for near-square images of the largest lobe; `clusters` of each lobe."""
    return math.isqrt(max(clusters, default=1) * (1 + rank) - 1) + 1


def texel_pixels(rank: int) -> int:
    """Number of 4-byte pixels for a texel's weights and its cluster's two bytes."""
    return -(-(rank + 2) // 4)


def texture_format(layer: str) -> DdsFormat:
    """The format of a layer's texture."""
    if layer in (COLOUR, IRRADIANCE, SURROUNDINGS):
        return DdsFormat.BC6H_UF16
    texture = layer.partition("_")[2]
    if texture == WEIGHTS:
        return DdsFormat.R8G8B8A8_UNORM
    return DdsFormat.BC5_UNORM if texture in TEXTURES[ENDS] else DdsFormat.BC7_UNORM


def texture_bytes(shapes: Shapes) -> int:
    """Bytes that a condensed bake's textures take on a GPU; `shapes` are those of its sidecar."""
    total = 0
    for layer, (width, height, _) in shapes.items():
        kind = texture_format(layer)
        total += -(-width // kind.side) * -(-height // kind.side) * kind.block_bytes
    return total


def condensed_bytes(sizes: CondensedSizes) -> int:
    """Bytes that the textures take on a GPU, as RadTex writes them."""
    return texture_bytes(sizes.shapes(sizes.columns))


def clusters_within(budget: int, sizes: CondensedSizes) -> int:
    """The greatest number of clusters, the same for each lobe, whose textures fit `budget` bytes; at least 1.

    `sizes` gives the lobes and everything else. A lobe has no more clusters than texels, nor more than a
    texture can hold.
    """
    tiles = (MOST_PIXELS // (sizes.bucket + 2)) ** 2
    most = min(MOST_CLUSTERS, sizes.width * sizes.height, tiles // (1 + sizes.rank))

    def needed(count: int) -> int:
        return condensed_bytes(replace(sizes, clusters=dict.fromkeys(sizes.clusters, count)))

    return max(1, bisect_right(range(1, most + 1), budget, key=needed))
