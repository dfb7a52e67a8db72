# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What surrounds the object, by shader nodes: `lookup.environment.Around.look`, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

import bpy

from ....core.colour_spaces import LUMINANCE
from ....preview.taps import bilinear, pair, pixel_centre, readable_size
from ....scene.nodes import NodeBuilder, Socket, close_group, open_group
from ..files.arrangement import DISTANCES, PLANE, THINGS, WORLD
from ..files.sidecar import LayeredSidecar, OctahedralPicture
from ..lookup.environment import (
    BEYOND,
    BRIGHTER,
    FARTHEST,
    KNOWN,
    LEAST_FACING,
    MOST_LAMPS,
    NEAR_LOBE,
    SHADED,
    SMALLEST,
    SOLID,
    STEPS,
    Lamp,
    Plane,
    Shell,
)
from .images import constant, ordered
from .lamps import brushed_lamp_group, lamp_facts, lamp_group, shape_group

_LEAST = 1e-12  # width²
_LEAST_RATIO, _MOST_RATIO = 1 / 16, 4.0  # as in lookup.environment
_PARALLEL, _STEEPEST = 1e-4, 0.999
_STILL = 1e-6  # of lengths that are alike

MOST_SHADED = MOST_LAMPS if bpy.app.version >= (5, 0) else 2  # lamps; the stack of 4.5's Cycles holds no more
_BRUSH = {"Viewer": "Vector", "Upright": "Vector", "Tangent": "Vector", "Along": "Float", "Across": "Float"}

_Images = Mapping[str, bpy.types.Image]


def around_group(
    images: _Images, facts: LayeredSidecar, octahedron: bpy.types.ShaderNodeTree
) -> bpy.types.ShaderNodeTree:
    """What a lobe sees from an Offset from the middle along a unit Axis with a Spread, its width².

    It has the inputs that `more_inputs` names, too.
    """
    world = picture_group("World", images[WORLD], facts.pictures[WORLD], octahedron)
    near = []
    if facts.plane is not None:
        picture = picture_group("Plane", images[PLANE], facts.pictures[PLANE], octahedron)
        shape = _shell_group(facts.plane) if isinstance(facts.plane, Shell) else _plane_group(facts.plane)
        near.append(_over_group("Plane", picture, shape))
    if THINGS in facts.pictures:
        picture = picture_group("Things", images[THINGS], facts.pictures[THINGS], octahedron)
        near.append(_over_group("Things", picture, _things_group(images[DISTANCES], octahedron, facts)))
    lamp = lamp_group() if facts.lamps else None
    shaded = shaded_lamps(facts)
    build, (offset, axis, spread, *more) = open_group(
        "RadTex Surroundings", Offset="Vector", Axis="Vector", Spread="Float", **more_inputs(facts)
    )
    most, brush = more[: len(shaded)], more[len(shaded) :]
    along, wide, opened = axis, spread, {}
    for one, seen in zip(shaded.values(), most, strict=True):  # first of all, while few values are kept
        opened[one] = _open(build, near, offset, wide, one, seen)
        _, along, wide = _all_late(build, offset, axis, spread, opened[one])
    light, _ = build.group(world, along, wide)
    for layer in near:
        there, along, wide = _all_late(build, offset, axis, spread, light)
        light, _ = build.group(layer, light, 1.0, there, along, wide)
    for one in facts.lamps if lamp is not None else ():
        there, along, wide = _all_late(build, offset, axis, spread, light)
        (shown,) = build.group(lamp, there, along, wide, *lamp_facts(one))  # type: ignore[arg-type]
        if one.shape is not None:
            there, along, wide = _all_late(build, offset, axis, spread, shown)
            (shown,) = build.group(shape_group(one, one.shape), there, along, wide, shown)
        if brush:
            (shown,) = build.group(brushed_lamp_group(one), _late(build, offset, shown), *brush, shown)
        light = build.vector(
            "ADD", light, build.vector("SCALE", shown, opened[one]) if one in opened else shown
        )
    return close_group(build, Light=light)


def more_inputs(facts: LayeredSidecar) -> dict[str, str]:
    """Types of more inputs of `around_group`, by name.

    For each of `shaded_lamps` how much of that lamp the surface sees at most; and where materials are
    brushed, how the place is, as `lookup.lobes.Brushed` has it.
    """
    return dict.fromkeys(shaded_lamps(facts), "Float") | (_BRUSH if brushes(facts) else {})


