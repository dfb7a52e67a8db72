# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own ways to flatten a mesh, in a scene of their own: the user's mode and selection stay."""

from __future__ import annotations

from enum import Enum
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Floats, Ints
from .triangle_tree import bare_mesh


class Way(Enum):
    """Smart UV Project, which cuts by angle; or each connected part as it is.

    By least squares (LSCM), or by angles (ABF++), which stretches less and takes some seven times as long.
    """

    PROJECT = "project"
    CONFORMAL = "CONFORMAL"
    ANGLES = "ANGLE_BASED"


def unwrapped_by_blender(points: Floats, triangles: Ints, way: Way, angle: float = 0.0) -> Floats:
    """Flatten triangles (F, 3) of points (V, 3): (F, 3, 2) float64, not to scale, parts over one another.

    `angle`, in radians, is Smart UV Project's limit. No triangle may have a vertex twice: Blender would hang.
    """
    mesh = bare_mesh(points, triangles, "RadTex unwrap")
    mesh.polygons.foreach_set("select", np.ones(len(triangles), dtype=bool))
    mesh.uv_layers.new(name="UV")
    item = bpy.data.objects.new("RadTex unwrap", mesh)
    scene = bpy.data.scenes.new("RadTex unwrap")
    try:
        scene.collection.objects.link(item)
        layer = scene.view_layers[0]
        layer.update()
        layer.objects.active = item
        item.select_set(True, view_layer=layer)
        with cast("Any", bpy.context).temp_override(  # in the stubs of 5.2 it is no context manager
            scene=scene, view_layer=layer, active_object=item, object=item, edit_object=item
        ):
            bpy.ops.object.mode_set(mode="EDIT")
            if way is Way.PROJECT:
                bpy.ops.uv.smart_project(angle_limit=angle, island_margin=0.0)
            else:
                bpy.ops.uv.unwrap(method=way.value, fill_holes=False, correct_aspect=False, margin=0.0)
            bpy.ops.object.mode_set(mode="OBJECT")
        uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
        mesh.uv_layers[0].data.foreach_get("uv", uv)
        return uv.reshape(-1, 3, 2).astype(np.float64)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.meshes.remove(mesh)
