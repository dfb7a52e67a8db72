# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""About how large an object's surface is, and how many islands it has, without a render's evaluation."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...core.islands import signed_areas, surface_areas, uv_islands
from ..surfaces import shown_mesh

_SAMPLE = 50_000  # triangles that are measured, every n-th of a larger mesh: some milliseconds

_counts: dict[bytes, int] = {}  # of islands, by what was counted


@dataclass(frozen=True)
class AboutArea:
    """The area of a surface in square scene units, and what it covers of a UV layer, 0 to 1."""

    surface: float
    covered: float | None = None


def about_area(item: bpy.types.Object, layer: bpy.types.ViewLayer, uv_layer: str | None = None) -> AboutArea:
    """Measure the object as the view layer last evaluated it for the viewport; else without modifiers.

    A UV layer that the object lacks covers nothing, and counts as None.
    """
    found = item if layer.depsgraph is None else item.evaluated_get(layer.depsgraph)
    with shown_mesh(found) as mesh:
        return AboutArea(0.0) if mesh is None else _area_of(mesh, found, uv_layer)


def _area_of(mesh: bpy.types.Mesh, found: bpy.types.Object, uv_layer: str | None) -> AboutArea:
    mesh.calc_loop_triangles()
    triangles: Any = mesh.loop_triangles
    vertices = _of(triangles, "vertices", np.int32)
    step = -(-max(len(vertices), 1) // _SAMPLE)
    place = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", place)
    turn = np.array(found.matrix_world, dtype=np.float64)[:3, :3].T
    corners = place.reshape(-1, 3)[vertices[::step]].astype(np.float64) @ turn
    share = len(vertices) / max(len(corners), 1)
    surface = share * float(surface_areas(corners).sum())
    uv: Any = mesh.uv_layers.get(uv_layer) if uv_layer else None
    if uv is None:
        return AboutArea(surface)
    flat = np.empty(2 * len(mesh.loops), dtype=np.float32)
    uv.uv.foreach_get("vector", flat)
    loops = _of(triangles, "loops", np.int32)[::step]
    covered = share * float(np.abs(signed_areas(flat.reshape(-1, 2)[loops].astype(np.float64))).sum())
    return AboutArea(surface, covered if 0 < covered < np.inf else None)


def about_islands(item: bpy.types.Object) -> int:
    """How many islands the active UV layer of a mesh object has, without its modifiers; 0 without a layer.

    Counting takes a tenth of a second for 100,000 triangles; counts are kept, by what was counted.
    """
    mesh = item.data
    if not isinstance(mesh, bpy.types.Mesh) or mesh.uv_layers.active is None or item.mode == "EDIT":
        return 0
    uv: Any = mesh.uv_layers.active
    mesh.calc_loop_triangles()
    triangles: Any = mesh.loop_triangles
    flat = np.empty(2 * len(mesh.loops), dtype=np.float32)
    uv.uv.foreach_get("vector", flat)
    vertices = _of(triangles, "vertices", np.int32)
    corners = flat.reshape(-1, 2)[_of(triangles, "loops", np.int32)]
    if not len(vertices):
        return 0
    key = hashlib.blake2b(vertices.tobytes() + corners.tobytes(), digest_size=16).digest()
    if key not in _counts:
        _counts[key] = int(uv_islands(vertices, corners).max()) + 1
    return _counts[key]


def _of(triangles: Any, name: str, dtype: type[np.int32]) -> np.ndarray[Any, np.dtype[np.int32]]:
    """A property (F, 3) of a mesh's triangles."""
    values = np.empty(3 * len(triangles), dtype=dtype)
    triangles.foreach_get(name, values)
    return values.reshape(-1, 3)
