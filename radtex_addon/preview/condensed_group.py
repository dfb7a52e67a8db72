# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A condensed lobe as shader nodes: each texel's bucket is a mixture of the tiles of its cluster.

The nodes' images have the layout of the condensed form's textures, but are decoded: tiles hold values instead
of fractions of a range, each part (ends, gain, rest) is one image, and a texel's pixels hold its weights, its
cluster and a 0.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.condensed import CondensedAtlas
from ..core.shared import Axis
from ..formats.condensed_packing import layer_values
from ..formats.packing import LOBE_CHANNELS, TEXTURES, WEIGHTS, lobe_layer, with_border
from ..scene.nodes import NodeBuilder, Socket, close_group, open_group
from .taps import after, image_size, pair, pixel_centre


def condensed_layers(atlas: CondensedAtlas, columns: int) -> dict[str, Floats]:
    """The group's images by layer: (rows, columns, 3 or 4) float32, row 0 at the bottom.

    The lobes' images are `columns` tiles wide. Raises ShapeError if the atlas's maps do not fit each other.
    """
    layers = layer_values(atlas)
    for lobe in atlas.lobes:
        rest = np.zeros_like(lobe.weights, shape=(*lobe.cluster.shape, 1))
        named = np.concatenate([lobe.weights, lobe.cluster[..., None], rest], axis=2, dtype=np.float32)
        layers[lobe_layer(lobe.axis, WEIGHTS)] = named.reshape(len(named), -1, 4)
        for part in LOBE_CHANNELS:
            layers[lobe_layer(lobe.axis, part)] = _grid(layers[lobe_layer(lobe.axis, part)], columns)
    return layers


def image_layer(layer: str) -> str:
    """The group's image for a texture's layer: "mirror_ends" for "mirror_ends_xy" and "mirror_ends_zs"."""
    axis, _, texture = layer.partition("_")
    part = next((part for part, textures in TEXTURES.items() if texture in textures), texture)
    return f"{axis}_{part}" if texture else layer


def mixture_group(
    axis: Axis, tile: bpy.types.ShaderNodeTree, weights: bpy.types.Image, rank: int, columns: int
) -> bpy.types.ShaderNodeTree:
    """A node group that looks up a texel's bucket: its cluster's first tile plus the weighted others.

    Inputs: Texel and Place, on the octahedron. `tile` is the group that looks up one tile, by its column and
    row in the lobe's images instead of the texel; its outputs are the same.
    """
    build, (texel, place) = open_group(f"RadTex {axis.title()} Mixture", Texel="Vector", Place="Vector")
    *shares, cluster = _named(build, texel, weights, rank)
    first = build.math("MULTIPLY", cluster, 1.0 + rank, label="the cluster's first tile")
    mixed = list(build.group(tile, _tile_place(build, first, columns), place))
    for number, share in enumerate(shares, start=1):
        following = after(build, build.math("ADD", first, float(number)), mixed)
        some = build.group(tile, _tile_place(build, following, columns), place)
        mixed = [_add(build, total, share, part) for total, part in zip(mixed, some, strict=True)]
    shift, spread, gain, rest = mixed
    return close_group(build, Shift=shift, Spread=spread, Gain=gain, Rest=rest)


def _grid(tiles: Floats, columns: int) -> Floats:
    """Arrange tiles (C, 1 + r, n, n, channels), with borders added, row by row in an image."""
    bordered = with_border(tiles.reshape(-1, *tiles.shape[2:]))
    count, side, _, channels = bordered.shape
    rows = -(-count // columns)
    places = np.zeros((rows * columns, side, side, channels), dtype=np.float32)
    places[:count] = bordered
    return AtlasLayout(columns, rows, side).from_buckets(places.reshape(rows, columns, side, side, channels))


def _named(build: NodeBuilder, texel: Socket, image: bpy.types.Image, rank: int) -> list[Socket]:
    """Read a texel's `rank` weights and then its cluster, which is never stored in an alpha channel."""
    pixels = (rank + 2) // 4
    first = build.vector("MULTIPLY", texel, pair(pixels, 1), label="the texel's first pixel")
    values: list[Socket] = []
    for number in range(pixels):
        pixel = build.vector("ADD", first, pair(number, 0)) if number else first
        color, alpha = build.image(image, pixel_centre(build, pixel, image_size(image)))
        values += [*build.node("ShaderNodeSeparateColor", color).outputs, alpha]
    return values[: rank + 1]


def _tile_place(build: NodeBuilder, tile: Socket, columns: int) -> Socket:
    """Column and row of a tile by its number."""
    middle = build.math("MULTIPLY_ADD", tile, 1 / columns, 0.5 / columns, label="between whole numbers")
    row = build.math("FLOOR", middle, label="row")
    return build.combine(build.math("MULTIPLY_ADD", row, -float(columns), tile, label="column"), row)


def _add(build: NodeBuilder, total: Socket, share: Socket, part: Socket) -> Socket:
    """`total` + `share` * `part`, for numbers and colours."""
    if part.type == "VALUE":
        return build.math("MULTIPLY_ADD", share, part, total)
    return build.mix(share, total, part, part.type, "ADD")