def brushes(facts: LayeredSidecar) -> bool:
    """Whether brushed metal is before lamps."""
    return facts.brushes and bool(facts.lamps)


def shaded_lamps(facts: LayeredSidecar) -> dict[str, Lamp]:
    """The lamps that layers are shown to hide, by the names of groups' inputs: the MOST_SHADED brightest."""
    behind = [number for number, lamp in enumerate(facts.lamps) if lamp.behind]
    behind.sort(key=lambda number: -float(LUMINANCE @ facts.lamps[number].irradiance))
    return {f"Lamp {number}": facts.lamps[number] for number in sorted(behind[:MOST_SHADED])}


def most_of(
    build: NodeBuilder, lamp: Lamp, offset: Socket, outward: Socket, irradiance: Socket, colour: Socket
) -> Socket:
    """`Lit.most` of a lamp, on a surface of that normal, irradiance over pi, and diffuse colour."""
    red, green, blue = build.separate(colour)
    brightest = build.math("MAXIMUM", red, build.math("MAXIMUM", green, blue))
    unknown = build.math("MAXIMUM", build.math("MULTIPLY_ADD", brightest, -KNOWN, 1.0), 0.0)
    luminance = build.vector("DOT_PRODUCT", irradiance, constant(LUMINANCE))
    light = build.math("MULTIPLY_ADD", luminance, pi, build.math("MULTIPLY", unknown, BRIGHTER))
    towards = build.vector("SUBTRACT", constant(lamp.place), offset)
    sent = float(LUMINANCE @ lamp.irradiance) * float(lamp.place @ lamp.place)
    nearer = build.math("DIVIDE", sent, build.vector("DOT_PRODUCT", towards, towards))
    facing = build.vector("DOT_PRODUCT", outward, build.vector("NORMALIZE", towards))
    falls = build.math("MULTIPLY", nearer, build.math("MAXIMUM", facing, LEAST_FACING))
    share = build.math("DIVIDE", light, build.math("MAXIMUM", falls, 1e-9))
    share = build.math("MULTIPLY_ADD", share, 1 / (1 - SHADED), -SHADED / (1 - SHADED))
    return build.math("MINIMUM", build.math("MAXIMUM", share, 0.0), 1.0)


def _open(
    build: NodeBuilder,
    near: list[bpy.types.ShaderNodeTree],
    offset: Socket,
    known: Socket,
    lamp: Lamp,
    most: Socket,
) -> Socket:
    """`Around._open`, evaluated after a number is known. The stack of Blender 4.5 holds the walls alone."""
    free = ordered(build, most, (known,))
    for layer in near if bpy.app.version >= (5, 0) else near[:1]:
        there = _late(build, offset, free)
        towards = build.vector("SUBTRACT", constant(lamp.place), there)
        squared = build.vector("DOT_PRODUCT", towards, towards)
        wide = build.math("DIVIDE", float(lamp.variance * (lamp.place @ lamp.place)), squared)
        _, free = build.group(layer, (0.0, 0.0, 0.0), free, there, build.vector("NORMALIZE", towards), wide)
    return free


def picture_group(
    name: str, image: bpy.types.Image, picture: OctahedralPicture, octahedron: bpy.types.ShaderNodeTree
) -> bpy.types.ShaderNodeTree:
    """Look up an octahedral picture around a Direction, blurred by a Spread: Color and Alpha.

    Two levels, with coordinates of a grid between theirs, are mixed by the width: see `EdgePictures.look`.
    """
    level_group = _level_group(name, image, picture)
    build, (direction, spread) = open_group(f"RadTex {name}", Direction="Vector", Spread="Float")
    least = build.math("MAXIMUM", spread, _LEAST)
    exact = build.math(
        "MULTIPLY", build.math("LOGARITHM", build.math("DIVIDE", least, picture.sharpest), 2.0), 0.5
    )
    last = picture.levels - 1.0
    level = build.math("MINIMUM", build.math("MAXIMUM", exact, 0.0), last, label="level")
    lower = build.math("MINIMUM", build.math("FLOOR", level), max(last - 1, 0.0))
    above = build.math("SUBTRACT", build.math("POWER", 2.0, build.math("SUBTRACT", level, lower)), 1.0)
    half = build.math("MULTIPLY", build.math("POWER", 2.0, level), 0.5 / picture.size)
    (place,) = build.group(octahedron, direction)
    inner = build.math("MULTIPLY_ADD", half, -2.0, 1.0)
    shifted = build.vector("MULTIPLY_ADD", place, build.combine(inner, inner), build.combine(half, half))
    sharp, sharp_alpha = build.group(level_group, shifted, lower)
    if picture.levels == 1:
        return close_group(build, Color=sharp, Alpha=sharp_alpha)
    next_level = ordered(build, build.math("ADD", lower, 1.0), (sharp, sharp_alpha))
    blurred, blurred_alpha = build.group(level_group, shifted, next_level)
    return close_group(
        build,
        Color=build.mix(above, sharp, blurred, "RGBA"),
        Alpha=build.mix(above, sharp_alpha, blurred_alpha, "FLOAT"),
    )


