# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where mirror rays meet a source that is baked to a simpler object, and which texels show these places."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils.kdtree import KDTree

from ....bake.plan import CapturePlan
from ....core.arrays import Floats, Ints
from ....cycles.path_ends import Body, path_ends
from ....cycles.portal import PortalCapture
from ....cycles.sampling import tiles_of
from ....scene.nodes import open_material
from ....settings.kinds import Kind
from ..samples import OwnRays
from .own_rays import dark_world, light_along, own_aim, own_samples

_FACING = 0.3  # cosine between an axis and the normals of texels that places facing along it may be shown by
_FINER = 0.5  # times the distance between texels: places that are nearer to each other are looked up once
_FAR = 4.0  # times the distance between texels: places that are farther from all texels have none
_MARGIN, _MOST_CELLS = 1 << 10, 1 << 20  # cells along each axis in which places are looked up once
_CLEAR = 0.5  # alpha of a texel, below which rays go on there


def capture_source_rays(
    scene: bpy.types.Scene,
    bodies: Sequence[Body],
    plan: CapturePlan,
    everywhere: CapturePlan,
    alpha: Floats,
    seed: int,
    folder: Path,
) -> OwnRays:
    """One mirror ray in each of the plan's cells. Raises BakeError where Cycles fails.

    `everywhere` is a plan of all texels, with those that are cut out, and `alpha` (K,) is theirs. Where rays
    meet a place that no texel shows, a path is traced along each of them in `scene`.
    """
    aim = own_aim(plan, seed)
    low, size = _box(bodies)
    with path_ends(scene, bodies, (), np.zeros(3, np.float32)) as ends:
        material, normals = shows_place(low, size)
        for copy in ends.copies:
            mesh: Any = cast(bpy.types.ID, copy.data).copy()
            mesh.materials.clear()
            mesh.materials.append(material)
            copy.data = mesh
        ends.scene.world = dark_world()
        capture = PortalCapture(ends.scene, plan, Kind.REFLECTION, 1, seed, folder, aim)
        count = plan.layout.bucket**2
        hits, told = [], []
        for tile in tiles_of(plan):
            coded = []
            for shown in (1.0, 0.0):
                cast(Any, normals).outputs[0].default_value = shown
                coded.append(capture.render_passes(tile).raw_whole[..., :3].reshape(-1, count, 3))
            hits.append(coded[1].max(axis=-1) > 0.5)
            told.append(np.concatenate([part[hits[-1]] for part in coded], axis=1))
    hit, seen = np.concatenate(hits), np.concatenate(told)
    normal, place = seen[:, :3] - 2, ((seen[:, 3:] - 1) * size + low).astype(np.float32)
    there = _nearest(everywhere, place, normal)
    number = np.full(plan.layout.width * plan.layout.height, -1, dtype=np.int32)
    number[plan.texel] = np.arange(len(plan.texel), dtype=np.int32)
    met = np.where(there >= 0, number[everywhere.texel[there]], -1).astype(np.int32)
    solid = (there < 0) | (alpha[there] >= _CLEAR)
    hit[hit], met, place = solid, met[solid], place[solid]
    light = light_along(scene, plan, aim, hit, met < 0, seed, folder) if (met < 0).any() else None
    return OwnRays(own_samples(plan, aim, hit), hit, met, place, light)


def _nearest(plan: CapturePlan, place: Floats, normal: Floats) -> Ints:
    """The number (P,) of the texel of the plan nearest to each place (P, 3) that faces as it does, or -1.

    `normal` (P, 3) are those of the surface at these places. Nearby places that face alike have the same.
    """
    points, facing = plan.points.astype(np.float64), plan.normals
    gap = float(np.median(np.linalg.norm(np.diff(points, axis=0), axis=1))) if len(points) > 1 else 1.0
    gap = max(gap, 1e-6)
    axis = np.abs(normal).argmax(axis=1)
    side = 2 * axis + (np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] < 0)
    cell = np.clip((place - points.min(axis=0)) / (_FINER * gap) + _MARGIN, 0, _MOST_CELLS - 1)
    x, y, z = cell.astype(np.int64).T
    key = ((x * _MOST_CELLS + y) * _MOST_CELLS + z) * 6 + side
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    trees = [_tree(points, facing[:, number // 2] * (1 - 2 * (number % 2))) for number in range(6)]
    found = np.full(len(first), -1, dtype=np.int32)
    for each, index in enumerate(first.tolist()):
        tree = trees[int(side[index])]
        _, texel, distance = tree.find(place[index].tolist())
        if texel is not None and distance < _FAR * gap:
            found[each] = texel
    return found[which.reshape(-1)]


def _tree(points: Floats, cosine: Floats) -> Any:
    """A tree of those points (K, 3) whose texels face along an axis, by the cosine (K,) with it."""
    chosen = np.flatnonzero(cosine > _FACING)
    tree: Any = KDTree(len(chosen))
    for index in chosen.tolist():
        tree.insert(points[index].tolist(), index)
    tree.balance()
    return tree


def _box(bodies: Sequence[Body]) -> tuple[Floats, float]:
    """The lowest corner (3,) of the bodies' common box in world space, and its longest side."""
    every = np.concatenate([body.places for body in bodies])
    low: Floats = every.min(axis=0)
    return low, max(float(np.ptp(every, axis=0).max()), 1e-9)


def shows_place(low: Floats, size: float, normals: bool = True) -> tuple[bpy.types.Material, bpy.types.Node]:
    """A material that emits the place that is met, from `low` (3,), over `size`, plus 1.

    Also the node by whose value, 1, as it has with `normals`, it emits the normal there plus 2.
    """
    material, build = open_material("RadTex place")
    switch = build.node("ShaderNodeValue")
    cast(Any, switch).outputs[0].default_value = float(normals)
    away = build.vector("SUBTRACT", build.geometry("Position"), tuple(low.tolist()))
    place = build.vector("ADD", build.vector("SCALE", away, 1 / size), (1.0, 1.0, 1.0))
    side = build.math("MULTIPLY_ADD", build.geometry("Backfacing"), -2.0, 1.0)
    normal = build.vector("SCALE", build.geometry("True Normal"), side)
    shown = build.mix(switch.outputs[0], place, build.vector("ADD", normal, (2.0, 2.0, 2.0)))
    build.node("ShaderNodeOutputMaterial", build.node("ShaderNodeEmission", shown, 1.0).outputs[0])
    cast(Any, material).cycles.emission_sampling = "NONE"
    return material, switch
