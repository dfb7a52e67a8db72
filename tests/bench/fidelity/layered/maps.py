# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface looks like before any light falls on it: colours and normals, one ray a texel."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.spec import Kind
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.passes import attributes_of, colour_of, light_of
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.cycles.sampling import _straight, _tiles
from radtex_addon.cycles.settings import first_hit_only

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
