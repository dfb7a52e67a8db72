# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Metal under lamps: a kettle, brushed around its axis, and an egg of chrome."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from .materials import assign, connect, principled
from .meshes import as_subject, lathe, made, mesh_object, smooth_curve
from .stage import Stage, finish, lamp, start


def brushed() -> Stage:
    """A kettle of brushed steel, its highlights drawn out along the axis."""
    start("studio.exr", strength=0.7, turn=75)
    keys = np.array(
        [
            (0.2, -0.85), (0.66, -0.85), (0.78, -0.8), (0.82, -0.66), (0.74, -0.1), (0.6, 0.4), (0.5, 0.56),
            (0.44, 0.62), (0.4, 0.66), (0.2, 0.72), (0.08, 0.74), (0.06, 0.8), (0.14, 0.88), (0.1, 0.97),
            (0.02, 1.0),
        ]
    )  # fmt: skip
    kettle = as_subject(mesh_object("Kettle", *lathe(smooth_curve(keys), segments=96, tip=0.0), smooth=True))
    steel = principled("Steel", (0.66, 0.63, 0.6), Metallic=1.0, Roughness=0.3, Anisotropic=0.7)
    tree: Any = steel.node_tree
    tangent = tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type, tangent.axis = "RADIAL", "Z"
    connect(steel, "Tangent", tangent.outputs["Tangent"])
    assign(kettle, steel)
    lamp((1.6, -2.0, 2.4), size=0.5, watts=40)
    return finish("brushed", kettle)


def lamps() -> Stage:
    """A chrome egg under a square lamp, a disc and a ball."""
    start("studio.exr", strength=0.15, turn=75)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    egg = as_subject(made())
    egg.scale = (0.8, 0.8, 1.0)
    bpy.ops.object.shade_smooth()
    assign(egg, principled("Chrome", (0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.05))
    lamp((2.0, -2.4, 2.2), size=1.2, watts=200)
    lamp((-2.4, -1.6, 1.8), size=1.0, watts=80, shape="DISK")
    lamp((0.4, 2.6, 2.4), size=0.7, watts=80, shape="BALL")
    return finish("lamps", egg)
