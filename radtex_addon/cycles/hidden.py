# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells that nobody can see: a viewer in their direction would stand inside the mesh.

Where one part of a mesh is stuck into another, such as an eye into a head, texels lie in the dark beside
visible ones, and blending would draw dark dots along the line where the parts meet. A ray that leaves for
such a viewer meets the mesh from behind: a few rays for every cell, by the portal capture itself, tell.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ..bake.checkpoint import KEEPS_NOTHING, Keeper
from ..bake.plan import CapturePlan, Tile
from ..bake.progress import Progress, Stage
from ..bake.rays import PROBES
from ..bake.spec import Kind
from ..core.arrays import Bools, Floats
from ..scene.nodes import open_material, open_world
from ..scene.scratch import remove_scene
from .portal import PortalCapture

_TILE_PIXELS = 1 << 20
_HIDDEN = "hidden"  # a piece's name


def find_hidden(
    mesh: bpy.types.Mesh,
    matrix_world: Floats,
    plan: CapturePlan,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
) -> Generator[Progress, None, Bools]:
    """Which cells look out of the mesh's own inside: (K, n, n), indexed [texel, q, p].

    `mesh` is the baked copy, `matrix_world` (4, 4) its object's, `folder` takes temporary files, the
    `keeper` what is found. All False where every cell would be hidden. Yields progress in texels. Raises
    BakeError where Cycles fails.
    """
    kept = keeper.found(_HIDDEN)
    if kept is None:
        kept = {"hidden": (yield from _probe(mesh, matrix_world, plan, folder))}
        keeper.keep(_HIDDEN, kept)
    hidden: Bools = kept["hidden"]
    return np.zeros_like(hidden) if hidden.all() else hidden


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
