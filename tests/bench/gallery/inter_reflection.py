# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A copper bowl that lights and mirrors itself: python -m tests.bench.gallery inter_reflection"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bmesh
import bpy

from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import SUBJECT, Camera, added, empty_scene, lamp, opaque_rows, principled
from .row import Row

SPEC = BakeSpec(layout=Layout.LAYERED)
BUCKETS = BakeSpec(texels=128, bucket=8, samples=8, denoise=True)
CAMERAS = {
    "left": Camera((-1.9, -2.6, 3.3), (0, 0, -0.25)),
    "right": Camera((2.4, -1.9, 3.2), (0, 0, -0.25)),
}
_RIM = 0.3  # the height at which the ball is cut open


def scene() -> None:
    """A deep bowl under a lamp: light reaches its ground by many bounces, and twelve are traced."""
    made = empty_scene((0.3, 0.32, 0.36))
    lamp((-2.5, -1.5, 4.0), watts=300, size=2)
    made.cycles.max_bounces = made.cycles.glossy_bounces = made.cycles.diffuse_bounces = 12
    copper = principled("Copper", (0.85, 0.4, 0.22), Metallic=0.6, Roughness=0.5)
    bowl = added("uv_sphere", SUBJECT, copper, segments=96, ring_count=48)
    cut: Any = bmesh.new()
    cut.from_mesh(bowl.data)
    bmesh.ops.delete(cut, geom=[vertex for vertex in cut.verts if vertex.co.z > _RIM], context="VERTS")
    cut.to_mesh(bowl.data)
    cut.free()
    wall = bowl.modifiers.new("Wall", "SOLIDIFY")
    wall.thickness = 0.08
    bpy.ops.object.shade_smooth()


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: the bowl from two sides."""
    return opaque_rows("Inter-reflection", spec, CAMERAS, scene, beside=BUCKETS)
