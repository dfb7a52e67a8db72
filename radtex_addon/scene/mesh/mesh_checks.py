# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Refuse meshes that have nothing to bake: no faces, no area, coordinates that are not finite.

`evaluate` checks what a render shows. `check_shown` asks the viewport's evaluation, which is there already:
it is quick, and says nothing where renders may show something else.

An object needs a size and a place at which Cycles can trace rays: it computes in float32.
"""

from __future__ import annotations

import logging
from typing import Any

import bpy
import numpy as np

from ...core.arrays import Floats, Ints
from ...core.errors import InputError
from ...core.islands import areas_on_surface
from ...core.surface import ray_offset
from ..checks.refusals import refuse_adaptive_subdivision, refuse_displacement
from ..surfaces import shown_mesh

log = logging.getLogger(__name__)

_TINY, _HUGE = 1e-6, 1e9  # scene units; a tenth of the least, 4 times the most bakes black or clear
_OFF = 0.05  # times the diagonal: rays that start farther from the surface may start behind another object
_LOST = 5.0  # times the diagonal: beyond this, float32 has too few different values across the object
FARTHEST = 1e18  # the squares of larger coordinates are not finite in float32
_MOST = 250_000  # vertices of a mesh that `check_shown` looks at: a millisecond
_FEW = 20_000  # faces of a mesh whose area it measures


def check_extent(name: str, position: Floats, *, warns: bool = True) -> None:
    """Check that rays can start at an object's vertices (V, 3), in world space.

    Raises InputError if the object is too small, too large, or much too far from the origin for its size; if
    it is somewhat too far, logs a warning, if `warns`.
    """
    diagonal = float(np.linalg.norm(position.max(axis=0) - position.min(axis=0)))
    if diagonal == 0:
        return  # the checks of the surface's area report this
    if not _TINY <= diagonal <= _HUGE:
        raise InputError(
            f"object '{name}' is {diagonal:.3g} scene units across, Cycles traces {_TINY:g} to {_HUGE:g}: "
            "scale the scene"
        )
    off = ray_offset(position)
    if off <= _OFF * diagonal:
        return
    far = float(np.abs(position).max())
    place = f"object '{name}' stands {far:.3g} scene units from the origin and is {diagonal:.3g} across"
    if off > _LOST * diagonal:
        raise InputError(
            f"{place}: Cycles rounds coordinates too much there; move the scene nearer to the origin"
        )
    if not warns:
        return
    log.warning(
        "%s: Cycles rounds coordinates there, rays start %.2g from the surface; move the scene to the origin",
        place,
        off,
    )


def no_faces(name: str, instances: int = 0) -> InputError:
    """The error of an object without faces in renders; `instances` is how many instances it makes."""
    hint = "give it some, or name another"
    if instances:
        hint = "join its instances, or add Realize Instances to its modifiers"
    return InputError(f"object '{name}' has no faces in renders: {hint}")


def check_positions(name: str, positions: Floats) -> None:
    """Raise InputError if vertices (V, 3), in object space, are not finite, or too far to compute with."""
    bad = int(np.count_nonzero(~(np.abs(positions) < FARTHEST).all(axis=1)))
    if bad:
        raise InputError(f"object '{name}' has {bad} vertices whose coordinates are not finite: delete them")


def check_matrix(name: str, matrix: Floats) -> None:
    """Raise InputError if a matrix (4, 4) from object to world is not finite, or flattens an axis."""
    if not np.isfinite(matrix).all():
        raise InputError(f"object '{name}' has a transform that is not finite: reset it")
    stretch = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if stretch[-1] <= 1e-9 * stretch[0]:
        raise InputError(f"object '{name}' is scaled to nothing along an axis: give every axis a scale")


def scale_in_world(layer: bpy.types.ViewLayer, item: bpy.types.Object) -> tuple[Floats, bool]:
    """The length of each axis (3,) of an object in the world, as viewports have it, and if it is mirrored."""
    shown = item if layer.depsgraph is None else item.evaluated_get(layer.depsgraph)
    matrix = np.array(shown.matrix_world, dtype=np.float64)[:3, :3]
    return np.linalg.norm(matrix, axis=0), bool(np.linalg.det(matrix) < 0)


def check_area(name: str, positions: Floats, triangles: Ints) -> None:
    """Raise InputError if no triangle (F, 3) of vertices (V, 3), in world space, has an area."""
    if not areas_on_surface(positions, triangles).any():
        raise InputError(f"object '{name}' has faces, but no area to bake: give it a size")


def check_shown(scene: bpy.types.Scene, layer: bpy.types.ViewLayer, item: bpy.types.Object) -> None:
    """Raise InputError if an object cannot be baked, as far as its view in the viewport tells surely.

    Says nothing of an object that is hidden there, in Edit Mode, large, or whose modifiers may give renders
    another mesh than the viewport.
    """
    refuse_adaptive_subdivision(item, scene)
    if len(item.material_slots) == 1 and not any(modifier.type == "NODES" for modifier in item.modifiers):
        refuse_displacement(item.name, [item.material_slots[0].material])
    mesh = item.data if isinstance(item.data, bpy.types.Mesh) else None
    if mesh is not None and not mesh.polygons and not item.modifiers and item.mode != "EDIT":
        raise no_faces(item.name)
    if layer.depsgraph is None or item.mode == "EDIT" or not item.visible_get(view_layer=layer):
        return
    shown = item.evaluated_get(layer.depsgraph)
    matrix = np.array(shown.matrix_world, dtype=np.float64)
    check_matrix(item.name, matrix)
    if not any(_may_differ(modifier) for modifier in item.modifiers):
        with shown_mesh(shown) as made:
            if made is None:
                raise no_faces(item.name)
            _check_mesh(item.name, made, matrix)


def _check_mesh(name: str, mesh: bpy.types.Mesh, matrix: Floats) -> None:
    if not mesh.polygons:
        raise no_faces(name)
    if len(mesh.vertices) > _MOST:
        return
    place = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", place)
    positions = place.reshape(-1, 3)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    used = np.zeros(len(positions), dtype=bool)
    used[corners] = True
    check_positions(name, positions[used])
    if len(mesh.polygons) > _FEW:
        return
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    world = positions.astype(np.float64) @ matrix[:3, :3].T
    check_area(name, world, triangles.reshape(-1, 3))


def _may_differ(modifier: Any) -> bool:
    """Whether a modifier may give a mesh faces in renders and none in the viewport, or the other way."""
    if modifier.show_viewport != modifier.show_render:
        return True
    return modifier.type == "NODES" and _asks_for_viewport(modifier.node_group, set())


def _asks_for_viewport(tree: Any, seen: set[Any]) -> bool:
    if tree is None or tree in seen:
        return False
    seen.add(tree)
    inner = (getattr(node, "node_tree", None) for node in tree.nodes)
    asks = any(node.bl_idname == "GeometryNodeIsViewport" for node in tree.nodes)
    return asks or any(_asks_for_viewport(one, seen) for one in inner)
