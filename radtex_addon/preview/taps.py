# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bilinear lookups by nodes: four taps, each a group that reads one pixel, blended.

Images are read by `Closest` and blended here: Blender's `Linear` would mip, and bleed, across buckets.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import cast

import bpy

from ..core.errors import FormatError
from ..formats.containers.exr import stored_size
from ..scene.nodes import NodeBuilder, Operand, Socket

_TRIFLE = 1e-30


def bilinear(
    build: NodeBuilder,
    tap: bpy.types.ShaderNodeTree,
    position: Socket,
    *rest: Socket,
    last: tuple[float, ...] | None = None,
    in_turn: bool = False,
) -> tuple[Socket, ...]:
    """Blend all outputs of `tap` at the four whole places around `position`, each clamped to [0, last].

    The place is the group's first input, `rest` are the others. Without `last` nothing is clamped: there is a
    border to be read. `in_turn` each tap comes `after` the one before.
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
    """`number`, a whole one, but not before all numbers and colours are `known`.

    Cycles has room for 255 numbers that wait to be used. Left alone it first finds out where all lookups are,
    or looks up one image everywhere. A trifle of what is known, which rounding swallows, puts them in turn.
    """
    for socket in known:
        grey = socket if socket.type == "VALUE" else build.node("ShaderNodeRGBToBW", socket).outputs[0]
        number = build.math("MULTIPLY_ADD", grey, _TRIFLE, number, label="then")
    return number


def clamp(build: NodeBuilder, place: Operand, last: tuple[float, ...], label: str = "") -> Socket:
    """`place` brought into [0, last], component by component."""
    return build.vector("MINIMUM", build.vector("MAXIMUM", place, (0.0, 0.0, 0.0)), last, label=label)


def pair(x: float, y: float) -> tuple[float, float, float]:
    """Two numbers as the vector that a node takes."""
    return float(x), float(y), 0.0


def pixel_centre(build: NodeBuilder, pixel: Operand, size: tuple[int, int]) -> Socket:
    """Where an image node finds a pixel's centre, in an image of that width and height."""
    width, height = size
    return build.vector("MULTIPLY_ADD", pixel, pair(1 / width, 1 / height), pair(0.5 / width, 0.5 / height))


def image_size(image: bpy.types.Image) -> tuple[int, int]:
    """An image's width and height, 0 where there is no image; of an EXR by its header alone.

    To tell them Blender reads all pixels, as 16 bytes each, and keeps them.
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
    """An image's width and height. Raises FormatError where there is no image, or no longer."""
    size = image_size(image)
    if 0 in size:
        raise FormatError(f"{image.filepath}: Blender reads no image in it; bake it again")
    return size


def _blend(
    build: NodeBuilder, factor: Socket, low: tuple[Socket, ...], high: tuple[Socket, ...]
) -> tuple[Socket, ...]:
    """Each of `low` and the one like it in `high`, linearly."""

    def between(at_zero: Socket, at_one: Socket) -> Socket:
        if at_zero.type == "VALUE":
            return build.math("MULTIPLY_ADD", factor, build.math("SUBTRACT", at_one, at_zero), at_zero)
        return build.mix(factor, at_zero, at_one, at_zero.type)

    return tuple(between(*both) for both in zip(low, high, strict=True))