def _level_group(name: str, image: bpy.types.Image, picture: OctahedralPicture) -> bpy.types.ShaderNodeTree:
    """Look up one level, a whole number, at a place on the square, bilinear and clamped to the edge."""
    size = float(picture.size)
    tap, (cell, corner) = open_group(f"RadTex {name} Pixel", Cell="Vector", Corner="Vector")
    centre = pixel_centre(tap, tap.vector("ADD", cell, corner), readable_size(image))
    color, alpha = tap.image(image, centre)
    pixel = close_group(tap, Color=color, Alpha=alpha)
    build, (place, level) = open_group(f"RadTex {name} Level", Place="Vector", Level="Float")
    side = build.math("MULTIPLY", build.math("POWER", 2.0, build.math("MULTIPLY", level, -1.0)), size)
    side = build.math("ROUND", side, label="texels along the level's side")
    blurred = build.math("GREATER_THAN", level, 0.5)
    x = build.math("MULTIPLY", blurred, size)
    y = build.math("MULTIPLY", blurred, build.math("MULTIPLY_ADD", side, -2.0, size))
    cells = build.vector("MULTIPLY_ADD", place, build.combine(side, side), pair(-0.5, -0.5))
    last = build.math("SUBTRACT", side, 1.0)
    inside = build.vector(
        "MINIMUM", build.vector("MAXIMUM", cells, (0.0, 0.0, 0.0)), build.combine(last, last)
    )
    color, alpha = bilinear(build, pixel, inside, build.combine(x, y), in_turn=True)
    return close_group(build, Color=color, Alpha=alpha)


def _over_group(
    name: str, picture: bpy.types.ShaderNodeTree, shape: bpy.types.ShaderNodeTree
) -> bpy.types.ShaderNodeTree:
    """Light behind a layer with the layer before it, and how much is Free before and after: `Around.look`."""
    build, (light, free, offset, axis, spread) = open_group(
        f"RadTex {name} Layer", Light="Vector", Free="Float", Offset="Vector", Axis="Vector", Spread="Float"
    )
    met, wider, cover = build.group(shape, offset, axis, spread)
    color, alpha = build.group(picture, met, build.math("MULTIPLY", spread, wider))
    left = build.math("SUBTRACT", 1.0, build.math("MULTIPLY", cover, alpha))
    shown = build.vector("SCALE", color, cover)
    seen = build.vector("ADD", build.vector("SCALE", light, left), shown)
    return close_group(build, Light=seen, Free=build.math("MULTIPLY", free, left))


