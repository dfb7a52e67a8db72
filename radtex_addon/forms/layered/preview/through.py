# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that comes through, by shader nodes: `lookup.ways.look_through`.

Sixteen rays, of four texels and four cells, are looked up twice: first to find the strongest, then to add up
those that go where it does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import bpy

from ....preview.node_group import bucket_group
from ....preview.taps import after, clamp, pair, pixel_centre, readable_size
from ....scene.nodes import NodeBuilder, Operand, Socket, close_group, open_group
from ..files.arrangement import EXIT_DIRECTION, EXIT_PLACE, THROUGH_COLOUR, THROUGH_REST
from ..files.sidecar import LayeredSidecar
from .images import buckets_group, map_group, position_of
from .surroundings import shaded_lamps

_APART, _ALIKE, _EVEN = 0.8, 0.95, 0.03  # as in lookup.ways

_Images = Mapping[str, bpy.types.Image]


def through_group(
    images: _Images,
    facts: LayeredSidecar,
    octahedron: bpy.types.ShaderNodeTree,
    around: bpy.types.ShaderNodeTree,
) -> bpy.types.ShaderNodeTree:
    """What the chief paths show, and the rest of what comes through: Light.

    Inputs: UV; Offset from the middle; the mesh's Normal, Tangent and the bitangent's Sign; Viewer.
    """
    assert facts.through is not None
    cells = facts.through.exits
    stronger, agreeing = _stronger_group(images, cells), _agreeing_group(images, cells)
    colour = map_group("Through Colour", images[THROUGH_COLOUR])
    rest = buckets_group("Through", images[THROUGH_REST], facts.through.rest, facts.coarse)
    build, (uv, offset, normal, tangent, sign, viewer) = open_group(
        "RadTex Through",
        UV="Vector",
        Offset="Vector",
        Normal="Vector",
        Tangent="Vector",
        Sign="Float",
        Viewer="Vector",
    )
    frame = _frame(build, normal, tangent, sign)
    square = _square(build, viewer, frame)
    position = position_of(build, square, (cells, cells))
    inside = clamp(build, position, pair(cells - 1, cells - 1))
    corner = build.vector("MINIMUM", build.vector("FLOOR", inside), pair(cells - 2, cells - 2))
    share = build.vector("SUBTRACT", inside, corner)
    chief: Socket = build.combine(0.0, 0.0, 0.0)
    known: tuple[Socket, ...] = ()
    for texel, cell, weight in _sixteen(build, uv, facts.coarse, corner, share):
        x, y, _ = build.separate(texel)
        ordered = build.combine(after(build, x, known), y) if known else texel
        (chief,) = known = build.group(stronger, chief, ordered, cell, weight)
    sums: tuple[Operand, ...] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    for texel, cell, weight in _sixteen(build, uv, facts.coarse, corner, share):
        x, y, _ = build.separate(texel)
        ordered = build.combine(after(build, x, known), y)
        sums = known = build.group(agreeing, chief, *sums, ordered, cell, weight)
    away, moved, kept, spread, total = sums
    sums = (away, moved, kept, spread, total)
    light = _looked_up(build, around, offset, frame, sums, facts)  # type: ignore[arg-type]
    light = build.vector("MULTIPLY", light, build.group(colour, uv)[0])
    (place,) = build.group(octahedron, build.vector("SCALE", viewer, -1.0))
    return close_group(build, Light=build.vector("ADD", light, build.group(rest, uv, place)[0]))


def _frame(
    build: NodeBuilder, normal: Socket, tangent: Socket, sign: Socket
) -> tuple[Socket, Socket, Socket]:
    """Tangent, bitangent and normal, orthonormal: `core.frame.orthonormal_frame`."""
    along = build.vector("SCALE", normal, build.vector("DOT_PRODUCT", normal, tangent))
    unit = build.vector("NORMALIZE", build.vector("SUBTRACT", tangent, along))
    bitangent = build.vector("SCALE", build.vector("CROSS_PRODUCT", normal, unit), sign)
    return unit, bitangent, normal


def _square(build: NodeBuilder, viewer: Socket, frame: tuple[Socket, Socket, Socket]) -> Socket:
    """The viewer's place in a bucket, [0, 1]²: `core.hemisphere.direction_to_square`."""
    x, y, z = (build.vector("DOT_PRODUCT", viewer, axis) for axis in frame)
    local = build.vector("NORMALIZE", build.combine(x, y, build.math("MAXIMUM", z, 0.0)))
    (square,) = build.group(bucket_group(), local)
    return build.vector("MULTIPLY_ADD", square, pair(0.5, 0.5), pair(0.5, 0.5))


def _sixteen(
    build: NodeBuilder, uv: Socket, size: tuple[int, int], corner: Socket, share: Socket
) -> Iterator[tuple[Socket, Socket, Socket]]:
    """Texels, cells and weights of the four texels at UV and the four cells at `corner`."""
    last = pair(size[0] - 1, size[1] - 1)
    position = position_of(build, uv, size)
    low, between = build.vector("FLOOR", position), build.vector("FRACTION", position)
    texels = _corners(build, between)
    cells = _corners(build, share)
    for step, part in texels:
        texel = clamp(build, build.vector("ADD", low, step), last)
        for cell_step, cell_part in cells:
            yield texel, build.vector("ADD", corner, cell_step), build.math("MULTIPLY", part, cell_part)


