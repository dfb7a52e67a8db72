# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways to unwrap that race: RadTex's own choices, and others that were tried in their place."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.islands import signed_areas, surface_areas, uv_islands, weld
from radtex_addon.scene.mesh.blender_unwrap import Way, unwrapped_by_blender
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.mesh.flatten import FlatIslands, flatten_with_uvunwrap, islands_of, smooth_corners
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv.island_packing import pack_islands, packed_closer
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.scene.uv.unwrap_options import AtlasUnwrap, UnwrapOptions
from radtex_addon.settings.spec import Unwrap

Unwrapper = Callable[[bpy.types.Object, EvaluatedMesh, int], AtlasUnwrap]

_CARRIED = "RadTex carried"


def read(item: bpy.types.Object) -> EvaluatedMesh:
    """The object's mesh, as renders show it."""
    bpy.context.view_layer.update()
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch:
        return evaluate(scratch, item)


def _by(method: Unwrap, options: UnwrapOptions | None = None) -> Unwrapper:
    return lambda _, mesh, texels: finished(unwrap_steps(mesh, texels, method, options))


def _plain(_item: bpy.types.Object, mesh: EvaluatedMesh, texels: int) -> AtlasUnwrap:
    """Islands as uvunwrap makes them, neither merged nor cut."""
    since = perf_counter()
    return _packed(finished(flatten_with_uvunwrap(mesh, UnwrapOptions())), texels, since)


def _carried(item: bpy.types.Object, _mesh: EvaluatedMesh, texels: int) -> AtlasUnwrap:
    """xatlas unwraps the base mesh, and modifiers carry its UVs to the mesh that is rendered."""
    since = perf_counter()
    shown = [(modifier, modifier.show_render) for modifier in item.modifiers]
    for modifier, _shown in shown:
        modifier.show_render = False
    base = read(item)
    made = finished(unwrap_steps(base, texels, Unwrap.XATLAS))
    flat = made.uv * np.array([made.width, made.height]) / max(made.width, made.height)
    mesh: Any = item.data
    if len(base.triangles) != sum(len(face.vertices) - 2 for face in mesh.polygons):
        raise ValueError("the base mesh has other faces")
    mesh.calc_loop_triangles()
    loops = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", loops)
    corner = np.zeros((len(mesh.loops), 2), dtype=np.float32)
    corner[loops] = flat.reshape(-1, 2)
    mesh.uv_layers.new(name=_CARRIED).data.foreach_set("uv", corner.ravel())
    for modifier, was in shown:
        modifier.show_render = was
    whole = read(item)
    return _packed(_scaled(whole, whole.uv(_CARRIED).astype(np.float64)), texels, since)


def _by_angle(_item: bpy.types.Object, mesh: EvaluatedMesh, texels: int) -> AtlasUnwrap:
    """Blender's own unwrap (least squares) of what lies between sharp edges and materials."""
    since = perf_counter()
    vertex = smooth_corners(mesh, UnwrapOptions())
    _, first, index = np.unique(vertex, return_index=True, return_inverse=True)
    points = mesh.world_position[mesh.triangles].reshape(-1, 3)[first]
    flat = unwrapped_by_blender(points, index.reshape(-1, 3), Way.CONFORMAL)
    return _packed(_scaled(mesh, flat, index.reshape(-1, 3)), texels, since)


def _scaled(mesh: EvaluatedMesh, uv: Floats, vertex: Ints | None = None) -> FlatIslands:
    """Islands of a layout that is not to scale, each scaled to its area on the surface."""
    corners = mesh.world_position[mesh.triangles]
    numbers = weld(mesh.position)[mesh.triangles] if vertex is None else vertex
    island = uv_islands(numbers, uv)
    space, flat = np.bincount(island, surface_areas(corners)), np.bincount(island, np.abs(signed_areas(uv)))
    scale = np.sqrt(np.divide(space, flat, out=np.zeros_like(space), where=flat > 0))
    return islands_of(mesh, uv * scale[island][:, None, None], island)


def _packed(flat: FlatIslands, texels: int, since: float) -> AtlasUnwrap:
    padding = UnwrapOptions().padding
    packed = finished(packed_closer(finished(pack_islands(flat, texels, padding)), texels, padding))
    uv = packed.uv / [packed.width, packed.height]
    used = float(np.abs(signed_areas(uv)).sum())
    size = packed.width, packed.height
    return AtlasUnwrap(uv, *size, packed.islands, used, packed.density, 0.0, perf_counter() - since)


WAYS: dict[str, Unwrapper] = {
    "xatlas": _by(Unwrap.XATLAS),
    "xatlas, 4 rounds": _by(Unwrap.XATLAS, UnwrapOptions(iterations=(4,))),
    "xatlas, costly islands": _by(Unwrap.XATLAS, UnwrapOptions(max_cost=8.0, normal_deviation_weight=0.5)),
    "xatlas of the base mesh": _carried,
    "Smart UV Project": _by(Unwrap.BLENDER),
    "Blender, seams by angle": _by_angle,
    "uvunwrap": _plain,
    "uvunwrap, merged and cut": _by(Unwrap.UVUNWRAP),
}