def _plane_group(plane: Plane) -> bpy.types.ShaderNodeTree:
    """`Plane.meet`."""
    normal, eye = constant(plane.normal), constant(plane.eye)
    build, (offset, axis, spread) = open_group(
        "RadTex Plane Shape", Offset="Vector", Axis="Vector", Spread="Float"
    )
    sine = build.vector("DOT_PRODUCT", axis, normal)
    squared = build.math("MULTIPLY_ADD", sine, sine, build.math("MULTIPLY", spread, 2.0))
    root = build.math("SQRT", squared)
    deep = build.math("MINIMUM", build.math("MAXIMUM", root, _PARALLEL), _STEEPEST, label="depth of the mean")
    along = build.vector("SUBTRACT", axis, build.vector("SCALE", normal, sine))
    level = build.vector("NORMALIZE", along)
    flat = build.math("SQRT", build.math("SUBTRACT", 1.0, build.math("MULTIPLY", deep, deep)))
    down = build.vector("SUBTRACT", build.vector("SCALE", level, flat), build.vector("SCALE", normal, deep))
    above = build.math("SUBTRACT", build.vector("DOT_PRODUCT", offset, normal), float(plane.height))
    far = build.math("DIVIDE", build.math("MAXIMUM", above, 0.0), deep)
    met = build.vector("SUBTRACT", build.vector("ADD", offset, build.vector("SCALE", down, far)), eye)
    distance = build.math("MAXIMUM", build.vector("LENGTH", met), 1e-6)
    share = build.math("DIVIDE", far, distance)
    height = float(plane.eye @ plane.normal) - float(plane.height)
    slant = build.math("DIVIDE", build.math("DIVIDE", height, distance), deep)
    wider = build.math("MULTIPLY", build.math("MULTIPLY", share, share), slant)
    wider = build.math("MINIMUM", build.math("MAXIMUM", wider, _LEAST_RATIO**2), _MOST_RATIO**2)
    ratio = build.math("DIVIDE", sine, build.math("MAXIMUM", root, 1e-9))
    cover = build.math("MULTIPLY_ADD", ratio, -0.5, 0.5)
    direction = build.vector("SCALE", met, build.math("DIVIDE", 1.0, distance))
    return close_group(build, Direction=direction, Wider=wider, Cover=cover)


def _shell_group(shell: Shell) -> bpy.types.ShaderNodeTree:
    """`Shell.meet`."""
    build, (offset, axis, spread) = open_group(
        "RadTex Shell Shape", Offset="Vector", Axis="Vector", Spread="Float"
    )
    far, normal = _wall(build, shell, _late(build, offset, spread), axis)
    met = build.vector("ADD", offset, build.vector("SCALE", axis, far))
    met = build.vector("SUBTRACT", met, constant(shell.eye))
    distance = build.math("MAXIMUM", build.vector("LENGTH", met), 1e-6)
    direction = build.vector("SCALE", met, build.math("DIVIDE", 1.0, distance))
    deep = build.math("ABSOLUTE", build.vector("DOT_PRODUCT", normal, axis))
    seen = build.math("ABSOLUTE", build.vector("DOT_PRODUCT", normal, direction))
    slant = build.math("DIVIDE", seen, build.math("MAXIMUM", deep, _PARALLEL))
    share = build.math("DIVIDE", far, distance)
    wider = build.math("MULTIPLY", build.math("MULTIPLY", share, share), slant)
    wider = build.math("MINIMUM", build.math("MAXIMUM", wider, _LEAST_RATIO**2), _MOST_RATIO**2)
    return close_group(build, Direction=direction, Wider=wider, Cover=build.value(1.0))


def _wall(build: NodeBuilder, shell: Shell, offset: Socket, axis: Socket) -> tuple[Socket, Socket]:
    """`Shell.far`: how far it is along an axis, and the normal of the plane."""
    far, normal = build.value(FARTHEST), axis
    for way, height in zip(shell.normals, shell.heights, strict=True):
        plane, offset = constant(way), _late(build, offset, far)
        sine = build.math("MULTIPLY", build.vector("DOT_PRODUCT", axis, plane), -1.0)
        above = build.math("SUBTRACT", build.vector("DOT_PRODUCT", offset, plane), float(height))
        deep, above = build.math("MAXIMUM", sine, _PARALLEL), build.math("MAXIMUM", above, 0.0)
        reach, towards = build.math("DIVIDE", above, deep), build.math("GREATER_THAN", sine, _PARALLEL)
        nearer = build.math("MULTIPLY", towards, build.math("LESS_THAN", reach, far))
        far, normal = build.mix(nearer, far, reach, "FLOAT"), build.mix(nearer, normal, plane)
    return far, normal


