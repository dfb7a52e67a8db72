# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flatten a surface into islands, to scale: by xatlas, or by Blender's Smart UV Project.

Vertices are welded by position first, so that doubled vertices do not tear islands apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ...core.frame import normalised
from ...core.islands import components, signed_areas, surface_areas, uv_islands, weld
from ..uv.unwrap_options import UnwrapOptions
from ..uv.xatlas_process import Options, Steps, XatlasProcess
from .evaluated import EvaluatedMesh

_THIN = 1e-6  # times the mean area: triangles with less area belong to no island
_FINE = 2048  # texels of the atlas in which xatlas returns islands; it rounds their sizes to texels
_HANDOVER: Options = {"resolution": _FINE, "rotate_charts": False}
_RESPECTED = 1000.0  # from this weight on xatlas never grows an island across an edge with two normals


@dataclass(frozen=True, eq=False)
class FlatIslands:
    """Triangles flattened to scale: `uv` (F, 3, 2) in scene units, `island` (F,), -1 if without area.

    Islands may overlap. `border` is the total length of their borders on the surface, in scene units.
    """

    uv: Floats
    island: Ints
    border: float

    @property
    def count(self) -> int:
        """The number of islands."""
        return int(self.island.max(initial=-1)) + 1

    @property
    def area(self) -> float:
        """The islands' area in square scene units."""
        return float(np.abs(signed_areas(self.uv[self.island >= 0])).sum())

    @property
    def unit(self) -> float:
        """Side of a square as large as the mean triangle."""
        return math.sqrt(self.area / max(int(np.count_nonzero(self.island >= 0)), 1))


def flatten_with_xatlas(
    xatlas: XatlasProcess, evaluated: EvaluatedMesh, options: UnwrapOptions, iterations: int
) -> Steps[FlatIslands]:
    """Flatten by xatlas, in world space to include the object's scale and stretch. Yields progress."""
    corners, vertex = _world_corners(evaluated)
    points, unit = _normalised(corners)
    shading = _shading_vertices(vertex, evaluated.world_normal, math.cos(math.radians(options.seam_angle)))
    _, first = np.unique(shading, return_index=True)
    normals = np.zeros((len(first), 3))
    np.add.at(normals, shading, evaluated.world_normal.reshape(-1, 3))
    charts = yield from xatlas.flatten(
        points.reshape(-1, 3)[first].astype(np.float32),
        shading.reshape(-1, 3).astype(np.uint32),
        normalised(normals).astype(np.float32),
        _chart_options(options, len(vertex), iterations),
        _HANDOVER,
    )
    flat = (
        charts.uv[charts.index].astype(np.float64)
        * [charts.width, charts.height]
        * (unit / max(charts.texels_per_unit, 1e-30))
    )
    island = charts.owner[charts.index[:, 0]].astype(np.int64)
    island[island >= charts.count] = -1
    return _islands(flat, island, corners, vertex)


def flatten_with_blender(evaluated: EvaluatedMesh, options: UnwrapOptions) -> FlatIslands:
    """Flatten by Smart UV Project, and scale each island to its area on the surface."""
    corners, vertex = _world_corners(evaluated)
    # Blender hangs on faces that have a vertex twice.
    whole = (vertex != np.roll(vertex, 1, axis=1)).all(axis=1)
    uv = np.zeros((len(vertex), 3, 2))
    island = np.full(len(vertex), -1)
    uv[whole] = _smart_project(
        _normalised(corners)[0][whole], vertex[whole], math.radians(options.blender_angle)
    )
    island[whole] = uv_islands(vertex[whole], uv[whole])
    space = np.bincount(island[whole], surface_areas(corners[whole]))
    texture = np.bincount(island[whole], np.abs(signed_areas(uv[whole])))
    scale = np.sqrt(np.divide(space, texture, out=np.zeros_like(space), where=texture > 0))
    return _islands(uv * scale[island][:, None, None], island, corners, vertex)


def _world_corners(evaluated: EvaluatedMesh) -> tuple[Floats, Ints]:
    """Corner positions in world space (F, 3, 3), and numbers (F, 3) that are equal for equal positions."""
    vertex = weld(evaluated.position)[evaluated.triangles]
    return evaluated.world_position[evaluated.triangles], vertex


