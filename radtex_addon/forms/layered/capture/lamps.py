# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps that an object mirrors: a picture of them alone, from its middle.

Lamps too small for its cells, which Cycles shows in highlights all the same, are enlarged for the picture: by
their size alone, which does not change how much light they send.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.plan import MIN_IMAGE_SIDE, CapturePlan
from ....core.arrays import Bools, Floats, Ints
from ....core.atlas import AtlasLayout
from ....core.frame import fallback_tangent, orthonormal_frame
from ....core.hemisphere import mirror_direction, square_to_direction
from ....core.octahedron import cell_directions
from ....cycles.path_ends import place_exactly
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import straight_shifts, tiles_of
from ....scene.lights.lamps import is_negative, refuse_negative
from ....scene.lights.linking import lights
from ....scene.mesh.mesh_checks import FARTHEST
from ....scene.mesh.render_contents import Shown, read_render
from ....scene.regroup import regroup
from ....settings.spec import Kind
from ..lookup.environment import MOST_LAMPS, Lamp, lamps_of
from ..lookup.lamp_shapes import LampShape, ShapeKind
from .hidden_lamps import HideableLamp, hidden_lamps
from .own_rays import dark_world
from .room import Room

log = logging.getLogger(__name__)

_SIZE = 1024  # cells along a side of the picture
_CELLS = 4.0  # that a lamp's radius covers in it, at least
_CORNER = math.sqrt(2)  # times half a lamp's side: how far its corners are from its middle
_BORDER = 4  # cells beside a lamp that are traced, too
_FAR = 1e4  # where a sun is
_THROUGH_WINDOWS = 0.995  # most of a room's points that a lamp outside may be hidden from
_NEAREST = 1e-4  # to the middle
_WIDEST = 1.5  # half of a sun's angle, of which there is a tangent
_BESIDE = 1.5  # times a lamp's radius: nearer to it than that, the middle does not see it from outside


@dataclass(frozen=True, eq=False)
class LampShown:
    """A lamp as renders show it: the `item`, and its `matrix` (4, 4) from lamp to world."""

    item: bpy.types.Object
    matrix: Floats

    @property
    def data(self) -> Any:
        return self.item.data

    @property
    def sides(self) -> dict[str, float]:
        """Its diameters by the properties that say them, a sun's in radians at a distance of 1."""
        data = self.data
        if data.type == "SUN":
            return {"angle": 2 * _FAR * math.tan(min(data.angle / 2, _WIDEST))}
        if data.type == "AREA":
            other = ("size_y",) if data.shape in ("RECTANGLE", "ELLIPSE") else ()
            return {name: float(getattr(data, name)) for name in ("size", *other)}
        return {"shadow_soft_size": 2.0 * data.shadow_soft_size}

    @property
    def stretch(self) -> float:
        """How many times as large the lamp's matrix makes it: only an area is stretched."""
        if self.data.type != "AREA":
            return 1.0
        return float(np.linalg.norm(self.matrix[:3, :2], axis=0).max())

    @property
    def diameter(self) -> float:
        return max(self.sides.values()) * self.stretch

    def shape(self, area: float) -> LampShape:
        """As large as `area` says, the part of what a picture of it shows."""
        if self.data.type != "AREA":
            radius = np.array([self.diameter / 2, 0, 0], dtype=np.float32)
            return LampShape(ShapeKind.BALL, radius, np.zeros(3, dtype=np.float32), area)
        sides = list(self.sides.values())
        across, up = (self.matrix[:3, 0] * sides[0] / 2, self.matrix[:3, 1] * sides[-1] / 2)
        if np.cross(across, up) @ self.matrix[:3, 2] < 0:  # it shines along its -Z, also where it is mirrored
            up = -up
        kind = ShapeKind.DISC if self.data.shape in ("DISK", "ELLIPSE") else ShapeKind.RECTANGLE
        return LampShape(kind, across.astype(np.float32), up.astype(np.float32), area)

    def towards(self, middle: Floats) -> Floats:
        """From the middle to the lamp, (3,); a sun is far away."""
        if self.data.type == "SUN":
            axis: Floats = self.matrix[:3, 2] / np.linalg.norm(self.matrix[:3, 2])
            return axis * _FAR
        place: Floats = self.matrix[:3, 3] - middle
        return place


