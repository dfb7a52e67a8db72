# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lobes see of lamps, by shader nodes: `lookup.environment.Lamp.light`, as a blur and as a shape."""

from __future__ import annotations

from math import pi

import bpy
import numpy as np

from ....scene.nodes import NodeBuilder, Socket, close_group, open_group
from ..lookup.environment import Lamp
from ..lookup.lamp_shapes import FAR, LARGEST, MOST_SHARP, SHARP, TINY, LampShape, ShapeKind
from .images import constant


def lamp_group() -> bpy.types.ShaderNodeTree:
    """`Lamp.light`: Place and Irradiance as in `Lamp`, Variance, and the place's squared Distance."""
    build, (offset, axis, spread, place, irradiance, variance, distance) = open_group(
        "RadTex Lamp",
        Offset="Vector",
        Axis="Vector",
        Spread="Float",
        Place="Vector",
        Irradiance="Vector",
        Variance="Float",
        Distance="Float",
    )
    towards = build.vector("SUBTRACT", place, offset)
    length = build.vector("LENGTH", towards)
    cosine = build.math("DIVIDE", build.vector("DOT_PRODUCT", axis, towards), length)
    squared = build.math("MULTIPLY", build.math("SUBTRACT", 1.0, cosine), 2.0)
    nearer = build.math("DIVIDE", distance, build.math("MULTIPLY", length, length))
    wide = build.math("MULTIPLY_ADD", variance, nearer, spread)
    tail = build.math("ADD", 1.0, build.math("DIVIDE", squared, build.math("MULTIPLY", wide, 2.0)))
    shape = build.math(
        "DIVIDE", build.math("MULTIPLY_ADD", wide, 0.5, 1.0), build.math("MULTIPLY", wide, 2 * pi)
    )
    shown = build.math("DIVIDE", shape, build.math("MULTIPLY", tail, tail))
    return close_group(build, Light=build.vector("SCALE", irradiance, build.math("MULTIPLY", nearer, shown)))


def lamp_facts(lamp: Lamp) -> tuple[tuple[float, ...] | float, ...]:
    """The inputs of `lamp_group` that are the lamp's."""
    return (
        constant(lamp.place),
        constant(lamp.irradiance),
        float(lamp.variance),
        float(lamp.place @ lamp.place),
    )


def shape_group(lamp: Lamp, shape: LampShape) -> bpy.types.ShaderNodeTree:
    """What a lobe sees of a lamp with a shape, by what it sees of the Blur: the rest of `Lamp.light`."""
    build, (offset, axis, spread, blur) = open_group(
        "RadTex Lamp Shape", Offset="Vector", Axis="Vector", Spread="Float", Blur="Vector"
    )
    towards = build.vector("SUBTRACT", constant(lamp.place), offset)
    squared = build.vector("DOT_PRODUCT", towards, towards)
    most = build.math("DIVIDE", SHARP * float(lamp.variance * (lamp.place @ lamp.place)), squared)
    most = build.math("MINIMUM", most, MOST_SHARP)
    share = build.math("SUBTRACT", 2.0, build.math("DIVIDE", spread, most))
    share = build.math("MINIMUM", build.math("MAXIMUM", share, 0.0), 1.0)
    if shape.kind == ShapeKind.BALL:
        covered = _ball_covered(build, shape, towards, squared, axis, spread)
    else:
        covered = _flat_covered(build, shape, towards, axis, spread)
    sharp = build.vector("SCALE", constant(lamp.irradiance / shape.solid), covered)
    light = build.vector("ADD", blur, build.vector("SCALE", build.vector("SUBTRACT", sharp, blur), share))
    if shape.kind != ShapeKind.BALL:
        back = constant(np.cross(shape.across, shape.up))
        faces = build.math("GREATER_THAN", build.vector("DOT_PRODUCT", towards, back), 0.0)
        light = build.vector("SCALE", light, faces)
    return close_group(build, Light=light)


def _ball_covered(
    build: NodeBuilder, shape: LampShape, towards: Socket, squared: Socket, axis: Socket, spread: Socket
) -> Socket:
    """`LampShape.covered` of a ball."""
    along = build.vector("DOT_PRODUCT", towards, axis)
    ahead = build.math("DIVIDE", 1.0, build.math("MAXIMUM", along, TINY))
    aside = build.vector("SUBTRACT", build.vector("SCALE", towards, ahead), axis)
    radius = float(shape.across @ shape.across)
    size = build.math("DIVIDE", radius, build.math("MAXIMUM", build.math("SUBTRACT", squared, radius), TINY))
    sharp = build.math("DIVIDE", 0.5, spread)
    apart = build.math("MINIMUM", build.vector("DOT_PRODUCT", aside, aside), FAR * FAR)
    away, size = build.math("MULTIPLY", apart, sharp), build.math("MINIMUM", size, FAR)
    found = _on_disc(build, away, build.math("MULTIPLY", size, sharp))
    return build.math("MULTIPLY", found, build.math("GREATER_THAN", along, 0.0))


