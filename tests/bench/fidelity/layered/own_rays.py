# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where mirror rays meet the object itself: asked of an object that sends out its own position."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.gloss import LobeSamples
from radtex_addon.bake.light_samples import spread_shifts
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.spec import Kind
from radtex_addon.core.arrays import Floats
from radtex_addon.core.shared import Axis
from radtex_addon.cycles.building_blocks import float_image
from radtex_addon.cycles.path_ends import path_ends
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.cycles.sampling import _tiles
from radtex_addon.scene.mesh.surrounding_shapes import Beside
from radtex_addon.scene.nodes import open_material, open_world

from .own_light import OwnRays

_AHEAD = 5  # of the bake's seed


def capture_own_rays(
    scene: bpy.types.Scene,
    baked: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix: Floats,
    plan: CapturePlan,
    seed: int,
    folder: Path,
    alpha: Floats | None = None,
    uv_layer: str = "",
) -> OwnRays:
    """One mirror ray in each of the plan's cells. Raises BakeError where Cycles fails.

    Where a map of `alpha` (H, W, 1), over the UV layer, says less than 1, so many rays go on.
    """
    lowest = plan.points.min(axis=0) - 1.0
    aim = Aim(spread_shifts(len(plan.texel), seed + _AHEAD))
    with path_ends(scene, baked, mesh, Beside(matrix, ()), np.zeros(3, np.float32)) as ends:
        own = cast(Any, ends)._baked
        own.data = _glowing(own.data, lowest - _size(plan), alpha, uv_layer)
        ends.scene.world = dark_world()
        capture = PortalCapture(ends.scene, plan, Kind.REFLECTION, 1, seed, folder, aim)
        count = plan.layout.bucket**2
        found = [
            capture.render_passes(tile).raw_whole[..., :3].reshape(-1, count, 3) for tile in _tiles(plan)
        ]
    coded = np.concatenate(found)
    hit = coded.min(axis=2) > 0.5
    place = np.where(hit[..., None], coded + (lowest - _size(plan)), 0).astype(np.float32)
    square = aim.square(plan.layout.bucket)
    values = np.zeros((*hit.shape, 3), dtype=np.float16)
    return OwnRays(LobeSamples(plan, Axis.MIRROR, square, values, np.ones(hit.shape, dtype=bool)), hit, place)


def _size(plan: CapturePlan) -> Floats:
    """How far positions may lie outside those of the texels, (3,)."""
    size: Floats = (plan.points.max(axis=0) - plan.points.min(axis=0)) * 0.1
    return size


def _glowing(mesh: bpy.types.Mesh, origin: Floats, alpha: Floats | None, uv_layer: str) -> bpy.types.Mesh:
    """The mesh, sending out its position less `origin` (3,), which is beyond it."""
    copy = cast(bpy.types.Mesh, cast(bpy.types.ID, mesh).copy())
    copy.materials.clear()
    material, build = open_material("RadTex position")
    place = build.vector("SUBTRACT", build.geometry("Position"), tuple(origin.tolist()))
    shader = build.node("ShaderNodeEmission", place, 1.0).outputs[0]
    if alpha is not None:
        image = float_image("RadTex alpha", np.repeat(alpha, 3, axis=2))
        share = build.image(image, build.uv_map(uv_layer), "Linear")[0]
        chance = build.node("ShaderNodeTexWhiteNoise", build.geometry("Position")).outputs["Value"]
        through = build.node("ShaderNodeBsdfTransparent").outputs[0]
        stops = build.math("GREATER_THAN", share, chance)
        shader = build.node("ShaderNodeMixShader", stops, through, shader).outputs[0]
    build.node("ShaderNodeOutputMaterial", shader)
    cast(Any, material).cycles.emission_sampling = "NONE"
    copy.materials.append(material)
    return copy


def dark_world() -> bpy.types.World:
    """A world that sends out no light."""
    world, build = open_world("RadTex dark")
    background = build.node("ShaderNodeBackground", (0.0, 0.0, 0.0, 1.0), 0.0)
    build.node("ShaderNodeOutputWorld", background.outputs[0])
    return world
