# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A layered atlas as the images that its files and textures have; row 0 is at the bottom.

Maps of the surface are plain images. Buckets are an image of [cell row][cell column] tiles, each with one
texel for every texel that has a bucket, so that one lookup filters the four texels of a cell. Octahedral
pictures have their outermost texels' centres on the square's edge (`lookup.edge_grid`) and need no border:
the sharpest level, and beside it a column of the others, each above the one before.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import accumulate

import numpy as np

from ....core import large_arrays
from ....core.arrays import Floats
from ..lookup.atlas import LayeredAtlas
from ..lookup.distance_field import DistanceField, FieldFacts, columns_of
from ..lookup.edge_grid import EdgeImpostor, EdgePictures, on_edges
from ..lookup.environment import Impostor, Pictures, SurroundingLayer
from ..lookup.ways import Through

COLOUR, IRRADIANCE, TINT, NORMAL, WIDTH, ALPHA = "colour", "irradiance", "tint", "normal", "width", "alpha"
TANGENT = "tangent"
OWN, REST = "own", "rest"
WORLD, PLANE, THINGS, DISTANCES = "world", "plane", "things", "distances"
EXIT_DIRECTION, EXIT_PLACE, FIELD = "exit_direction", "exit_place", "field"
THROUGH_COLOUR, THROUGH_REST = "through_colour", "through_rest"

# The channels of all layers, in the files' order.
CHANNELS = {
    COLOUR: 3,
    IRRADIANCE: 3,
    TINT: 3,
    NORMAL: 3,
    WIDTH: 1,
    ALPHA: 1,
    TANGENT: 3,
    OWN: 4,
    REST: 3,
    WORLD: 3,
    PLANE: 4,
    THINGS: 4,
    DISTANCES: 1,
    EXIT_DIRECTION: 4,
    EXIT_PLACE: 4,
    FIELD: 4,
    THROUGH_COLOUR: 3,
    THROUGH_REST: 3,
}
OF_MATERIAL = (COLOUR, TINT, NORMAL, ALPHA)  # maps that an engine may have in the object's own material
OF_IMAGES = (COLOUR, TINT, NORMAL)  # maps in whose place the material's own images can be read
PICTURES = (WORLD, PLANE, THINGS)
BLOCK = 4  # tiles are padded to whole blocks of compressed textures, on the right and at the top


def arranged(atlas: LayeredAtlas) -> dict[str, Floats]:
    """The atlas's images by layer, (rows, columns, C) float32; only layers that it has.

    Raises ValueError for more layers of surroundings than a plane and, before it, other things.
    """
    images: dict[str, Floats | None] = {
        COLOUR: atlas.colour,
        IRRADIANCE: atlas.irradiance,
        TINT: atlas.tint,
        NORMAL: atlas.normal,
        WIDTH: atlas.width,
        ALPHA: atlas.alpha,
        TANGENT: atlas.tangent,
        OWN: tiled(atlas.own),
        REST: tiled(atlas.rest),
        WORLD: packed(levels_on_edges(atlas.around.world)),
    }
    plane, things = near_layers(atlas)
    if plane is not None:
        images[PLANE] = packed(levels_on_edges(plane.pictures))
    if things is not None:
        images[THINGS] = packed(levels_on_edges(things.pictures))
        images[DISTANCES] = distances_on_edges(things)
    if atlas.through is not None:
        ways = tiled(atlas.through.ways)
        images |= {EXIT_DIRECTION: ways[..., :4], EXIT_PLACE: ways[..., 4:]}
        if atlas.through.field is not None:
            images[FIELD] = layers_beside(atlas.through.field)
        images |= {THROUGH_COLOUR: atlas.through.colour, THROUGH_REST: tiled(atlas.through.rest)}
    return {
        name: np.ascontiguousarray(images[name], dtype=np.float32)
        for name in CHANNELS
        if images.get(name) is not None
    }


def through_of(
    images: Mapping[str, Floats],
    cells: int,
    rest_cells: int,
    size: tuple[int, int],
    field: FieldFacts | None = None,
) -> Through:
    """What comes through, of the images of `arranged`; buckets of width x height texels.

    `field`: the facts of the field through which ways are followed, if any.
    """
    ways = np.concatenate([images[EXIT_DIRECTION], images[EXIT_PLACE]], axis=2)
    rest = untiled(images[THROUGH_REST], rest_cells, size)
    followed = None if field is None else field_beside(images[FIELD], field)
    return Through(untiled(ways, cells, size), images[THROUGH_COLOUR], rest, followed)


