# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bilinear lookups by nodes: four taps, each a group that reads one pixel, blended.

Images are read by `Closest` and blended here: Blender's `Linear` would mip, and bleed, across buckets.
"""

from __future__ import annotations

import bpy

from ..scene.nodes import NodeBuilder, Operand, Socket


def bilinear(
    build: NodeBuilder,
    tap: bpy.types.ShaderNodeTree,
    position: Socket,
    *rest: Socket,
    last: tuple[float, ...] | None = None,
) -> tuple[Socket, ...]:
    """Blend all outputs of `tap` at the four whole places around `position`, each clamped to [0, last].

    The place is the group's first input, `rest` are the others. Without `last` nothing is clamped: there is a
    border to be read.
    """
    corner = build.vector("FLOOR", position)
    fx, fy, _ = build.separate(build.vector("FRACTION", position))
    opposite = build.vector("ADD", corner, pair(1, 1))
    if last is not None:
        corner, opposite = clamp(build, corner, last), clamp(build, opposite, last)
    x0, y0, _ = build.separate(corner)
    x1, y1, _ = build.separate(opposite)
    below, above = (
        _blend(build, fx, *(build.group(tap, build.combine(x, y), *rest) for x in (x0, x1))) for y in (y0, y1)
    )
    return _blend(build, fy, below, above)


def clamp(build: NodeBuilder, place: Operand, last: tuple[float, ...], label: str = "") -> Socket:
    """`place` brought into [0, last], component by component."""
    return build.vector("MINIMUM", build.vector("MAXIMUM", place, (0.0, 0.0, 0.0)), last, label=label)


def pair(x: float, y: float) -> tuple[float, float, float]:
    """Two numbers as the vector that a node takes."""
    return float(x), float(y), 0.0


def _blend(
    build: NodeBuilder, factor: Socket, low: tuple[Socket, ...], high: tuple[Socket, ...]
) -> tuple[Socket, ...]:
    """Each of `low` and the one like it in `high`, linearly."""

    def between(at_zero: Socket, at_one: Socket) -> Socket:
        if at_zero.type == "VALUE":
            return build.math("MULTIPLY_ADD", factor, build.math("SUBTRACT", at_one, at_zero), at_zero)
        return build.mix(factor, at_zero, at_one, at_zero.type)

    return tuple(between(*both) for both in zip(low, high, strict=True))
