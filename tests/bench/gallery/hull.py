# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A hull that is wrapped around things which lie about the origin, as Blender's Shrinkwrap would do it.

It is an octahedron cut into a grid and blown up: its UVs fill their square, so that no texel is idle.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.kdtree import KDTree

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.octahedron import octahedron_to_direction

UV_LAYER = "UVMap"
_SLACK = 0.005  # between the hull and what it touches


def wrap_hull(name: str, points: Floats, cells: int) -> bpy.types.Object:
    """Link a hull of 2 `cells`² triangles, an even number of cells, around `points` (K, 3).

    Each vertex is as far out as the farthest point within an edge's length of it, seen from the origin.
    """
    places, corners, uv = _grid(cells)
    along = np.linalg.norm(places[corners[:, 0]] - places[corners[:, 1]], axis=1).mean()
    radius = _farthest(points, places, float(along))
    radius = np.maximum(radius, _mean_of_neighbours(radius, corners))
    mesh: Any = bpy.data.meshes.new(name)
    mesh.from_pydata((places * (radius + _SLACK)[:, None]).tolist(), [], corners.tolist())
    mesh.uv_layers.new(name=UV_LAYER).data.foreach_set("uv", uv.astype(np.float32).ravel())
    mesh.shade_smooth()
    hull: bpy.types.Object = bpy.data.objects.new(name, mesh)
    scene: Any = bpy.context.scene
    scene.collection.objects.link(hull)
    return hull


def _grid(cells: int) -> tuple[Floats, Ints, Floats]:
    """Unit vertices (V, 3), faces (K, 3) and their UVs (K, 3, 2): an octahedron's square, K = 2 cells²."""
    steps = np.arange(cells + 1) / cells
    square = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    every = np.round(octahedron_to_direction(square), 9) + 0.0
    places, vertex = np.unique(every, axis=0, return_inverse=True)
    column, row = np.meshgrid(np.arange(cells), np.arange(cells))
    low = (row * (cells + 1) + column).ravel()
    right, up, far = low + 1, low + cells + 1, low + cells + 2
    folded = (((column + 0.5) / cells < 0.5) == ((row + 0.5) / cells < 0.5)).ravel()[:, None, None]
    one = np.stack([[low, right, up], [right, far, up]]).transpose(2, 0, 1)
    other = np.stack([[low, right, far], [low, far, up]]).transpose(2, 0, 1)
    node = np.where(folded, one, other).reshape(-1, 3)
    return places, vertex.reshape(-1)[node], square[node]


def _farthest(points: Floats, places: Floats, reach: float) -> Floats:
    """For each unit vector (V, 3) the largest distance of a point (K, 3) in nearly that direction."""
    distance = np.linalg.norm(points, axis=1)
    tree: Any = KDTree(len(points))
    for index, direction in enumerate(points / distance[:, None]):
        tree.insert(Vector(direction.tolist()), index)
    tree.balance()
    found = [[index for _, index, _ in tree.find_range(Vector(at.tolist()), reach)] for at in places]
    least = float(distance.min())
    return np.array([distance[near].max() if near else least for near in found])


def _mean_of_neighbours(values: Floats, corners: Ints) -> Floats:
    """The mean of what each vertex and its neighbours have, half by half."""
    total, count = np.zeros((2, len(values)))
    for turn in (1, 2):
        np.add.at(total, corners, values[np.roll(corners, turn, axis=1)])
        np.add.at(count, corners, 1)
    mean: Floats = (values + total / count) / 2
    return mean
