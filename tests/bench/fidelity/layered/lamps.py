# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps that an object mirrors: a picture of them alone, from its middle."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.spec import Kind
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import fallback_tangent, orthonormal_frame
from radtex_addon.core.octahedron import cell_directions
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.cycles.sampling import _straight, _tiles

from .environment import Lamp, lamps_of
from .own_rays import dark_world

_SIZE = 1024  # cells along a side of the picture


def find_lamps(scene: bpy.types.Scene, middle: Floats, folder: Path) -> tuple[Lamp, ...]:
    """The lamps of a scratch scene, which is spent, as they are seen from `middle` (3,); suns are left out.

    Raises BakeError where Cycles fails.
    """
    lamps = [item for item in scene.objects if item.type == "LIGHT" and not item.hide_render]
    lamps = [item for item in lamps if getattr(item.data, "type", "") != "SUN"]
    if not lamps:
        return ()
    for collection in list(scene.collection.children):
        scene.collection.children.unlink(collection)
    for item in list(scene.collection.objects):
        scene.collection.objects.unlink(item)
    for item in lamps:
        scene.collection.objects.link(item)
    scene.world = dark_world()
    direction, plan = _outward(middle)
    capture = PortalCapture(scene, plan, Kind.REFLECTION, 1, 1, folder, Aim(_straight(len(plan.texel))))
    found = [capture.render_passes(tile).whole[..., :3].reshape(-1, 3) for tile in _tiles(plan)]
    places = [np.array(item.matrix_world)[:3, 3] - middle for item in lamps]
    return lamps_of(direction, np.concatenate(found), places)


def _outward(middle: Floats) -> tuple[Floats, CapturePlan]:
    """The directions of an octahedral picture's cells (P, 3), and a plan of one ray from `middle` in each."""
    direction = cell_directions(_SIZE).astype(np.float32)
    tangent, bitangent, normal = orthonormal_frame(
        direction, fallback_tangent(direction), np.ones(len(direction))
    )
    start = np.broadcast_to(middle, direction.shape)
    fields = (start, tangent, bitangent, normal, normal)
    packed = [np.array(field, dtype=np.float32).reshape(_SIZE, _SIZE, 3) for field in fields]
    return direction, CapturePlan(AtlasLayout(_SIZE, _SIZE, 1), np.arange(_SIZE * _SIZE), *packed)
