# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flatten a surface into islands, to scale: by uvunwrap, by xatlas, or by Blender's Smart UV Project.

Vertices are welded by position first, so that doubled vertices do not tear islands apart. No island has
triangles of two materials: a texel on the border would mix them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...bake.progress import Progress, Steps, finished, in_a_thread, relayed
from ...core.arrays import Bools, Floats, Ints, blocks, ranks
from ...core.frame import normalised
from ...core.islands import (
    components,
    first_and_index,
    signed_areas,
    split_corners,
    surface_areas,
    uv_islands,
    weld,
)
from ...core.surface import Edges, edge_keys, inner_edges, stretches
from ..uv import uvunwrap_job
from ..uv.flatten_in_parts import ALL_FLAT, flatten_in_parts
from ..uv.unwrap_options import UnwrapOptions
from ..uv.uvunwrap_job import FLATTENED, unwrap_progress
from ..uv.xatlas_process import Options, XatlasProcess
from .blender_unwrap import Way, unwrapped_by_blender
from .cut_islands import cut_once
from .evaluated import EvaluatedMesh
from .merge_islands import Seamed, merged

_THIN = 1e-6  # times the mean area: triangles with less area belong to no island
_FINE = 2048  # texels of the atlas in which xatlas returns islands; it rounds their sizes to texels
_HANDOVER: Options = {"resolution": _FINE, "rotate_charts": False}
_RESPECTED = 1000.0  # from this weight on xatlas never grows an island across an edge with two normals


@dataclass(frozen=True, eq=False)
class FlatIslands:
    """Triangles flattened to scale: `uv` (F, 3, 2) in scene units, `island` (F,), -1 if without area.

    Islands may overlap. `border` is the total length of their borders on the surface, in scene units, and
    `resolved` the surface's area, in which that of triangles that are squeezed along some direction counts
    less: by the square of how much.
    """

    uv: Floats
    island: Ints
    border: float
    resolved: float

    @property
    def count(self) -> int:
        """The number of islands."""
        return int(self.island.max(initial=-1)) + 1

    @property
    def area(self) -> float:
        """The islands' area in square scene units."""
        return float(np.abs(signed_areas(self.uv[self.island >= 0])).sum())

    def interior(self, density: float) -> float:
        """About how many texels show the surface as it is, of so many texels per scene unit.

        Of many texels those within a texel of a border, on both sides of it, do not count, as a seam shows
        there; of few a share remains, or sparse islands would be the best.
        """
        shown, seams = self.resolved * density**2, 2 * self.border * density
        return shown**2 / max(shown + seams, 1e-30)

    @property
    def unit(self) -> float:
        """Side of a square as large as the mean triangle."""
        return math.sqrt(self.area / max(int(np.count_nonzero(self.island >= 0)), 1))


