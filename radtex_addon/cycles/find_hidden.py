# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find hidden cells: a viewer in their direction would stand inside the mesh.

Where one part of a mesh is stuck into another, such as an eye into a head, dark texels lie beside visible
ones, and blending would draw dark dots along the line where the parts meet. A ray from such a texel towards
the viewer meets the mesh from behind: the portal capture tests each cell with a few rays.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Matrix

from ..bake.hidden_cells import HiddenCells
from ..bake.piece_store import NO_STORE, PieceStore, PrefixedStore
from ..bake.plan import CapturePlan, Tile, plan_of_some
from ..bake.progress import Progress, Stage
from ..core.arrays import Floats, Ints
from ..scene.mesh.backs import TWIN
from ..scene.mesh.copy import NORMAL, SIGN, TANGENT
from ..scene.nodes import open_material, open_world
from ..scene.scratch import remove_scene
from ..settings.kinds import Kind
from ..settings.rays import PROBES
from .portal import PortalCapture

_TILE_PIXELS = 1 << 20
_BITS = "bits"  # the array's name in a tile's piece


def find_hidden(
    meshes: Sequence[tuple[bpy.types.Mesh, Floats]],
    plan: CapturePlan,
    folder: Path,
    store: PieceStore = NO_STORE,
    owner: Ints | None = None,
) -> Generator[Progress, None, HiddenCells]:
    """Find the cells of the plan's texels whose viewers would stand inside the texel's own mesh.

    `meshes` are baked copies and their objects' matrices (4, 4). With several, `owner` (K,) is the number of
    the mesh that each texel lies on: each is tested only against its own mesh, as another mesh's back faces
    hide nothing. `folder` is for temporary files; the `store` stores the result tile by tile. If all cells
    would be hidden, none is marked. Yields progress in texels. Raises BakeError where Cycles fails.
    """
    if owner is None:
        bits = yield from _probe(*meshes[0], plan, folder, PrefixedStore(store, "hidden-"))
    else:
        n = plan.layout.bucket
        bits = np.zeros((len(plan.texel), -(-n * n // 8)), dtype=np.uint8)
        for number, (mesh, matrix_world) in enumerate(meshes):
            some = owner == number
            if some.any():
                drawer = PrefixedStore(store, f"hidden-{number}-")
                bits[some] = yield from _probe(mesh, matrix_world, plan_of_some(plan, some), folder, drawer)
    hidden = HiddenCells(bits, plan.layout.bucket)
    return HiddenCells(np.zeros_like(bits), plan.layout.bucket) if hidden.buried.all() else hidden


def _probe(
    mesh: bpy.types.Mesh, matrix_world: Floats, plan: CapturePlan, folder: Path, store: PieceStore
) -> Generator[Progress, None, npt.NDArray[np.uint8]]:
    """The `bits` of `HiddenCells` for the plan's texels; tiles that the store has are not rendered again."""
    height = max(1, _TILE_PIXELS // (plan.columns * plan.layout.bucket**2))
    tiles = [Tile(row, min(height, plan.rows - row)) for row in range(0, plan.rows, height)]
    kept = {tile: store.found(_name(tile)) for tile in tiles}
    found = {tile: piece[_BITS] for tile, piece in kept.items() if piece is not None}
    if len(found) < len(tiles):
        with _probe_scene(mesh, matrix_world) as scene:
            capture = PortalCapture(scene, plan, Kind.INCIDENT, PROBES, 0, folder)
            for tile in (tile for tile in tiles if tile not in found):
                yield Progress(Stage.PROBE, tile.first_row * plan.columns, len(plan.texel))
                found[tile] = HiddenCells.of(capture.render(tile)[..., 0] > 0.99).bits
                store.keep(_name(tile), {_BITS: found[tile]})
    yield Progress(Stage.PROBE, len(plan.texel), len(plan.texel))
    return np.concatenate([found[tile] for tile in tiles])


def _name(tile: Tile) -> str:
    return f"{tile.first_row:06d}-{tile.rows}"


@contextmanager
def _probe_scene(mesh: bpy.types.Mesh, matrix_world: Floats) -> Iterator[bpy.types.Scene]:
    """A scene that shows only a mesh, whose back faces emit light."""
    scene = bpy.data.scenes.new("RadTex probe")
    world, _ = open_world("RadTex dark")
    copy = cast("bpy.types.Mesh", mesh.copy())
    try:
        scene.world = world
        copy.materials.clear()
        copy.materials.append(_shows_back_faces(TWIN in copy.attributes))
        for name in ("custom_normal", NORMAL, TANGENT, SIGN):  # no ray asks, and they are most of the memory
            if (attribute := copy.attributes.get(name)) is not None:
                copy.attributes.remove(attribute)
        copy.transform(Matrix(matrix_world.tolist()))  # an object's own transform would lose shear
        if np.linalg.det(matrix_world[:3, :3]) < 0:
            copy.flip_normals()
        item = bpy.data.objects.new("RadTex probe", copy)
        scene.collection.objects.link(item)
        yield scene
    finally:
        remove_scene(scene)
        bpy.data.worlds.remove(world)
        bpy.data.meshes.remove(copy)


def _shows_back_faces(twins: bool) -> bpy.types.Material:
    """A material that emits light from back faces.

    With `twins` (`scene.mesh.backs`), faces that have a twin emit none: their backs can be seen from outside.
    """
    material, build = open_material("RadTex back faces")
    bright = build.geometry("Backfacing")
    if twins:
        lone = build.math("LESS_THAN", build.attribute(TWIN, "Fac"), -0.5)
        bright = build.math("MULTIPLY", bright, lone)
    glow = build.node("ShaderNodeEmission", bright, 1.0)
    build.node("ShaderNodeOutputMaterial", glow.outputs[0])
    cast(Any, material).cycles.emission_sampling = "NONE"  # else each triangle were a lamp
    return material
