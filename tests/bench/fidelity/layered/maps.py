# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface looks like before any light falls on it: colours, normals, alpha; one ray a texel."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.spec import Kind
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.passes import attributes_of, colour_of, light_of
from radtex_addon.cycles.path_ends import path_ends
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.cycles.sampling import _straight, _tiles
from radtex_addon.cycles.settings import first_hit_only
from radtex_addon.scene.others import Beside

from ..surface_alone import Clear
from .own_rays import dark_world

_COLOURS = ("diffuse", "glossy")


def capture_maps(scene: bpy.types.Scene, plan: CapturePlan, seed: int, folder: Path) -> dict[str, Floats]:
    """The colours "diffuse" and "glossy" along the normal, and the shading "normal" in world space.

    Of a plan of one cell a bucket, each (H, W, 3), gutter filled. Raises BakeError where Cycles fails.
    """
    wanted = [attribute for name in (*_COLOURS, "normal") for attribute in attributes_of(name)]
    capture = PortalCapture(
        scene, plan, Kind.RADIANCE, 1, seed, folder, Aim(_straight(len(plan.texel)), tuple(wanted))
    )
    first_hit_only(scene)
    found: dict[str, list[Floats]] = {name: [] for name in (*_COLOURS, "normal")}
    for tile in _tiles(plan):
        passes = capture.render_passes(tile)
        for name in _COLOURS:
            found[name].append(colour_of(passes, name).reshape(-1, 3))
        found["normal"].append(light_of(passes, "normal").reshape(-1, 3))
    return {name: plan.placed(np.concatenate(parts), gutter=True) for name, parts in found.items()}


def capture_alpha(
    scene: bpy.types.Scene,
    baked: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix: Floats,
    clear: Clear,
    plan: CapturePlan,
    seed: int,
    folder: Path,
) -> Floats:
    """How much a surface hides of what is behind it, along the normal, of a plan of one cell: (K,).

    `mesh` has materials as in `surface_alone`, which gave those that are `clear`. Of coloured transparency
    it is the mean over the channels. Raises BakeError where Cycles fails.
    """
    aim = Aim(_straight(len(plan.texel)))
    with path_ends(scene, baked, mesh, Beside(matrix, ()), np.zeros(3, np.float32)) as ends:
        own = cast(Any, ends)._baked
        for index, material in enumerate(mesh.materials):
            if material is not None and material in clear:
                own.data.materials[index] = clear[material]
        ends.scene.world = dark_world()
        capture = PortalCapture(ends.scene, plan, Kind.RADIANCE, 1, seed, folder, aim)
        first_hit_only(ends.scene)
        through = [capture.render_passes(tile).raw_whole[..., :3].reshape(-1, 3) for tile in _tiles(plan)]
    alpha: Floats = 1 - np.clip(np.concatenate(through).mean(axis=1), 0, 1)
    return alpha.astype(np.float32)
