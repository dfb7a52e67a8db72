# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lobes see of lamps, by shader nodes: `lookup.environment.Lamp.light`, as a blur and as a shape."""

from __future__ import annotations

from math import pi

import bpy
import numpy as np

from ....core.arrays import Floats
from ....scene.nodes import NodeBuilder, Socket, close_group, open_group
from ..lookup.environment import Lamp
from ..lookup.lamp_shapes import (
    ANGLE,
    BRIGHTEST,
    FAR,
    MOST_SHARP,
    SHARP,
    SHARPEST,
    TINY,
    LampShape,
    ShapeKind,
)
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
    if shape.kind == ShapeKind.BALL:
        covered = _ball_covered(build, shape, towards, squared, axis, spread)
    else:
        blur = build.vector("SCALE", blur, _facing(build, lamp, shape, towards, squared))
        covered = _flat_covered(build, shape, towards, axis, spread)
    most = build.math("DIVIDE", SHARP * float(lamp.variance * (lamp.place @ lamp.place)), squared)
    most = build.math("MINIMUM", most, MOST_SHARP)
    share = build.math("SUBTRACT", 2.0, build.math("DIVIDE", spread, most))
    share = build.math("MINIMUM", build.math("MAXIMUM", share, 0.0), 1.0)
    sharp = build.vector("SCALE", constant(lamp.irradiance / shape.solid), covered)
    light = build.vector("ADD", blur, build.vector("SCALE", build.vector("SUBTRACT", sharp, blur), share))
    return close_group(build, Light=light)


def brushed_lamp_group(lamp: Lamp) -> bpy.types.ShaderNodeTree:
    """What brushed metal sees of a lamp, or what lobes have Shown of it where Along is 0: Light.

    The other inputs are as in `lookup.lobes.Brushed`, whose `towards` this is.
    """
    build, (offset, viewer, upright, tangent, along, across, shown) = open_group(
        "RadTex Brushed Lamp",
        Offset="Vector",
        Viewer="Vector",
        Upright="Vector",
        Tangent="Vector",
        Along="Float",
        Across="Float",
        Shown="Vector",
    )
    towards = build.vector("SUBTRACT", constant(lamp.place), offset)
    squared = build.vector("DOT_PRODUCT", towards, towards)
    nearer = build.math("DIVIDE", float(lamp.place @ lamp.place), squared)
    size = build.math("MULTIPLY", nearer, float(lamp.variance))
    way = build.vector("NORMALIZE", towards)
    seen = _towards(build, viewer, upright, tangent, way, along, across, size)
    light = build.vector("SCALE", constant(lamp.irradiance), build.math("MULTIPLY", nearer, seen))
    if lamp.shape is not None and lamp.shape.kind != ShapeKind.BALL:
        light = build.vector("SCALE", light, _facing(build, lamp, lamp.shape, towards, squared))
    brushed = build.math("GREATER_THAN", along, 0.0)
    return close_group(build, Light=build.mix(brushed, shown, light))


def _towards(
    build: NodeBuilder,
    viewer: Socket,
    upright: Socket,
    tangent: Socket,
    way: Socket,
    along: Socket,
    across: Socket,
    size: Socket,
) -> Socket:
    """`Brushed.towards`."""
    half = build.vector("NORMALIZE", build.vector("ADD", viewer, way))
    height = build.math("MAXIMUM", build.vector("DOT_PRODUCT", half, upright), 1e-3)
    aside = build.math("DIVIDE", build.vector("DOT_PRODUCT", half, tangent), height)
    aside, height = build.math("MULTIPLY", aside, aside), build.math("MULTIPLY", height, height)
    flat = build.math("SUBTRACT", build.math("DIVIDE", 1.0, height), build.math("ADD", aside, 1.0))
    flat = build.math("MAXIMUM", flat, 0.0)
    long, short = (build.math("MULTIPLY", build.math("ADD", one, size), 0.5) for one in (along, across))
    tail = build.math("ADD", build.math("DIVIDE", aside, long), build.math("DIVIDE", flat, short))
    tail = build.math("MULTIPLY", build.math("ADD", tail, 1.0), height)
    root = build.math("SQRT", build.math("MULTIPLY", long, short))
    below = build.math("MULTIPLY", root, build.math("MULTIPLY", tail, tail))
    cosine = build.math("MAXIMUM", build.vector("DOT_PRODUCT", viewer, upright), 1e-3)
    slant = build.vector("DOT_PRODUCT", viewer, tangent)
    slant, squared = build.math("MULTIPLY", slant, slant), build.math("MULTIPLY", cosine, cosine)
    left = build.math("SUBTRACT", 1.0, build.math("ADD", squared, slant))
    rough = build.math("MULTIPLY", across, build.math("MAXIMUM", left, 0.0))
    rough = build.math("MULTIPLY_ADD", along, slant, rough)
    root = build.math("SQRT", build.math("MULTIPLY_ADD", rough, 0.5, squared))
    hidden = build.math("MULTIPLY", build.math("ADD", cosine, root), 2 * pi)  # 4 pi N.V / G1 / 2
    shown = build.math("DIVIDE", build.math("DIVIDE", 1.0, below), hidden)
    above = build.math("GREATER_THAN", build.vector("DOT_PRODUCT", way, upright), 0.0)
    return build.math("MULTIPLY", shown, above)