def layers_beside(field: DistanceField) -> Floats:
    """A field's values as an image (H, W, 4): its layers of equal z, row by row."""
    width, height, depth = field.facts.size
    columns = columns_of(field.facts.size)
    rows = -(-depth // columns)
    whole = np.zeros((rows * columns, height, width, 4), dtype=np.float32)
    whole[:depth] = field.values
    return whole.reshape(rows, columns, height, width, 4).swapaxes(1, 2).reshape(rows * height, -1, 4)


def field_beside(image: Floats, facts: FieldFacts) -> DistanceField:
    """The inverse of `layers_beside`."""
    width, height, depth = facts.size
    layers = (
        image.reshape(-1, height, columns_of(facts.size), width, 4)
        .swapaxes(1, 2)
        .reshape(-1, height, width, 4)
    )
    return DistanceField(np.ascontiguousarray(layers[:depth]), facts)


def near_layers(atlas: LayeredAtlas) -> tuple[SurroundingLayer | None, SurroundingLayer | None]:
    """The plane, or planes, and the other things around an atlas. Raises ValueError for any other layers."""
    found: list[SurroundingLayer | None] = [None, None]
    for layer in atlas.around.layers:
        place = int(isinstance(layer.shape, Impostor))
        if found[place] is not None or (place == 0 and found[1] is not None):
            raise ValueError("surroundings: expected a plane and, before it, other things, each at most once")
        found[place] = layer
    return found[0], found[1]


def levels_on_edges(pictures: Pictures) -> tuple[Floats, ...]:
    """The pictures' levels with their outermost texels on the square's edge."""
    if isinstance(pictures, EdgePictures):
        return pictures.levels
    return tuple(on_edges(level) for level in pictures.levels)


def distances_on_edges(things: SurroundingLayer) -> Floats:
    """One over the distances of what lies in each direction, (D, D, 1), likewise."""
    shape = things.shape
    assert isinstance(shape, Impostor)  # what is no plane
    nearness = shape.nearness[..., None]
    return nearness if isinstance(shape, EdgeImpostor) else on_edges(nearness)


def packed(levels: tuple[Floats, ...]) -> Floats:
    """Levels (M, M, C), (M / 2, M / 2, C) and so on as one image (M, M + M / 2, C); one level as it is."""
    size, channels = len(levels[0]), levels[0].shape[2]
    width, height = packed_size(size, len(levels))
    image = np.zeros((height, width, channels), dtype=np.float32)
    for level, (x, y, side) in zip(levels, level_places(size, len(levels)), strict=True):
        image[y : y + side, x : x + side] = level
    return image


def unpacked(image: Floats, size: int, count: int) -> tuple[Floats, ...]:
    """The inverse of `packed`."""
    places = level_places(size, count)
    return tuple(np.ascontiguousarray(image[y : y + side, x : x + side]) for x, y, side in places)


def packed_size(size: int, count: int) -> tuple[int, int]:
    """Width and height of the image of so many levels."""
    return (size + size // 2 if count > 1 else size), size


def level_places(size: int, count: int) -> Iterator[tuple[int, int, int]]:
    """Column, row and side of each level in the image of `packed`."""
    yield 0, 0, size
    sides = [size >> number for number in range(1, count)]
    for side, end in zip(sides, accumulate(sides), strict=True):
        yield size, end - side, side


def padded_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height to whole blocks."""
    width, height = (side + -side % BLOCK for side in size)
    return width, height


def tiled(buckets: Floats) -> Floats:
    """Buckets (h, w, n, n, C) as tiles (n H, n W, C), H and W being h and w to whole blocks.

    The padding has the values of the last column and row.
    """
    height, width, n = buckets.shape[:3]
    columns, rows = padded_size((width, height))
    more = [(0, rows - height), (0, columns - width), (0, 0), (0, 0), (0, 0)]
    wide = np.pad(buckets, more, mode="edge") if (rows, columns) != (height, width) else buckets
    image = large_arrays.empty((n, rows, n, columns, buckets.shape[4]), wide.dtype)
    image[:] = np.moveaxis(wide, (2, 3), (0, 2))
    return image.reshape(n * rows, n * columns, buckets.shape[4])


def untiled(image: Floats, n: int, size: tuple[int, int]) -> Floats:
    """The inverse of `tiled`: buckets of n x n cells for width x height texels."""
    columns, rows = padded_size(size)
    tiles = image.reshape(n, rows, n, columns, -1)
    width, height = size
    return np.ascontiguousarray(np.moveaxis(tiles, (0, 2), (2, 3))[:height, :width])