def _span(
    build: NodeBuilder, facts: LayeredSidecar, offset: Socket, axis: Socket
) -> tuple[Socket, Socket, Socket, Socket] | None:
    """`Impostor._begin`: where a ray begins, enters and leaves a box, and meets a wall; None in the open."""
    if not isinstance(facts.plane, Shell):
        return None
    wall, _ = _wall(build, facts.plane, offset, axis)
    begin = enter = leave = wall
    slow = build.combine(*(_not_still(build, part) for part in build.separate(axis)))
    for low, high in facts.boxes:
        offset = _late(build, offset, begin)
        one, other = (
            build.vector("DIVIDE", build.vector("SUBTRACT", constant(corner), offset), slow)
            for corner in (low, high)
        )
        x, y, z = build.separate(build.vector("MINIMUM", one, other))
        first = build.math("MAXIMUM", x, build.math("MAXIMUM", y, z))
        x, y, z = build.separate(build.vector("MAXIMUM", one, other))
        last = build.math("MINIMUM", x, build.math("MINIMUM", y, z))
        start = build.mix(build.math("GREATER_THAN", first, 0.0), last, first, "FLOAT")
        passed = build.math("SUBTRACT", 1.0, build.math("GREATER_THAN", first, last))
        ahead = build.math("MULTIPLY", passed, build.math("GREATER_THAN", last, 0.0))
        nearer = build.math("MULTIPLY", ahead, build.math("LESS_THAN", start, begin))
        begin = build.mix(nearer, begin, start, "FLOAT")
        enter = build.mix(nearer, enter, build.math("MAXIMUM", first, 0.0), "FLOAT")
        leave = build.mix(nearer, leave, last, "FLOAT")
    return begin, enter, leave, wall


def _not_still(build: NodeBuilder, part: Socket) -> Socket:
    """A component that can be divided by."""
    still = build.math("LESS_THAN", build.math("ABSOLUTE", part), SMALLEST)
    return build.mix(still, part, SMALLEST, "FLOAT")


def _things_group(
    image: bpy.types.Image, octahedron: bpy.types.ShaderNodeTree, facts: LayeredSidecar
) -> bpy.types.ShaderNodeTree:
    """`Impostor.meet`; of the spread only when it is known matters, see `images.ordered`."""
    nearness = _nearness_group(image, octahedron)
    build, (offset, axis, spread) = open_group(
        "RadTex Things Shape", Offset="Vector", Axis="Vector", Spread="Float"
    )
    span = _span(build, facts, _late(build, offset, spread), axis)
    if facts.things_eye.any():
        offset = build.vector("SUBTRACT", offset, constant(facts.things_eye))
    along = ordered(build, build.vector("DOT_PRODUCT", offset, axis), (spread,))
    squared = build.vector("DOT_PRODUCT", offset, offset)
    beyond = build.math("SUBTRACT", build.math("MULTIPLY", along, along), squared)
    first = axis if span is None else build.vector("ADD", offset, build.vector("SCALE", axis, span[0]))
    met = _late(build, first, along)
    ratio = cover = far = distance = build.value(1.0)
    for _ in range(STEPS):
        distance = _distance(build, nearness, met)
        root = build.math("MAXIMUM", build.math("MULTIPLY_ADD", distance, distance, beyond), 0.0)
        far = build.math("SUBTRACT", build.math("SQRT", root), along)
        if span is not None:
            _, enter, leave, wall = span
            behind = build.math("GREATER_THAN", far, build.math("MULTIPLY_ADD", distance, BEYOND, leave))
            inside = build.math("MINIMUM", build.math("MAXIMUM", far, enter), leave)
            far = build.mix(behind, inside, wall, "FLOAT")
        reached = build.vector("ADD", offset, build.vector("SCALE", axis, far))
        length = build.math("MAXIMUM", build.vector("LENGTH", reached), 1e-6)
        met = build.vector("SCALE", reached, build.math("DIVIDE", 1.0, length))
        ratio = build.math("DIVIDE", far, length)
    if span is not None:
        met, ratio, far = _behind(build, nearness, (offset, axis), (met, ratio, far), span)
        away = build.vector("SUBTRACT", build.vector("SCALE", met, distance), offset)
        past = build.math("SUBTRACT", 1.0, build.math("LESS_THAN", far, span[3]))
        cover = build.mix(past, cover, _near_lobe(build, away, axis, spread), "FLOAT")
    ratio = build.math("MINIMUM", build.math("MAXIMUM", ratio, _LEAST_RATIO), _MOST_RATIO)
    return close_group(build, Direction=met, Wider=build.math("MULTIPLY", ratio, ratio), Cover=cover)


