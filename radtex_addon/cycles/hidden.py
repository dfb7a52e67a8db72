# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells that nobody can see: a viewer in their direction would stand inside the mesh.

Where one part of a mesh is stuck into another, such as an eye into a head, texels lie in the dark beside
visible ones, and blending would draw dark dots along the line where the parts meet. A ray that leaves for
such a viewer meets the mesh from behind: a few rays for every cell, by the portal capture itself, tell.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ..bake.checkpoint import KEEPS_NOTHING, Keeper
from ..bake.plan import CapturePlan, Tile, plan_of_some
from ..bake.progress import Progress, Stage
from ..bake.rays import PROBES
from ..bake.spec import Kind
from ..core.arrays import Bools, Floats, Ints
from ..scene.nodes import open_material, open_world
from ..scene.scratch import remove_scene
from .portal import PortalCapture

_TILE_PIXELS = 1 << 20
_HIDDEN = "hidden"  # a piece's name


def find_hidden(
    meshes: Sequence[tuple[bpy.types.Mesh, Floats]],
    plan: CapturePlan,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    owner: Ints | None = None,
) -> Generator[Progress, None, Bools]:
    """Which cells look out of their own mesh's inside: (K, n, n), indexed [texel, q, p].

    `meshes` are baked copies and their objects' matrices (4, 4); of several, `owner` (K,) numbers the one
    that each texel lies on, for another's far side hides nothing that is before it. `folder` takes temporary
    files, the `keeper` what is found. All False where every cell would be hidden. Yields progress in texels.
    Raises BakeError where Cycles fails.
    """
    kept = keeper.found(_HIDDEN)
    if kept is None:
        kept = {"hidden": (yield from _probe_each(meshes, plan, folder, owner))}
        keeper.keep(_HIDDEN, kept)
    hidden: Bools = kept["hidden"]
    return np.zeros_like(hidden) if hidden.all() else hidden


def _probe_each(
    meshes: Sequence[tuple[bpy.types.Mesh, Floats]], plan: CapturePlan, folder: Path, owner: Ints | None
) -> Generator[Progress, None, Bools]:
    if owner is None:
        return (yield from _probe(*meshes[0], plan, folder))
    n = plan.layout.bucket
    hidden: Bools = np.zeros((len(plan.texel), n, n), dtype=bool)
    for number, (mesh, matrix_world) in enumerate(meshes):
        of_mesh = owner == number
        if of_mesh.any():
            hidden[of_mesh] = yield from _probe(mesh, matrix_world, plan_of_some(plan, of_mesh), folder)
    return hidden


def _probe(
    mesh: bpy.types.Mesh, matrix_world: Floats, plan: CapturePlan, folder: Path
) -> Generator[Progress, None, Bools]:
    scene = bpy.data.scenes.new("RadTex probe")
    world, _ = open_world("RadTex dark")
    copy = mesh.copy()
    try:
        scene.world = world
        copy.materials.clear()
        copy.materials.append(_shows_back_faces())
        copy.transform(Matrix(matrix_world.tolist()))  # an object's own transform would lose shear
        if np.linalg.det(matrix_world[:3, :3]) < 0:
            copy.flip_normals()
        item = bpy.data.objects.new("RadTex probe", copy)
        scene.collection.objects.link(item)
        return (yield from _back_faces(scene, plan, folder))
    finally:
        remove_scene(scene)
        bpy.data.worlds.remove(world)
        bpy.data.meshes.remove(copy)


def _back_faces(scene: bpy.types.Scene, plan: CapturePlan, folder: Path) -> Generator[Progress, None, Bools]:
    capture = PortalCapture(scene, plan, Kind.INCIDENT, PROBES, 0, folder)
    count = len(plan.texel)
    rows = max(1, _TILE_PIXELS // (plan.columns * plan.layout.bucket**2))
    found = []
    for row in range(0, plan.rows, rows):
        yield Progress(Stage.PROBE, row * plan.columns, count)
        tile = Tile(row, min(rows, plan.rows - row))
        found.append(capture.render(tile)[..., 0] > 0.99)
    yield Progress(Stage.PROBE, count, count)
    return np.concatenate(found)


def _shows_back_faces() -> bpy.types.Material:
    material, build = open_material("RadTex back faces")
    glow = build.node("ShaderNodeEmission", build.geometry("Backfacing"), 1.0)
    build.node("ShaderNodeOutputMaterial", glow.outputs[0])
    return material
