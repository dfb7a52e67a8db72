# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A room of single planes, four metres long, and things in it."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

context: Any = bpy.context  # to the stubs, every pointer may be None

LONG, HIGH = 4.0, 2.5
WALLS = ("Floor", "Ceiling", "West", "East", "South", "North")
_PLACES = {
    "Floor": ((0, 0, 0), (0, 0, 1)),
    "Ceiling": ((0, 0, HIGH), (0, 0, -1)),
    "West": ((-LONG / 2, 0, HIGH / 2), (1, 0, 0)),
    "East": ((LONG / 2, 0, HIGH / 2), (-1, 0, 0)),
    "South": ((0, -LONG / 2, HIGH / 2), (0, 1, 0)),
    "North": ((0, LONG / 2, HIGH / 2), (0, -1, 0)),
}


def card(name: str, place: Any, normal: Any, size: tuple[float, float]) -> Any:
    """A single plane that faces along one of the axes: as wide as `size` across, and as high."""
    normal = np.array(normal, dtype=np.float64)
    up = np.array((0, 1, 0)) if normal[2] else np.array((0, 0, 1))
    along = np.cross(up, normal)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(
        [tuple(np.array(place) + (x * size[0] * along + y * size[1] * up) / 2) for x, y in corners],
        [],
        [(0, 1, 2, 3)],
    )
    item = bpy.data.objects.new(name, mesh)
    context.scene.collection.objects.link(item)
    return item


def box(name: str, place: Any, size: Any) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=1, location=place)
    item = context.object
    item.name, item.scale = name, size
    context.view_layer.update()
    return item


def walls(without: tuple[str, ...] = (), turned: bool = False, scale: float = 1.0) -> None:
    """A room of single planes that face inwards, or `turned` outwards."""
    for name in (name for name in WALLS if name not in without):
        place, normal = _PLACES[name]
        size = (LONG, LONG if normal[2] else HIGH)
        item = card(name, scale * np.array(place), normal, (scale * size[0], scale * size[1]))
        if turned:
            item.data.flip_normals()


def furniture() -> None:
    box("Table", (0.5, 0.3, 0.4), (1.2, 0.8, 0.8))
    card("Rug", (-0.8, 0, 0.004), (0, 0, 1), (1.5, 1.5))
    card("Mirror", (-LONG / 2 + 0.01, 0, 1.5), (1, 0, 0), (1, 0.8))
