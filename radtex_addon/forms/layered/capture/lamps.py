# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps that an object mirrors: a picture of them alone, from its middle.

Lamps too small for its cells, which Cycles shows in highlights all the same, are enlarged for the picture: by
their size alone, which does not change how much light they send.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.plan import CapturePlan
from ....bake.spec import Kind
from ....core.arrays import Floats
from ....core.atlas import AtlasLayout
from ....core.frame import fallback_tangent, orthonormal_frame
from ....core.octahedron import cell_directions
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import straight_shifts, tiles_of
from ..lookup.environment import MOST_LAMPS, Lamp, lamps_of
from .own_rays import dark_world

log = logging.getLogger(__name__)

_SIZE = 1024  # cells along a side of the picture
_CELLS = 4.0  # that a lamp's radius covers in it, at least
_FAR = 1e4  # where a sun is
_NEAREST = 1e-4  # to the middle
_BESIDE = 1.5  # times a lamp's radius: nearer to it than that, the middle does not see it from outside


def find_lamps(scene: bpy.types.Scene, middle: Floats, folder: Path) -> tuple[Lamp, ...]:
    """The lamps of a scratch scene, which is spent, as they are seen from `middle` (3,).

    One that the middle lies in is left out, and named in a warning. Of more than shaders mirror, those that
    give most light are taken; the others' highlights are in what is left of the light, as blurs.
    Raises BakeError where Cycles fails.
    """
    lamps = [item for item in scene.objects if item.type == "LIGHT" and not item.hide_render]
    lamps = [item for item in lamps if not _is_lost(item.data) and _is_apart(item, middle)]
    if not lamps:
        return ()
    for collection in list(scene.collection.children):
        scene.collection.children.unlink(collection)
    for item in list(scene.collection.objects):
        scene.collection.objects.unlink(item)
    shown, shares = zip(*(_enlarged(item, middle) for item in lamps), strict=True)
    for item in shown:
        scene.collection.objects.link(item)
    scene.world = dark_world()
    direction, plan = _outward(middle)
    capture = PortalCapture(scene, plan, Kind.REFLECTION, 1, 1, folder, Aim(straight_shifts(len(plan.texel))))
    found = [capture.render_passes(tile).whole[..., :3].reshape(-1, 3) for tile in tiles_of(plan)]
    return brightest(
        lamps_of(direction, np.concatenate(found), [_towards(item, middle) for item in lamps], shares)
    )


def brightest(lamps: Sequence[Lamp]) -> tuple[Lamp, ...]:
    """The lamps that give the middle most light, as many as shaders mirror; warns of the others."""
    ranked = sorted(lamps, key=lambda lamp: float(lamp.irradiance.sum()), reverse=True)
    if len(ranked) > MOST_LAMPS:
        log.warning(
            "%d lamps light the object: the %d that give most light are mirrored sharply, others as blurs; "
            "hide lamps that matter little, or make them glowing meshes",
            len(ranked),
            MOST_LAMPS,
        )
    kept = ranked[:MOST_LAMPS]
    return tuple(lamp for lamp in lamps if any(lamp is one for one in kept))


def _towards(item: bpy.types.Object, middle: Floats) -> Floats:
    """From the middle to a lamp, (3,); a sun is far away."""
    matrix = np.array(item.matrix_world)
    if cast(Any, item.data).type == "SUN":
        axis: Floats = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        return axis * _FAR
    place: Floats = matrix[:3, 3] - middle
    return place


def _is_apart(item: bpy.types.Object, middle: Floats) -> bool:
    """Whether the middle lies outside the lamp; says so if not."""
    distance = float(np.linalg.norm(_towards(item, middle)))
    if distance > max(_BESIDE * max(_sides(item.data).values()) / 2, _NEAREST):
        return True
    log.warning(
        "lamp '%s' stands in the middle of the object: what it mirrors of it is dull; move the lamp, or "
        "make it smaller",
        item.name,
    )
    return False


def _is_lost(data: Any) -> bool:
    """Whether a lamp has no area to send light from, and Cycles leaves it out."""
    return data.type == "AREA" and min(_sides(data).values()) <= 0


def _sides(data: Any) -> dict[str, float]:
    """A lamp's diameters by the properties that say them, a sun's in radians at a distance of 1."""
    if data.type == "SUN":
        return {"angle": _FAR * data.angle}
    if data.type == "AREA":
        other = ("size_y",) if data.shape in ("RECTANGLE", "ELLIPSE") else ()
        return {name: float(getattr(data, name)) for name in ("size", *other)}
    return {"shadow_soft_size": 2.0 * data.shadow_soft_size}


def _enlarged(item: bpy.types.Object, middle: Floats) -> tuple[bpy.types.Object, float]:
    """A lamp as the picture shows it, a copy if need be, and the lamp's width² over that one's."""
    least = 2 * _CELLS * math.sqrt(4 * math.pi) / _SIZE * float(np.linalg.norm(_towards(item, middle)))
    sides = _sides(item.data)
    larger = {name: max(side, least) for name, side in sides.items()}
    if larger == sides:
        return item, 1.0
    copy = cast(bpy.types.Object, item.copy())
    data: Any = cast(bpy.types.ID, item.data).copy()
    copy.data = data
    data.cycles.use_multiple_importance_sampling = True  # or it is in highlights, but no ray meets it
    for name, side in larger.items():
        unit = {"angle": _FAR, "shadow_soft_size": 2.0}.get(name, 1.0)
        setattr(data, name, side / unit)
    if not getattr(data, "normalize", True):  # it sends as much from each part of it, of which there are more
        both = [(list(found.values()) * 2)[:2] for found in (sides, larger)]
        data.energy *= math.prod(both[0]) / math.prod(both[1])
    squares = [sum(side**2 for side in found.values()) for found in (sides, larger)]
    return copy, squares[0] / squares[1]


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