def lamps_shown(scene: bpy.types.Scene, receivers: Sequence[bpy.types.Object]) -> tuple[LampShown, ...]:
    """The lamps that a scratch scene renders, instanced ones included, that light all of the `receivers`.

    What a lamp lights but in part, by light linking, is left to the rest of the light, and so are lamps that
    take light away, are portals, have no area or are nowhere. Raises BakeError where Blender does not render.
    """

    def read(shown: Iterator[Shown]) -> list[LampShown]:
        return [
            LampShown(one.original, one.matrix)
            for one in shown
            if one.evaluated.type == "LIGHT" and "glossy" in one.seen_by and _power(one.evaluated.data) > 0
        ]

    lamps = [lamp for lamp in read_render(scene, read) if not _is_lost(lamp)]
    return tuple(lamp for lamp in lamps if all(lights(lamp.item, one) for one in receivers))


def refuse_negative_lamps(scene: bpy.types.Scene) -> None:
    """Raise InputError if a scratch scene renders a lamp that takes light away, be it by a driver."""
    if not any(is_negative(data) or data.animation_data for data in bpy.data.lights):
        return
    read_render(
        scene,
        lambda shown: refuse_negative(
            (one.original.name, one.evaluated.data) for one in shown if one.evaluated.type == "LIGHT"
        ),
    )


def find_lamps(
    scene: bpy.types.Scene,
    receivers: Sequence[bpy.types.Object],
    plan: CapturePlan,
    middle: Floats,
    folder: Path,
    room: Room | None = None,
) -> tuple[Lamp, ...]:
    """The lamps of a scratch scene, which is spent, that its baked `receivers` mirror, from `middle` (3,).

    Those that are hidden from most of the `plan`'s points are none. In a `room` only points inside count,
    and baked walls hide lamps, too; one that is outside need be seen from few, and is mirrored where the
    walls are open. One that the middle lies in is left out, and named in a warning. Of more than shaders
    mirror, those that give most light are taken; the others' highlights are in what is left of the light, as
    blurs. Raises BakeError where Cycles fails.
    """
    lamps = [lamp for lamp in lamps_shown(scene, receivers) if _is_apart(lamp, middle)]
    targets = [HideableLamp(lamp.item, middle + lamp.towards(middle), lamp.diameter / 2) for lamp in lamps]
    if not lamps:
        return ()
    points, normals = plan.points, plan.normal.reshape(-1, 3)[: len(plan.texel)]
    between, behind = set(receivers), [False] * len(lamps)
    if room is not None:
        inside = room.holds(points)
        points, normals = points[inside], normals[inside]
        between -= room.shown
        behind = [not room.holds(target.place[None])[0] for target in targets]
    hidden = hidden_lamps(scene, between, points, normals, targets)
    kept = np.flatnonzero(hidden <= np.where(behind, _THROUGH_WINDOWS, 0.5))
    lamps, behind = [lamps[number] for number in kept], [behind[number] for number in kept]
    if not lamps:
        return ()
    anchor = cast(bpy.types.Object, bpy.data.objects.new("RadTex anchor", None))
    shown, shares, areas, radii = zip(*(_alone(lamp, anchor, middle) for lamp in lamps), strict=True)
    direction = cell_directions(_SIZE).astype(np.float32)
    copies = [LampShown(copy, lamp.matrix) for copy, lamp in zip(shown, lamps, strict=True)]
    some = np.flatnonzero(np.any([_may_see(direction, copy, middle) for copy in copies], axis=0))
    if not len(some):
        return ()
    regroup(scene, {"RadTex lamps": shown})
    scene.world = dark_world()
    picture, aim = _outward(middle, direction, some)
    capture = PortalCapture(scene, picture, Kind.REFLECTION, 1, 1, folder, aim)
    found = [capture.render_passes(tile).whole[..., :3].reshape(-1, 3) for tile in tiles_of(picture)]
    radiance = np.zeros((len(direction), 3), dtype=np.float32)
    radiance[some] = np.concatenate(found)
    towards = [lamp.towards(middle) for lamp in lamps]
    shapes = [lamp.shape(area) for lamp, area in zip(lamps, areas, strict=True)]
    return brightest(lamps_of(direction, radiance, towards, shares, behind, shapes, radii))


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


def _is_apart(lamp: LampShown, middle: Floats) -> bool:
    """Whether the middle lies outside the lamp; says so if not."""
    distance = float(np.linalg.norm(lamp.towards(middle)))
    if distance > max(_BESIDE * lamp.diameter / 2, _NEAREST):
        return True
    log.warning(
        "lamp '%s' stands in the middle of the object: what it mirrors of it is dull; move the lamp, or "
        "make it smaller",
        lamp.item.name,
    )
    return False