def _normalised(corners: Floats) -> tuple[Floats, float]:
    """Corners centred on the origin, scaled to a mean triangle area of 1; and the length of their new unit.

    xatlas treats areas below 1e-7 as 0, and float32 is most precise near 0.
    """
    unit = math.sqrt(float(surface_areas(corners).mean()))
    middle = (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2
    return (corners - middle) / unit, unit


def _shading_vertices(vertex: Ints, normal: Floats, cosine: float) -> Ints:
    """Numbers of corners (3F,), equal for corners at the same position that no sharp edge separates.

    An edge is sharp if at one of its ends the normals of its two triangles differ by more than the angle
    whose cosine is given.
    """
    corner = np.arange(vertex.size).reshape(-1, 3)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    ends = np.sort(np.stack([vertex.ravel()[start], vertex.ravel()[end]], axis=1), axis=1)
    # Turn every half edge the same way, then put the halves of an edge side by side.
    turned = vertex.ravel()[start] > vertex.ravel()[end]
    start, end = np.where(turned, end, start), np.where(turned, start, end)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1) & (ends[order[1:], 0] != ends[order[1:], 1])
    one, other = order[:-1][same], order[1:][same]
    flat = normal.reshape(-1, 3)
    smooth: Bools = np.ones(len(one), dtype=bool)
    for side in (start, end):
        smooth &= np.sum(flat[side[one]] * flat[side[other]], axis=1) >= cosine
    pairs = [np.stack([side[one][smooth], side[other][smooth]], axis=1) for side in (start, end)]
    return components(np.concatenate(pairs), vertex.size)


def _chart_options(options: UnwrapOptions, triangles: int, iterations: int) -> Options:
    return {
        "max_cost": options.max_cost,
        "normal_deviation_weight": options.normal_deviation_weight,
        "roundness_weight": options.roundness_weight,
        "straightness_weight": options.straightness_weight,
        "normal_seam_weight": _RESPECTED,
        "max_chart_area": (options.max_island_share or 0.0) * triangles,  # the mean triangle has area 1
        "max_iterations": iterations,
    }


def _islands(uv: Floats, island: Ints, corners: Floats, vertex: Ints) -> FlatIslands:
    """Take triangles without area out of islands, number islands without gaps, and measure their borders."""
    area = np.abs(signed_areas(uv))
    real = (island >= 0) & (area > _THIN * area.mean())
    numbered = np.full(len(island), -1)
    numbered[real] = np.unique(island[real], return_inverse=True)[1].reshape(-1)
    return FlatIslands(uv, numbered, _border(corners[real], vertex[real], numbered[real]))


def _border(corners: Floats, vertex: Ints, island: Ints) -> float:
    """Length on the surface of all edges that have a triangle of their island on one side only."""
    following = np.roll(vertex, -1, axis=1)
    edges = np.stack([np.minimum(vertex, following), np.maximum(vertex, following)], axis=-1).reshape(-1, 2)
    label = weld(np.column_stack([edges, np.repeat(island, 3)]))
    length = np.sqrt(np.sum((np.roll(corners, -1, axis=1) - corners) ** 2, axis=-1)).ravel()
    return float(length[np.bincount(label)[label] == 1].sum())


def _smart_project(corners: Floats, vertex: Ints, angle: float) -> Floats:
    """Run Blender's Smart UV Project on a temporary mesh in a temporary scene: (F, 3, 2)."""
    _, first, face = np.unique(vertex, return_index=True, return_inverse=True)
    mesh = bpy.data.meshes.new("RadTex unwrap")
    mesh.from_pydata(corners.reshape(-1, 3)[first], [], face.reshape(-1, 3))
    mesh.polygons.foreach_set("select", np.ones(len(vertex), dtype=bool))
    mesh.uv_layers.new(name="UV")
    item = bpy.data.objects.new("RadTex unwrap", mesh)
    scene = bpy.data.scenes.new("RadTex unwrap")
    try:
        scene.collection.objects.link(item)
        layer = scene.view_layers[0]
        layer.update()
        layer.objects.active = item
        item.select_set(True, view_layer=layer)
        with cast("Any", bpy.context).temp_override(  # in the stubs of 5.2 it is no context manager
            scene=scene, view_layer=layer, active_object=item, object=item, edit_object=item
        ):
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.uv.smart_project(angle_limit=angle, island_margin=0.0)
            bpy.ops.object.mode_set(mode="OBJECT")
        uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
        mesh.uv_layers[0].data.foreach_get("uv", uv)
        return uv.reshape(-1, 3, 2).astype(np.float64)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.meshes.remove(mesh)