def _corners(build: NodeBuilder, share: Socket) -> list[tuple[tuple[float, float, float], Socket]]:
    """The four corners of a unit square, and their weights at a place in it."""
    x, y, _ = build.separate(share)
    less_x, less_y = build.math("SUBTRACT", 1.0, x), build.math("SUBTRACT", 1.0, y)
    return [
        (pair(i, j), build.math("MULTIPLY", (less_x, x)[i], (less_y, y)[j]))
        for j in range(2)
        for i in range(2)
    ]


def _tap(
    build: NodeBuilder, image: bpy.types.Image, texel: Socket, cell: Socket, cells: int
) -> tuple[Socket, Socket]:
    """One texel's value for one cell, of an image of tiles."""
    width, height = readable_size(image)
    pixel = build.vector("MULTIPLY_ADD", cell, pair(width // cells, height // cells), texel)
    return build.image(image, pixel_centre(build, pixel, (width, height)))


def _stronger_group(images: _Images, cells: int) -> bpy.types.ShaderNodeTree:
    """The stronger one of a ray and that of a texel's cell, times its weight."""
    build, (best, texel, cell, weight) = open_group(
        "RadTex Stronger", Best="Vector", Texel="Vector", Cell="Vector", Weight="Float"
    )
    color, _ = _tap(build, images[EXIT_DIRECTION], texel, cell, cells)
    other = build.vector("SCALE", color, weight)
    longer = build.math("GREATER_THAN", build.vector("LENGTH", other), build.vector("LENGTH", best))
    return close_group(build, Best=build.mix(longer, best, other))


def _agreeing_group(images: _Images, cells: int) -> bpy.types.ShaderNodeTree:
    """Add a texel's cell to what goes where the chief ray does, and its weight to the total."""
    build, inputs = open_group(
        "RadTex Agreeing",
        Chief="Vector",
        Away="Vector",
        Moved="Vector",
        Kept="Float",
        Spread="Float",
        Total="Float",
        Texel="Vector",
        Cell="Vector",
        Weight="Float",
    )
    chief, away, moved, kept, spread, total, texel, cell, weight = inputs
    direction, through = _tap(build, images[EXIT_DIRECTION], texel, cell, cells)
    place, variance = _tap(build, images[EXIT_PLACE], texel, cell, cells)
    cosine = build.vector(
        "DOT_PRODUCT", build.vector("NORMALIZE", direction), build.vector("NORMALIZE", chief)
    )
    agrees = build.math("DIVIDE", build.math("SUBTRACT", cosine, _APART), _ALIKE - _APART)
    agrees = build.math("MINIMUM", build.math("MAXIMUM", agrees, 0.0), 1.0)
    counted = build.math("MULTIPLY", agrees, weight)
    return close_group(
        build,
        Away=build.vector("ADD", away, build.vector("SCALE", direction, counted)),
        Moved=build.vector("ADD", moved, build.vector("SCALE", place, counted)),
        Kept=build.math("MULTIPLY_ADD", through, counted, kept),
        Spread=build.math("MULTIPLY_ADD", variance, counted, spread),
        Total=build.math("MULTIPLY_ADD", through, weight, total),
    )


def _looked_up(
    build: NodeBuilder,
    around: bpy.types.ShaderNodeTree,
    offset: Socket,
    frame: tuple[Socket, Socket, Socket],
    ways: tuple[Socket, Socket, Socket, Socket, Socket],
    facts: LayeredSidecar,
) -> Socket:
    """What the filtered ray shows of the surroundings, as bright as all rays: `ways.shown_of`."""
    away, moved, kept, spread, total = ways
    factor = build.math("DIVIDE", total, build.math("MAXIMUM", kept, 1e-9))
    length = build.math("MULTIPLY", build.vector("LENGTH", away), factor)
    weight = build.math("MAXIMUM", total, 1e-6)
    apart = build.math("SUBTRACT", 1.0, build.math("DIVIDE", length, weight))
    apart = build.math("MAXIMUM", build.math("SUBTRACT", apart, _EVEN), 0.0)
    wide = build.math("DIVIDE", build.math("MULTIPLY", spread, factor), weight)
    variance = build.math("MAXIMUM", build.math("ADD", wide, apart), 0.0)
    direction = _in_world(build, build.vector("NORMALIZE", away), frame)
    shift = build.vector("SCALE", moved, build.math("DIVIDE", factor, weight))
    start = build.vector("ADD", offset, _in_world(build, shift, frame))
    whole = [1.0 for _ in shaded_lamps(facts)]  # whatever light falls on the surface
    (light,) = build.group(around, start, direction, variance, *whole)
    return build.vector("SCALE", light, total)


def _in_world(build: NodeBuilder, local: Socket, frame: tuple[Socket, Socket, Socket]) -> Socket:
    parts = [
        build.vector("SCALE", axis, part) for axis, part in zip(frame, build.separate(local), strict=True)
    ]
    return build.vector("ADD", build.vector("ADD", parts[0], parts[1]), parts[2])