def _is_lost(lamp: LampShown) -> bool:
    """Whether a lamp sends no light: a portal, one without area, or one that is nowhere, which is said."""
    if not (np.abs(lamp.matrix) < FARTHEST).all():
        log.warning("lamp '%s' is nowhere, or too far away: nothing mirrors it", lamp.item.name)
        return True
    if lamp.data.type != "AREA":
        return False
    return bool(lamp.data.cycles.is_portal or min(lamp.sides.values()) * lamp.stretch <= 0)


def _power(data: Any) -> float:
    """A lamp's power in its brightest channel."""
    return float(data.energy * max(data.color))


def _alone(
    lamp: LampShown, anchor: bpy.types.Object, middle: Floats
) -> tuple[bpy.types.Object, float, float, float]:
    """A copy of a lamp as the picture shows it, the lamp's width² and area over the copy's, and its radius.

    That is in radians, as seen from the middle. The copy lights all, stands where renders have the lamp, and
    is as large as the picture needs.
    """
    copy = cast(bpy.types.Object, lamp.item.copy())
    copy.animation_data_clear()
    copy.constraints.clear()
    cast(Any, copy).light_linking.receiver_collection = None
    cast(Any, copy).light_linking.blocker_collection = None
    place_exactly(copy, anchor, lamp.matrix)
    data: Any = cast(bpy.types.ID, lamp.data).copy()
    copy.data = data
    data.cycles.use_multiple_importance_sampling = True  # or it is in highlights, but no ray meets it
    distance = float(np.linalg.norm(lamp.towards(middle)))
    least = 2 * _CELLS * math.sqrt(4 * math.pi) / _SIZE * distance / max(lamp.stretch, _NEAREST)
    sides = lamp.sides
    larger = {name: max(side, least) for name, side in sides.items()}
    radius = math.atan2(max(larger.values()) * lamp.stretch / 2, distance)
    if larger == sides:
        return copy, 1.0, 1.0, radius
    for name, side in larger.items():
        unit = {"angle": _FAR, "shadow_soft_size": 2.0}.get(name, 1.0)
        setattr(data, name, side / unit)
    area, enlarged = (math.prod((list(found.values()) * 2)[:2]) for found in (sides, larger))
    if not getattr(data, "normalize", True):  # it sends as much from each part of it, of which there are more
        data.energy *= area / enlarged
    squares = [sum(side**2 for side in found.values()) for found in (sides, larger)]
    return copy, squares[0] / squares[1], area / enlarged, radius


def _may_see(direction: Floats, lamp: LampShown, middle: Floats) -> Bools:
    """Which rays from the middle in unit directions (P, 3) may meet a lamp, and a few beside it: (P,)."""
    towards = lamp.towards(middle)
    distance = float(np.linalg.norm(towards))
    around = _CORNER * lamp.diameter / 2
    if around >= distance:
        return np.ones(len(direction), dtype=bool)
    angle = math.asin(around / distance) + _BORDER * math.sqrt(4 * math.pi) / _SIZE
    found: Bools = direction @ (towards / distance).astype(np.float32) >= math.cos(min(angle, math.pi))
    return found


def _outward(middle: Floats, direction: Floats, some: Ints) -> tuple[CapturePlan, Aim]:
    """A plan of one ray from `middle` in each of `some` (K,) of an octahedral picture's cells, and its aim.

    Rays go through the cells' middles, `direction` (P, 3). No ray is aimed along its normal, so normals are
    turned away from these.
    """
    aim = Aim(straight_shifts(len(some)))
    side = max(MIN_IMAGE_SIDE, math.isqrt(len(some) - 1) + 1)
    padded = some[np.minimum(np.arange(side * side), len(some) - 1)]
    ahead = direction[padded].astype(np.float64)
    along = mirror_direction(square_to_direction(aim.square(1)[0].astype(np.float64)))  # in a frame
    turn = np.stack(orthonormal_frame(along, fallback_tangent(along), np.ones(1)), axis=1)[0]
    frame = np.stack(orthonormal_frame(ahead, fallback_tangent(ahead), np.ones(len(ahead))), axis=1)
    fields = [np.broadcast_to(middle, ahead.shape), *(turn.T @ frame).transpose(1, 0, 2), ahead]
    packed = [np.array(field, dtype=np.float32).reshape(side, side, 3) for field in fields]
    return CapturePlan(AtlasLayout(_SIZE, _SIZE, 1), some, *packed), aim