def _flat_covered(
    build: NodeBuilder, shape: LampShape, towards: Socket, axis: Socket, spread: Socket
) -> Socket:
    """`LampShape.covered` of a rectangle or a disc."""
    across, up = constant(shape.across), constant(shape.up)
    back = constant(np.cross(shape.across, shape.up))
    facing = build.vector("DOT_PRODUCT", axis, back)
    reach = build.math("MAXIMUM", build.vector("DOT_PRODUCT", towards, back), 0.0)
    reach = build.math("DIVIDE", reach, build.math("MAXIMUM", facing, TINY))
    met = build.vector("SUBTRACT", build.vector("SCALE", axis, reach), towards)
    sharp = build.math("DIVIDE", 1.0, build.math("SQRT", build.math("MULTIPLY", spread, 2.0)))
    near = build.math("DIVIDE", facing, build.math("MAXIMUM", reach, TINY))
    near = build.math("MULTIPLY", near, sharp)

    def half(line: tuple[float, float, float]) -> Socket:
        """Of the side across a line, in the lobe's units."""
        shifted = build.vector("SCALE", axis, build.vector("DOT_PRODUCT", axis, line))
        seen = build.vector("SUBTRACT", line, shifted)
        length = build.math("SQRT", build.math("MAXIMUM", build.vector("DOT_PRODUCT", seen, seen), TINY))
        return build.math("MINIMUM", build.math("DIVIDE", near, length), LARGEST)

    def along(line: tuple[float, float, float]) -> Socket:
        """Where the axis meets the lamp's plane, in units of a line."""
        square = sum(each * each for each in line)
        place = build.math("DIVIDE", build.vector("DOT_PRODUCT", met, line), square)
        return build.math("MAXIMUM", build.math("MINIMUM", place, FAR), -FAR)

    x, y = along(across), along(up)
    wide, high = half(up), half(across)
    if shape.kind == ShapeKind.DISC:
        found = _on_disc(build, *_as_circle(build, x, y, wide, high))
    else:
        right, top = (
            build.math("MULTIPLY", build.math("SUBTRACT", 1.0, place), size)
            for place, size in ((x, wide), (y, high))
        )
        left, low = (
            build.math("MULTIPLY_ADD", size, -2.0, end) for end, size in ((right, wide), (top, high))
        )
        above = build.math("SUBTRACT", _corner(build, right, top), _corner(build, left, top))
        below = build.math("SUBTRACT", _corner(build, right, low), _corner(build, left, low))
        found = build.math("DIVIDE", build.math("SUBTRACT", above, below), 2 * pi)
    return build.math("MULTIPLY", found, build.math("GREATER_THAN", facing, 0.0))


def _as_circle(build: NodeBuilder, x: Socket, y: Socket, wide: Socket, high: Socket) -> tuple[Socket, Socket]:
    """The squared distance and radius of a circle for an ellipse: see lamp_shapes.py."""

    def square(one: Socket, more: float = 0.0) -> Socket:
        return build.math("MULTIPLY_ADD", one, one, more)

    area = build.math("MULTIPLY", wide, high)
    both = build.math("SQRT", build.math("MULTIPLY", square(wide, 1.0), square(high, 1.0)))
    over = build.math("ADD", square(wide, 1.0), square(high))
    radius = build.math("DIVIDE", build.math("MULTIPLY", area, build.math("ADD", both, area)), over)
    inside = build.math("ADD", square(x), square(y))
    aside = build.math(
        "ADD", square(build.math("MULTIPLY", x, wide)), square(build.math("MULTIPLY", y, high))
    )
    left = build.math("SUBTRACT", 1.0, build.math("DIVIDE", 1.0, build.math("MAXIMUM", inside, 1.0)))
    within = build.math("MULTIPLY", radius, build.math("MINIMUM", inside, 1.0))
    return build.math("MULTIPLY_ADD", aside, left, within), radius


def _on_disc(build: NodeBuilder, away: Socket, radius: Socket) -> Socket:
    """How much of a lobe lies on a disc: see lamp_shapes.py."""
    apart = build.math("SUBTRACT", away, radius)
    under = build.math("MULTIPLY_ADD", build.math("ADD", away, radius), 2.0, 1.0)
    under = build.math("SQRT", build.math("MULTIPLY_ADD", apart, apart, under))
    return build.math("MULTIPLY_ADD", build.math("DIVIDE", build.math("ADD", apart, 1.0), under), -0.5, 0.5)


def _corner(build: NodeBuilder, x: Socket, y: Socket) -> Socket:
    """2 pi times how much of it lies between its axis and a corner."""

    def part(one: Socket, other: Socket) -> Socket:
        length = build.math("SQRT", build.math("MULTIPLY_ADD", one, one, 1.0))
        angle = build.math("ARCTANGENT", build.math("DIVIDE", other, length))
        return build.math("MULTIPLY", build.math("DIVIDE", one, length), angle)

    return build.math("ADD", part(x, y), part(y, x))
