# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups that lookups of several forms need: the octahedron of directions, and the working space."""

from __future__ import annotations

import bpy

from ..scene.nodes import NodeBuilder, Socket, close_group, open_group
from ..scene.working_space import rec709_primaries
from .taps import pair

_TINY = 1e-30  # avoids 0/0, as in core.octahedron


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