def _facing(build: NodeBuilder, lamp: Lamp, shape: LampShape, towards: Socket, squared: Socket) -> Socket:
    """`LampShape.facing`."""
    back = np.cross(shape.across, shape.up)
    there = max(float(back @ lamp.place) / float(np.linalg.norm(lamp.place)), TINY)
    along = build.vector("DOT_PRODUCT", towards, constant(back / there))
    here = build.math("DIVIDE", along, build.math("MAXIMUM", build.math("SQRT", squared), TINY))
    return build.math("MINIMUM", build.math("MAXIMUM", here, 0.0), BRIGHTEST)


def _ball_covered(
    build: NodeBuilder, shape: LampShape, towards: Socket, squared: Socket, axis: Socket, spread: Socket
) -> Socket:
    """`LampShape.covered` of a ball."""
    along = build.vector("DOT_PRODUCT", towards, axis)
    ahead = build.math("DIVIDE", 1.0, build.math("MAXIMUM", along, TINY))
    aside = build.vector("SUBTRACT", build.vector("SCALE", towards, ahead), axis)
    radius = float(shape.across @ shape.across)
    size = build.math("DIVIDE", radius, build.math("MAXIMUM", build.math("SUBTRACT", squared, radius), TINY))
    sharp = build.math("DIVIDE", 0.5, build.math("MAXIMUM", spread, SHARPEST))
    away = build.math("MINIMUM", build.vector("DOT_PRODUCT", aside, aside), FAR * FAR)
    away, size = build.math("MULTIPLY", away, sharp), build.math("MINIMUM", size, FAR)
    size = build.math("MULTIPLY", size, sharp)
    apart = build.math("SUBTRACT", away, size)
    under = build.math("MULTIPLY_ADD", build.math("ADD", away, size), 2.0, 1.0)
    under = build.math("SQRT", build.math("MULTIPLY_ADD", apart, apart, under))
    found = build.math("DIVIDE", build.math("ADD", apart, 1.0), under)
    found = build.math("MULTIPLY_ADD", found, -0.5, 0.5)
    return build.math("MULTIPLY", found, build.math("GREATER_THAN", along, 0.0))


def _flat_covered(
    build: NodeBuilder, shape: LampShape, towards: Socket, axis: Socket, spread: Socket
) -> Socket:
    """`LampShape.covered` of a rectangle or a disc."""
    blunt = build.math("SQRT", build.math("MULTIPLY", spread, 2.0))
    blunt = build.math("SUBTRACT", blunt, 1.0)

    def seen(corner: Floats) -> Socket:
        way = build.vector("ADD", towards, constant(corner))
        along = build.math("MULTIPLY", build.vector("DOT_PRODUCT", way, axis), blunt)
        return build.vector("NORMALIZE", build.vector("ADD", way, build.vector("SCALE", axis, along)))

    corners = shape.corners()
    last = first = seen(corners[0])
    found: Socket | float = 0.0
    for corner in corners[1:]:
        one = seen(corner)
        found, last = build.math("ADD", _edge(build, last, one, axis), found), one
    found = build.math("DIVIDE", build.math("ADD", _edge(build, last, first, axis), found), 2 * pi)
    return build.math("MINIMUM", build.math("MAXIMUM", found, 0.0), 1.0)


def _edge(build: NodeBuilder, one: Socket, other: Socket, axis: Socket) -> Socket:
    """Of a polygon's edge, the angle times how much its normal lies along the axis."""
    cosine = build.vector("DOT_PRODUCT", one, other)
    near = build.math("ABSOLUTE", cosine)
    angle: Socket | float = ANGLE[-1]
    for power in ANGLE[-2::-1]:
        angle = build.math("MULTIPLY_ADD", near, angle, power)
    over = build.math("DIVIDE", angle, build.math("SQRT", build.math("ADD", near, 1.0)))
    sine = build.math("SUBTRACT", 1.0, build.math("MULTIPLY", cosine, cosine))
    whole = build.math("DIVIDE", pi, build.math("SQRT", build.math("MAXIMUM", sine, TINY)))
    # Where the angle is wide it is the whole one less this: 0 or 1 times the whole, and -1 or 1 times this.
    wide = build.math("LESS_THAN", cosine, 0.0)
    sign = build.math("MULTIPLY_ADD", wide, -2.0, 1.0)
    over = build.math("MULTIPLY_ADD", over, sign, build.math("MULTIPLY", whole, wide))
    along = build.vector("DOT_PRODUCT", build.vector("CROSS_PRODUCT", one, other), axis)
    return build.math("MULTIPLY", along, over)
