# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""MikkTSpace's tangents, bit-identical each time.

For more than 10,000 faces Blender uses several threads, and sums tangents at a vertex in the order in which
the threads arrive. So large meshes are cut into patches that are small enough for one thread.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...bake.progress import Progress, Stage, Steps, finished
from ...core.arrays import Floats, Ints
from ...core.islands import weld
from ...core.surface import patches

_ALONE = 10_000  # faces for which Blender uses one thread only
_LAYER, _NORMAL = "RadTex patch", "custom_normal"


def calc_tangents(position: Floats, triangles: Ints, normal: Floats, uv: Floats) -> tuple[Floats, Floats]:
    """`calc_tangents_steps`, without progress."""
    return finished(calc_tangents_steps(position, triangles, normal, uv))


def calc_tangents_steps(
    position: Floats, triangles: Ints, normal: Floats, uv: Floats
) -> Steps[tuple[Floats, Floats]]:
    """Tangents (F, 3, 3) float32 on corners, and the bitangents' signs (F, 3).

    `position` (V, 3), `triangles` (F, 3), `normal` (F, 3, 3) of unit length, `uv` (F, 3, 2). Yields progress
    in triangles.
    """
    tangent = np.empty((len(triangles), 3, 3), dtype=np.float32)
    sign = np.empty((len(triangles), 3), dtype=np.float32)
    # MikkTSpace, too, treats vertices at the same position as one.
    vertex = weld(position).astype(np.int32)[triangles]
    done = 0
    for own, whole in patches(vertex, position[triangles].mean(axis=1), _ALONE):
        found = _calc(position[triangles[whole]], normal[whole], uv[whole])
        here = np.searchsorted(whole, own)
        tangent[own], sign[own] = found[0][here], found[1][here]
        done += len(own)
        yield Progress(Stage.RASTER, done, len(triangles))
    return tangent, sign


def _calc(corners: Floats, normal: Floats, uv: Floats) -> tuple[Floats, Floats]:
    """`calc_tangents` for triangles with these `corners` (F, 3, 3), by one call of Blender."""
    count = len(corners)
    mesh: Any = bpy.data.meshes.new("RadTex patch")
    try:
        mesh.vertices.add(3 * count)
        mesh.loops.add(3 * count)
        mesh.polygons.add(count)
        mesh.vertices.foreach_set("co", np.ascontiguousarray(corners, dtype=np.float32).ravel())
        mesh.loops.foreach_set("vertex_index", np.arange(3 * count, dtype=np.int32))
        mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
        for name, kind, field, values in (
            (_LAYER, "FLOAT2", "vector", uv),
            (_NORMAL, "FLOAT_VECTOR", "vector", normal),
        ):
            layer = mesh.attributes.new(name, kind, "CORNER")
            layer.data.foreach_set(field, np.ascontiguousarray(values, dtype=np.float32).ravel())
        mesh.update(calc_edges=True)
        mesh.calc_tangents(uvmap=_LAYER)
        tangent = np.empty((count, 3, 3), dtype=np.float32)
        sign = np.empty((count, 3), dtype=np.float32)
        mesh.loops.foreach_get("tangent", tangent.ravel())
        mesh.loops.foreach_get("bitangent_sign", sign.ravel())
    finally:
        bpy.data.meshes.remove(mesh)
    return tangent, sign
