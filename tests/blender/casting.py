# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays cast without Cycles: what a shadow must say, from the very points that a bake starts at."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Bools, Floats, Ints
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec


def plan_of_bake(name: str, spec: BakeSpec) -> CapturePlan:
    """Where a bake of `spec` sends rays from the open scene's object `name`."""
    kept: list[bpy.types.ID] = []
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene), None, kept) as scratch:
        prepared = finished(prepare(scratch, [find_object(scratch, name)], spec, kept))
        with tempfile.TemporaryDirectory() as folder:
            plan = finished(prepared.plan_of_seen(spec.bucket, Path(folder)))
    bpy.data.batch_remove(kept)
    return plan


def all_meshes() -> BVHTree:
    """Everything in the open scene, evaluated, in world space, in the triangles that Cycles has too."""
    graph = bpy.context.evaluated_depsgraph_get()
    places: list[Any] = []
    faces: list[tuple[int, ...]] = []
    for item in cast(bpy.types.Scene, bpy.context.scene).objects:
        if item.type != "MESH":
            continue
        shown: Any = item.evaluated_get(graph)
        mesh = shown.to_mesh()
        start = len(places)
        places += [shown.matrix_world @ vertex.co for vertex in mesh.vertices]
        mesh.calc_loop_triangles()
        faces += [tuple(start + index for index in face.vertices) for face in mesh.loop_triangles]
        shown.to_mesh_clear()
    return cast(BVHTree, BVHTree.FromPolygons(places, faces))


def blocked(tree: BVHTree, plan: CapturePlan, texel: Ints, direction: Floats) -> Bools:
    """Whether rays from the plan's texels (K,), numbered as the plan has them, hit anything: (K,).

    `direction` (K, 3) is in the texels' frames. What goes below the facet is blocked.
    """
    axes = (field.reshape(-1, 3)[texel] for field in (plan.tangent, plan.bitangent, plan.normal))
    world = sum(direction[:, k, None] * axis for k, axis in enumerate(axes))
    facet = plan.facet.reshape(-1, 3)[texel].astype(float)
    start = plan.points[texel] + plan.offset.reshape(-1, 1)[texel] * facet
    cast_ray = cast(Any, tree.ray_cast)
    hit = [
        cast_ray(Vector(origin), Vector(way))[0] is not None
        for origin, way in zip(start.tolist(), np.asarray(world).tolist(), strict=True)
    ]
    below = np.einsum("kx,kx->k", world, facet) < 0
    found: Bools = np.array(hit) | below
    return found
