# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that comes through, by shader nodes: `lookup.ways.look_through`.

Sixteen rays, of four texels and four cells, are looked up twice: first to find the strongest, then to add up
those that go where it does.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import bpy

from ....preview.node_group import bucket_group, incidence_group
from ....preview.taps import after, clamp, pair, pixel_centre, readable_size
from ....scene.nodes import NodeBuilder, Operand, Socket, close_group, open_group
from ..files.arrangement import EXIT_DIRECTION, EXIT_PLACE, THROUGH_COLOUR, THROUGH_REST
from ..files.sidecar import LayeredSidecar
from .images import buckets_group, map_group, position_of

_APART, _ALIKE, _EVEN = 0.8, 0.95, 0.03  # as in lookup.ways

_CORNERS = tuple((float(x), float(y), 0.0) for y in range(2) for x in range(2))
_SIXTEEN = tuple((texel, cell) for texel in _CORNERS for cell in _CORNERS)

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
    tap = _tap_group(facts.coarse, cells)
    chief: Socket = build.combine(0.0, 0.0, 0.0)
    known: tuple[Socket, ...] = ()
    for step, cell_step in _SIXTEEN:
        there = _later(build, uv, known) if known else uv
        (chief,) = known = build.group(stronger, chief, *build.group(tap, there, square, step, cell_step))
    sums: tuple[Operand, ...] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    for step, cell_step in _SIXTEEN:
        found = build.group(tap, _later(build, uv, known), square, step, cell_step)
        sums = known = build.group(agreeing, chief, *sums, *found)
    away, moved, kept, spread, total = sums
    light = _looked_up(build, around, offset, frame, (away, moved, kept, spread, total))  # type: ignore[arg-type]
    light = build.vector("MULTIPLY", light, build.group(colour, uv)[0])
    (place,) = build.group(octahedron, build.vector("SCALE", viewer, -1.0))
    (left, _) = build.group(rest, _later(build, uv, (light,)), _later(build, place, (light,)))
    return close_group(build, Light=build.vector("ADD", light, left))


def _frame(
    build: NodeBuilder, normal: Socket, tangent: Socket, sign: Socket
) -> tuple[Socket, Socket, Socket]:
    """Tangent, bitangent and normal in world space: the columns of what `incidence_group` multiplies by."""
    group = incidence_group()
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    parts = [build.separate(build.group(group, normal, tangent, sign, axis)[0]) for axis in axes]
    along, across, up = (build.combine(*(part[index] for part in parts)) for index in range(3))
    return along, across, up


def _square(build: NodeBuilder, viewer: Socket, frame: tuple[Socket, Socket, Socket]) -> Socket:
    """The viewer's place in a bucket, [0, 1]²: `core.hemisphere.direction_to_square`."""
    x, y, z = (build.vector("DOT_PRODUCT", viewer, axis) for axis in frame)
    local = build.vector("NORMALIZE", build.combine(x, y, build.math("MAXIMUM", z, 0.0)))
    (square,) = build.group(bucket_group(), local)
    return build.vector("MULTIPLY_ADD", square, pair(0.5, 0.5), pair(0.5, 0.5))


def _tap_group(size: tuple[int, int], cells: int) -> bpy.types.ShaderNodeTree:
    """One of the four texels around UV, and of the four cells around a place: Texel, Cell and Weight.

    `Step` and `Cell Step` are 0 or 1 along both axes.
    """
    build, (uv, square, step, cell_step) = open_group(
        "RadTex Tap", UV="Vector", Place="Vector", Step="Vector", CellStep="Vector"
    )
    position = position_of(build, uv, size)
    low, between = build.vector("FLOOR", position), build.vector("FRACTION", position)
    texel = clamp(build, build.vector("ADD", low, step), pair(size[0] - 1, size[1] - 1))
    inside = clamp(build, position_of(build, square, (cells, cells)), pair(cells - 1, cells - 1))
    corner = build.vector("MINIMUM", build.vector("FLOOR", inside), pair(cells - 2, cells - 2))
    share = build.vector("SUBTRACT", inside, corner)
    parts = [*_shares(build, between, step), *_shares(build, share, cell_step)]
    weight = build.math("MULTIPLY", parts[0], parts[1])
    for part in parts[2:]:
        weight = build.math("MULTIPLY", weight, part)
    return close_group(build, Texel=texel, Cell=build.vector("ADD", corner, cell_step), Weight=weight)


def _shares(build: NodeBuilder, place: Socket, step: Socket) -> tuple[Socket, Socket]:
    """What a corner of the unit square counts for along both axes, at a place in it."""
    apart = build.vector("SUBTRACT", build.vector("SUBTRACT", (1.0, 1.0, 0.0), step), place)
    x, y, _ = build.separate(build.vector("ABSOLUTE", apart))
    return x, y


def _later(build: NodeBuilder, uv: Socket, known: Iterable[Socket]) -> Socket:
    """The same coordinates, evaluated only after all the sockets in `known`: see `taps.after`."""
    u, v, _ = build.separate(uv)
    return build.combine(after(build, u, known), v)


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
    (light,) = build.group(around, start, direction, variance)
    return build.vector("SCALE", light, total)


def _in_world(build: NodeBuilder, local: Socket, frame: tuple[Socket, Socket, Socket]) -> Socket:
    parts = [
        build.vector("SCALE", axis, part) for axis, part in zip(frame, build.separate(local), strict=True)
    ]
    return build.vector("ADD", build.vector("ADD", parts[0], parts[1]), parts[2])