def flatten_with_xatlas(
    xatlas: XatlasProcess, evaluated: EvaluatedMesh, options: UnwrapOptions, iterations: int
) -> Steps[FlatIslands]:
    """Flatten by xatlas, in world space to include the object's scale and stretch. Yields progress."""
    corners, vertex = _world_corners(evaluated)
    middle, unit = _centre(corners)
    shading = smooth_corners(evaluated, options)
    first, _ = first_and_index(shading)
    normals = np.zeros((len(first), 3))
    np.add.at(normals, shading, evaluated.world_normal.reshape(-1, 3))
    charts = yield from xatlas.flatten(
        ((corners.reshape(-1, 3)[first] - middle) / unit).astype(np.float32),
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
    by_material = island * (int(evaluated.material_index.max()) + 1) + evaluated.material_index
    return _islands(flat, np.where(island < charts.count, by_material, -1), corners, vertex)


@dataclass(frozen=True, eq=False)
class _Shape:
    """A mesh in world space, its mean triangle of area 1 where `unit` is 1: points (V, 3), triangles (F, 3).

    `smooth` (E,) marks those of its inner `edges` that an island may cross.
    """

    points: Floats
    triangles: Ints
    unit: float
    edges: Edges
    smooth: Bools

    @classmethod
    def of(cls, evaluated: EvaluatedMesh, options: UnwrapOptions) -> _Shape:
        corners, vertex = _world_corners(evaluated)
        middle, unit = _centre(corners)
        first, index = first_and_index(vertex)
        points = (corners.reshape(-1, 3)[first] - middle) / unit
        edges = inner_edges(vertex)
        smooth = _smooth(edges, evaluated, math.cos(math.radians(options.seam_angle)))
        return cls(points, index.reshape(-1, 3), unit, edges, smooth)


def flatten_with_uvunwrap(evaluated: EvaluatedMesh, options: UnwrapOptions) -> Steps[FlatIslands]:
    """Flatten by uvunwrap, in world space. Yields progress."""
    shape = yield from in_a_thread(lambda: _Shape.of(evaluated, options), unwrap_progress(0))
    seams = _seams(shape.edges, ~shape.smooth, len(shape.triangles))
    charts = yield from flatten_in_parts(shape.points, shape.triangles, seams)
    uv, unit = charts.uv, shape.unit
    del shape, seams  # of large meshes, hundreds of megabytes
    uv *= unit
    corners, vertex = yield from in_a_thread(lambda: _world_corners(evaluated), _measured(0))
    return (yield from _island_steps(uv, charts.owner, corners, vertex))


def merge_flat(
    evaluated: EvaluatedMesh, flat: FlatIslands, texel: float, options: UnwrapOptions
) -> Steps[list[FlatIslands]]:
    """Merge islands where that is worth it: the islands after each round. Yields progress.

    A `texel` will be about so wide on the surface, in scene units.
    """
    rounds = options.rounds_of_merging(len(evaluated.triangles))
    if not rounds:
        return []
    shape = _Shape.of(evaluated, options)
    starts, ends = shape.edges.starts[shape.smooth], shape.edges.ends[shape.smooth]
    place = shape.points[shape.triangles.ravel()]
    along = place[ends[:, 0]] - place[starts[:, 0]]
    length = np.linalg.norm(along, axis=1)
    seamed = Seamed(shape.points, shape.triangles, starts // 3, length, texel / shape.unit)
    merging = merged(seamed, flat.uv / shape.unit, flat.island, rounds)
    found = yield from relayed(merging, uvunwrap_job.merge_progress)
    return [islands_of(evaluated, uv * shape.unit, island) for uv, island in found]


def smooth_corners(evaluated: EvaluatedMesh, options: UnwrapOptions) -> Ints:
    """Numbers of corners (3F,), equal for those at one place between which an island may go on."""
    shape = _Shape.of(evaluated, options)
    edges, smooth = shape.edges, shape.smooth
    return components(np.concatenate([edges.starts[smooth], edges.ends[smooth]]), shape.triangles.size)


def islands_of(evaluated: EvaluatedMesh, uv: Floats, island: Ints) -> FlatIslands:
    """The islands of a layout `uv` (F, 3, 2) that is to scale, of numbers (F,) that may have gaps."""
    return _islands(uv, island, *_world_corners(evaluated))


def cut_flat(evaluated: EvaluatedMesh, flat: FlatIslands) -> FlatIslands | None:
    """Cut islands that pack badly; None if there are none."""
    island = cut_once(_world_corners(evaluated)[1], flat.uv, flat.island)
    return None if island is None else islands_of(evaluated, flat.uv, island)


def _seams(edges: Edges, cut: Bools, count: int) -> Bools:
    """Marks (F, 3) of the edges, from corner k to k + 1, that are `cut` (E,)."""
    marks = np.zeros(3 * count, dtype=bool)
    for column in (0, 1):
        start, end = edges.starts[cut, column], edges.ends[cut, column]
        marks[np.where((start + 1 - end) % 3 == 0, start, end)] = True  # an edge may run either way
    return marks.reshape(-1, 3)


def flatten_with_blender(evaluated: EvaluatedMesh, options: UnwrapOptions) -> FlatIslands:
    """Flatten by Smart UV Project, and scale each island to its area on the surface."""
    corners, vertex = _world_corners(evaluated)
    # Blender hangs on faces that have a vertex twice.
    whole = (vertex != np.roll(vertex, 1, axis=1)).all(axis=1)
    uv = np.zeros((len(vertex), 3, 2))
    island = np.full(len(vertex), -1)
    number = split_corners(vertex, evaluated.material_index)[whole]
    first, index = first_and_index(number)
    middle, unit = _centre(corners)
    points = (corners[whole].reshape(-1, 3)[first] - middle) / unit
    angle = math.radians(options.blender_angle)
    uv[whole] = unwrapped_by_blender(points, index.reshape(-1, 3), Way.PROJECT, angle)
    island[whole] = uv_islands(number, uv[whole])
    space = np.bincount(island[whole], surface_areas(corners[whole]))
    texture = np.bincount(island[whole], np.abs(signed_areas(uv[whole])))
    scale = np.sqrt(np.divide(space, texture, out=np.zeros_like(space), where=texture > 0))
    return _islands(uv * scale[island][:, None, None], island, corners, vertex)


def _world_corners(evaluated: EvaluatedMesh) -> tuple[Floats, Ints]:
    """Corner positions in world space (F, 3, 3), and numbers (F, 3) that are equal for equal positions."""
    vertex = weld(evaluated.position)[evaluated.triangles]
    return evaluated.world_position[evaluated.triangles], vertex


def _centre(corners: Floats) -> tuple[Floats, float]:
    """The middle (3,) of corners (F, 3, 3), and the side of a square as large as the mean triangle.

    Unwrappers get points from there in that unit: xatlas treats areas below 1e-7 as 0, and float32 is most
    precise near 0.
    """
    unit = math.sqrt(float(surface_areas(corners).mean()))
    return (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2, unit


def _smooth(edges: Edges, evaluated: EvaluatedMesh, cosine: float) -> Bools:
    """Which edges (E,) an island may cross: they have one material, and no sharp bend.

    An edge is sharp if at one of its ends the normals of its two triangles differ by more than the angle
    whose cosine is given.
    """
    sides = edges.starts // 3
    smooth: Bools = (evaluated.material_index[sides[:, 0]] == evaluated.material_index[sides[:, 1]]).copy()
    flat = evaluated.world_normal.reshape(-1, 3)
    for corners in (edges.starts, edges.ends):
        for some in blocks(len(corners)):
            one, other = corners[some].T
            smooth[some] &= np.sum(flat[one] * flat[other], axis=1) >= cosine
    return smooth


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
    """Take triangles without area out of islands, number islands without gaps, and measure their borders.

    What hangs together by a corner alone becomes two islands.
    """
    return finished(_island_steps(uv, island, corners, vertex))


def _island_steps(uv: Floats, island: Ints, corners: Floats, vertex: Ints) -> Steps[FlatIslands]:
    """`_islands`, with progress."""
    area = np.abs(signed_areas(uv))
    real = (island >= 0) & (area > _THIN * area.mean())
    some: Bools | slice = slice(None) if real.all() else real  # a view
    numbered = np.full(len(island), -1)
    edges = yield from in_a_thread(
        lambda: inner_edges(split_corners(vertex[some], island[some])), _measured(0.2)
    )
    numbered[some] = yield from in_a_thread(
        lambda: components(edges.starts // 3, int(np.count_nonzero(real))), _measured(0.5)
    )
    resolved = yield from in_a_thread(lambda: _resolved(corners[some], uv[some]), _measured(0.6))
    border = yield from in_a_thread(
        lambda: _border(corners[some], vertex[some], numbered[some]), _measured(0.7)
    )
    return FlatIslands(uv, numbered, border, resolved)


def _measured(share: float) -> Progress:
    """Progress of the unwrap while islands that are flat are measured."""
    return unwrap_progress(FLATTENED * (ALL_FLAT + (1 - ALL_FLAT) * share))


def _resolved(corners: Floats, uv: Floats) -> float:
    """`FlatIslands.resolved` of triangles."""
    least = stretches(corners, uv)[:, 1]
    return float(np.sum(surface_areas(corners) * np.minimum(least, 1) ** 2))


def _border(corners: Floats, vertex: Ints, island: Ints) -> float:
    """Length on the surface of all edges that have a triangle of their island on one side only."""
    keys = ranks(edge_keys(vertex)).astype(np.uint64) << np.uint64(32)
    keys |= np.repeat(island.astype(np.uint64), 3)
    label = ranks(keys)
    start = np.flatnonzero(np.bincount(label)[label] == 1)
    end = start + np.where(start % 3 == 2, -2, 1)
    place = corners.reshape(-1, 3)
    return float(np.sqrt(np.sum((place[end] - place[start]) ** 2, axis=-1)).sum())
