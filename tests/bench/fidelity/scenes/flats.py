# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A machined bracket of large flat mirrors over a floor that ends within view of its reflections."""

from __future__ import annotations

from math import radians
from typing import Any, cast

import bpy
import numpy as np

from .materials import assign, checker, principled
from .meshes import as_subject, extruded, made, mesh_object
from .stage import Stage, finish, start


def flats() -> Stage:
    """A bracket: its uprights of roughness 0.1, all that faces up or down of 0.3."""
    start("sunrise.exr", strength=0.7, turn=250)
    outline = np.array(
        [(-0.95, -0.7), (0.95, -0.7), (0.95, -0.35), (0.1, -0.35), (-0.3, 0.1), (-0.3, 0.8), (-0.95, 0.8)]
    )
    bracket = as_subject(mesh_object("Bracket", *extruded(outline, 1.3), smooth=False))
    bracket.rotation_euler = (0, 0, radians(28))
    assign(bracket, principled("Polished", (0.75, 0.74, 0.72), Metallic=1.0, Roughness=0.1))
    assign(bracket, principled("Milled", (0.55, 0.57, 0.62), Metallic=1.0, Roughness=0.3))
    mesh = cast(bpy.types.Mesh, bracket.data)
    mesh.polygons.foreach_set("material_index", [int(abs(face.normal.z) > 0.5) for face in mesh.polygons])
    bevel: Any = bracket.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.025, 2
    return finish("flats", bracket, floor=_small_floor)


def _small_floor(height: float) -> None:
    """A floor that ends not far behind the near things."""
    bpy.ops.mesh.primitive_plane_add(size=5, location=(0, 0, height))
    floor = made()
    floor.rotation_euler = (0, 0, radians(12))
    assign(floor, checker(tiles=10))
