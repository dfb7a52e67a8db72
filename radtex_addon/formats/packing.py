# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout as images that a shader looks up by plain bilinear filtering; row 0 is at the bottom.

For that every octahedral image has a border of one cell, a copy of the cells across its edge on the sphere.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain

import numpy as np

from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.condensed import CondensedLobe
from ..core.octahedron import octahedron_taps
from ..core.shared import LEAST_LEVEL, Axis, Lobe, SharedAtlas, level_sizes

COLOUR, IRRADIANCE, SURROUNDINGS = "colour", "irradiance", "surroundings"
ENDS, GAIN, REST = "ends", "gain", "rest"
LOBE_CHANNELS = {ENDS: 4, GAIN: 3, REST: 3}
WEIGHTS = "weights"  # only in condensed lobes, before the other parts
ENDS_XY, ENDS_ZS = "ends_xy", "ends_zs"  # shift's x and y, its z and the spread
# The textures of each part of a condensed lobe: a part's channels are split evenly among its textures.
TEXTURES = {ENDS: (ENDS_XY, ENDS_ZS), GAIN: (GAIN,), REST: (REST,)}


def layer_names(lobes: Iterable[Axis], condensed: bool = False) -> tuple[str, ...]:
    """The images of an atlas with these lobes, in the files' order."""
    parts = [WEIGHTS, *chain(*TEXTURES.values())] if condensed else [*LOBE_CHANNELS]
    return (
        COLOUR,
        IRRADIANCE,
        SURROUNDINGS,
        *(lobe_layer(axis, part) for axis in lobes for part in parts),
    )


def lobe_layer(axis: Axis, part: str) -> str:
    """The name of a lobe's layer, such as "mirror_ends"."""
    return f"{axis}_{part}"


def pack(atlas: SharedAtlas) -> dict[str, Floats]:
    """The atlas's images by `layer_names`, (rows, columns, C) float32.

    A lobe's spread is stored in units of `sharpest`: half floats are too coarse below 6e-5, and filtering
    needs variances. The falloff and the order of lobes are in the sidecar.
    """
    images = {
        COLOUR: atlas.colour,
        IRRADIANCE: atlas.irradiance,
        SURROUNDINGS: pack_surroundings(atlas.surroundings),
    }
    for lobe in atlas.lobes:
        parts = stored_parts(lobe, atlas.sharpest)
        images |= {lobe_layer(lobe.axis, part): pack_buckets(buckets) for part, buckets in parts.items()}
    return {name: image.astype(np.float32, copy=False) for name, image in images.items()}


def unpack_lobe(images: Mapping[str, Floats], axis: Axis, bucket: int, sharpest: float) -> Lobe:
    """Unpack a lobe with buckets of `bucket` x `bucket` cells from the `images` of `pack`; float32."""
    ends, gain, rest = (unpack_buckets(images[lobe_layer(axis, part)], bucket) for part in LOBE_CHANNELS)
    parts = (ends * ends_unit(sharpest), gain, rest)
    return Lobe(axis, *(part.astype(np.float32) for part in parts))


def stored_parts(lobe: Lobe | CondensedLobe, sharpest: float) -> dict[str, Floats]:
    """A lobe's buckets by part, with ends in the files' units."""
    return {ENDS: lobe.ends / ends_unit(sharpest), GAIN: lobe.gain, REST: lobe.rest}


def ends_unit(sharpest: float) -> Floats:
    """The units of the channels of stored ends, (4,) float32."""
    return np.array([1, 1, 1, sharpest], dtype=np.float32)


def pack_buckets(buckets: Floats) -> Floats:
    """Buckets (H, W, n, n, C) with their borders, joined to an image (H*(n+2), W*(n+2), C)."""
    height, width, n = buckets.shape[:3]
    return AtlasLayout(width, height, n + 2).from_buckets(with_border(buckets))


def unpack_buckets(image: Floats, bucket: int) -> Floats:
    """Inverse of `pack_buckets`: (H, W, n, n, C), a view without the borders."""
    side = bucket + 2
    layout = AtlasLayout(image.shape[1] // side, image.shape[0] // side, side)
    return layout.to_buckets(image)[:, :, 1:-1, 1:-1]


def pack_surroundings(levels: tuple[Floats, ...]) -> Floats:
    """All levels (size, size, C) with borders in one image: the first, beside it a column of the others."""
    size = len(levels[0])
    width, height = surroundings_size(size, len(levels))
    image = np.zeros((height, width, levels[0].shape[2]), dtype=levels[0].dtype)
    for level, (x, y, side) in zip(levels, level_places(size, len(levels)), strict=True):
        image[y : y + side + 2, x : x + side + 2] = with_border(level)
    return image


def unpack_surroundings(image: Floats, size: int, count: int) -> tuple[Floats, ...]:
    """Inverse of `pack_surroundings`: the levels, float32, without borders."""
    return tuple(
        image[y + 1 : y + 1 + side, x + 1 : x + 1 + side].astype(np.float32)
        for x, y, side in level_places(size, count)
    )


def surroundings_size(size: int, count: int) -> tuple[int, int]:
    """Width and height of the image of `count` levels, the first with `size` cells a side."""
    column = sum(side + 2 for side in level_sizes(size, count)[1:])
    return size + 2 + max(size // 2, LEAST_LEVEL) + 2, max(size + 2, column)


def level_places(size: int, count: int) -> Iterator[tuple[int, int, int]]:
    """Each level in the image of `pack_surroundings`: column and row of its border's corner, and its side."""
    yield 0, 0, size
    row = 0
    for side in level_sizes(size, count)[1:]:
        yield size + 2, row, side
        row += side + 2


def with_border(images: Floats) -> Floats:
    """Add a border of one cell to octahedral images (..., n, n, C): (..., n + 2, n + 2, C)."""
    n = images.shape[-2]
    # Corners lie between the centres of cells. The first of the four taps around each is the lower left cell,
    # so that the border begins at -1.
    corners = np.stack(np.meshgrid(np.arange(n + 2), np.arange(n + 2)), axis=-1) / n
    cell, _ = next(octahedron_taps(corners, n))
    cells = images.reshape(*images.shape[:-3], n * n, images.shape[-1])
    bordered: Floats = cells[..., cell, :]
    return bordered
