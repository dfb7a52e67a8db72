# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's tree of triangles to cast rays at, made of arrays."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.arrays import Floats, Ints


def bare_mesh(position: Floats, triangles: Ints, name: str = "RadTex triangles") -> bpy.types.Mesh:
    """A mesh of vertices (V, 3) and triangles (F, 3), and nothing else."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(position))
    mesh.loops.add(triangles.size)
    mesh.polygons.add(len(triangles))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(position, dtype=np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(triangles, dtype=np.int32).ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    return mesh


def triangle_tree(position: Floats, triangles: Ints) -> BVHTree:
    """The tree of triangles (F, 3) with vertices at `position` (V, 3), which it rounds to float32.

    Blender reads them from an object: of Python's lists, millions of triangles would take gigabytes.
    """
    mesh = bare_mesh(position, triangles)
    item = bpy.data.objects.new("RadTex triangles", mesh)
    scene = bpy.data.scenes.new("RadTex triangles")
    try:
        scene.collection.objects.link(item)
        layer = scene.view_layers[0]
        layer.update()
        assert layer.depsgraph is not None  # a layer that was updated has one
        of_object: Any = BVHTree.FromObject  # its stubs name other classes of objects
        return cast("BVHTree", of_object(item, layer.depsgraph))
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.meshes.remove(mesh)  # and the object with it


def distances_from(tree: BVHTree, eye: Floats, ways: Floats) -> Floats:
    """How far from an eye things are along unit directions (P, 3), (P,); infinite where there is nothing."""
    cast_ray: Any = tree.ray_cast
    start = Vector(eye.tolist())
    found = (cast_ray(start, Vector(way))[3] for way in ways.tolist())
    return np.array([np.inf if far is None else far for far in found])