def _distance(build: NodeBuilder, nearness: bpy.types.ShaderNodeTree, direction: Socket) -> Socket:
    """How far from the eye things lie in a direction."""
    (near,) = build.group(nearness, direction)
    return build.math("DIVIDE", 1.0, build.math("MAXIMUM", near, 1e-9))


def _behind(
    build: NodeBuilder,
    nearness: bpy.types.ShaderNodeTree,
    ray: tuple[Socket, Socket],
    found: tuple[Socket, Socket, Socket],
    span: tuple[Socket, Socket, Socket, Socket],
) -> tuple[Socket, Socket, Socket]:
    """`Impostor._behind` of a ray's offset from the eye and axis, and of what `found`."""
    (offset, axis), (met, ratio, far), (_, enter, leave, _) = ray, found, span
    way = build.math("SUBTRACT", leave, enter)
    middle = build.math("MULTIPLY_ADD", way, 0.5, enter)
    reached = build.vector("ADD", offset, build.vector("SCALE", axis, middle))
    length = build.math("MAXIMUM", build.vector("LENGTH", reached), 1e-6)
    distance = _distance(build, nearness, reached)
    behind = build.math("SUBTRACT", length, distance)
    past = build.math("SUBTRACT", 1.0, build.math("LESS_THAN", far, leave))
    conditions = (
        build.math("GREATER_THAN", way, _STILL),
        build.math("MAXIMUM", build.math("COMPARE", far, enter, _STILL), past),
        build.math("LESS_THAN", build.math("MULTIPLY", distance, SOLID), length),
        build.math("LESS_THAN", behind, way),
    )
    inside = conditions[0]
    for condition in conditions[1:]:
        inside = build.math("MULTIPLY", inside, condition)
    met = build.mix(inside, met, build.vector("SCALE", reached, build.math("DIVIDE", 1.0, length)))
    ratio = build.mix(inside, ratio, build.math("DIVIDE", middle, length), "FLOAT")
    return met, ratio, build.mix(inside, far, middle, "FLOAT")


def _near_lobe(build: NodeBuilder, away: Socket, axis: Socket, variance: Socket) -> Socket:
    """`environment._near_lobe`."""
    along = build.math("MAXIMUM", build.vector("DOT_PRODUCT", away, axis), 0.0)
    length = build.math("MAXIMUM", build.vector("DOT_PRODUCT", away, away), 1e-12)
    sine = build.math("SUBTRACT", 1.0, build.math("DIVIDE", build.math("MULTIPLY", along, along), length))
    wide = build.math("MULTIPLY", build.math("MAXIMUM", variance, 1e-6), NEAR_LOBE)
    shown = build.math("SUBTRACT", 2.0, build.math("DIVIDE", sine, wide))
    return build.math("MINIMUM", build.math("MAXIMUM", shown, 0.0), 1.0)


def _all_late(
    build: NodeBuilder, offset: Socket, axis: Socket, spread: Socket, known: Socket
) -> tuple[Socket, Socket, Socket]:
    """A lobe's place, axis and width², evaluated only after a colour: see `images.ordered`."""
    grey = ordered(build, build.value(0.0), (known,))
    return _late(build, offset, grey), _late(build, axis, grey), ordered(build, spread, (grey,))


def _late(build: NodeBuilder, vector: Socket, known: Socket) -> Socket:
    """A vector that is evaluated only after a number."""
    x, y, z = build.separate(vector)
    return build.combine(ordered(build, x, (known,)), y, z)


def _nearness_group(image: bpy.types.Image, octahedron: bpy.types.ShaderNodeTree) -> bpy.types.ShaderNodeTree:
    """One over the distance of what lies in a Direction."""
    size, _ = readable_size(image)
    tap, (cell,) = open_group("RadTex Distance", Cell="Vector")
    value = tap.separate(tap.image(image, pixel_centre(tap, cell, (size, size)))[0])[0]
    pixel = close_group(tap, Nearness=value)
    build, (direction,) = open_group("RadTex Distances", Direction="Vector")
    (place,) = build.group(octahedron, direction)
    position = build.vector("MULTIPLY", place, pair(size - 1, size - 1))
    (near,) = bilinear(build, pixel, position, last=pair(size - 1, size - 1))
    return close_group(build, Nearness=near)
