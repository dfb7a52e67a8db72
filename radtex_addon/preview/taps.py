# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of lookups with shader nodes: bilinear taps, each a group that reads one pixel; the octahedron."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import cast

import bpy

from ..core.errors import FormatError
from ..formats.containers.exr import stored_size
from ..scene.nodes import NodeBuilder, Operand, Socket, close_group, open_group
from ..scene.working_space import rec709_primaries

_TINY = 1e-30  # avoids 0/0, as in core.octahedron
_TRIFLE = 1e-30


def bilinear(
    build: NodeBuilder,
    tap: bpy.types.ShaderNodeTree,
    position: Socket,
    *rest: Socket,
    last: tuple[float, ...] | None = None,
    in_turn: bool = False,
) -> tuple[Socket, ...]:
    """Blend all outputs of the group `tap` at the four whole-numbered places around `position`.

    The place is the group's first input, `rest` are the others. Places are clamped to [0, last]; without
    `last` they are not, for images that have a border. With `in_turn` each tap is evaluated `after` the
    previous one.
    """
    corner = build.vector("FLOOR", position)
    fx, fy, _ = build.separate(build.vector("FRACTION", position))
    opposite = build.vector("ADD", corner, pair(1, 1))
    if last is not None:
        corner, opposite = clamp(build, corner, last), clamp(build, opposite, last)
    x0, y0, _ = build.separate(corner)
    x1, y1, _ = build.separate(opposite)
    rows: list[tuple[Socket, ...]] = []
    taken: tuple[Socket, ...] = ()
    for y in (y0, y1):
        row = []
        for x in (x0, x1):
            place = build.combine(after(build, x, taken) if in_turn and taken else x, y)
            taken = build.group(tap, place, *rest)
            row.append(taken)
        rows.append(_blend(build, fx, *row))
    return _blend(build, fy, *rows)


def after(build: NodeBuilder, number: Socket, known: Iterable[Socket]) -> Socket:
    """The whole number `number`, evaluated only after all the sockets in `known`.

    Cycles's stack holds 255 values. Left alone, Cycles computes the places of all lookups first, or makes all
    lookups in one image first, and the stack overflows. So 1e-30 of each known value is added, which rounding
    removes again, but which forces the order.
    """
    for socket in known:
        grey = socket if socket.type == "VALUE" else build.node("ShaderNodeRGBToBW", socket).outputs[0]
        number = build.math("MULTIPLY_ADD", grey, _TRIFLE, number, label="then")
    return number


def clamp(build: NodeBuilder, place: Operand, last: tuple[float, ...], label: str = "") -> Socket:
    """`place` clamped to [0, last] by component."""
    return build.vector("MINIMUM", build.vector("MAXIMUM", place, (0.0, 0.0, 0.0)), last, label=label)


def pair(x: float, y: float) -> tuple[float, float, float]:
    """Two numbers as the vector that a node takes."""
    return float(x), float(y), 0.0


def pixel_centre(build: NodeBuilder, pixel: Operand, size: tuple[int, int]) -> Socket:
    """The UV of a pixel's centre, in an image of that width and height."""
    width, height = size
    return build.vector("MULTIPLY_ADD", pixel, pair(1 / width, 1 / height), pair(0.5 / width, 0.5 / height))


def image_size(image: bpy.types.Image) -> tuple[int, int]:
    """An image's width and height, 0 if there is no image.

    Only the header of an EXR is read: Blender itself would read all its pixels, 16 bytes each, and keep them.
    """
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    if path.suffix == ".exr" and not image.packed_file and not image.has_data:
        try:
            return stored_size(path)
        except FormatError:
            return 0, 0
    width, height = cast(Sequence[int], image.size)
    return width, height


def readable_size(image: bpy.types.Image) -> tuple[int, int]:
    """An image's width and height. Raises FormatError if there is no image, or no longer."""
    size = image_size(image)
    if 0 in size:
        raise FormatError(f"{image.filepath}: Blender reads no image in it; bake it again")
    return size


def _blend(
    build: NodeBuilder, factor: Socket, low: tuple[Socket, ...], high: tuple[Socket, ...]
) -> tuple[Socket, ...]:
    """Interpolate linearly between each output in `low` and the same output in `high`."""

    def between(at_zero: Socket, at_one: Socket) -> Socket:
        if at_zero.type == "VALUE":
            return build.math("MULTIPLY_ADD", factor, build.math("SUBTRACT", at_one, at_zero), at_zero)
        return build.mix(factor, at_zero, at_one, at_zero.type)

    return tuple(between(*both) for both in zip(low, high, strict=True))


def octahedron_group() -> bpy.types.ShaderNodeTree:
    """Direction, of any length, to Place in [0, 1]^2, as `core.octahedron.direction_to_octahedron`."""
    build, (direction,) = open_group("RadTex Octahedron", Direction="Vector")
    length = build.vector("DOT_PRODUCT", build.vector("ABSOLUTE", direction), (1.0, 1.0, 1.0))
    scale = build.math("DIVIDE", 1.0, build.math("MAXIMUM", length, _TINY))
    flat = build.vector("SCALE", direction, scale, label="|x| + |y| + |z| = 1")
    x, y, z = build.separate(flat)
    swapped = build.combine(y, x)
    inside = build.vector("SUBTRACT", (1.0, 1.0, 0.0), build.vector("ABSOLUTE", swapped))
    side = build.vector("SIGN", build.vector("ADD", flat, pair(_TINY, _TINY)), label="zero is positive")
    folded = build.vector("MULTIPLY", inside, side, label="the lower half, folded outwards")
    square = build.mix(build.math("LESS_THAN", z, 0.0), flat, folded)
    return close_group(build, Place=build.vector("MULTIPLY_ADD", square, pair(0.5, 0.5), pair(0.5, 0.5)))


def in_working_space(build: NodeBuilder, colour: Socket) -> Socket:
    """Convert a Rec.709 colour to the file's working space.

    Rec.709's primaries are stored as colours, so that Blender converts them if the file's working space is
    changed, or if the nodes are appended to a file with another one.
    """
    shown: Socket | tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    for share, primary in zip(build.separate(colour), rec709_primaries(), strict=True):
        shown = build.mix(share, shown, (*primary, 1.0), "RGBA", "ADD")
    assert isinstance(shown, bpy.types.NodeSocket)  # there are three primaries
    return shown
