# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as artists have them: each function puts one into the open scene and returns it.

Four are stacks of modifiers, whose base mesh has UVs; the others are parts with hard edges, organic shapes,
foliage, cloth, type and a sculpt of half a million triangles.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any, cast

import bpy
import numpy as np

from tests.bench.fidelity.scenes.meshes import Points, gear, made, mesh_object, move_to, places

_OCTAVES = 5


def case() -> bpy.types.Object:
    """A radio's case: half of a box with insets, Mirror, Bevel and Subdivision, three materials."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    item = made()
    _half()
    _inset(item, (0, -1, 0), 0.25, -0.15, 1)
    _inset(item, (1, 0, 0), 0.3, -0.1, 2)
    _inset(item, (0, 0, 1), 0.3, 0.2, 1)
    item.scale = (1.4, 0.6, 1.0)
    _slots(item, "Painted", "Grille", "Knob")
    _unwrapped(item)
    _modifier(item, "MIRROR")
    bevel = _modifier(item, "BEVEL")
    bevel.width, bevel.segments, bevel.limit_method = 0.04, 2, "ANGLE"
    _modifier(item, "SUBSURF").render_levels = 3
    return _smooth(item)


def toy() -> bpy.types.Object:
    """Half a monkey, completed by Mirror, edges bevelled, Subdivision; painted in three materials."""
    bpy.ops.mesh.primitive_monkey_add()
    item = made()
    _half()
    _slots(item, "Paint", "Chrome", "Rubber")
    for face in cast(Any, item.data).polygons:
        face.material_index = 1 if face.center.z > 0.4 else 2 if face.center.y < -0.5 else 0
    _unwrapped(item)
    _modifier(item, "MIRROR")
    bevel = _modifier(item, "BEVEL")
    bevel.width, bevel.segments, bevel.limit_method = 0.02, 2, "ANGLE"
    _modifier(item, "SUBSURF").render_levels = 2
    return _smooth(item)


def bolts() -> bpy.types.Object:
    """A flange with a hole and six bolts, edges bevelled."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=1, depth=0.3)
    flange = made()
    bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=0.45, depth=1)
    hole = made()
    cutter: Any = _modifier(flange, "BOOLEAN")
    cutter.object, cutter.operation = hole, "DIFFERENCE"
    _apply(flange)
    bpy.data.objects.remove(hole)
    parts = [flange]
    for number in range(6):
        turn = number * pi / 3
        bpy.ops.mesh.primitive_cylinder_add(
            vertices=6, radius=0.13, depth=0.2, location=(0.72 * np.cos(turn), 0.72 * np.sin(turn), 0.24)
        )
        parts.append(made())
    _join(parts)
    _unwrapped(flange)
    bevel = _modifier(flange, "BEVEL")
    bevel.width, bevel.segments, bevel.limit_method = 0.02, 3, "ANGLE"
    return _smooth(flange)


def chair() -> bpy.types.Object:
    """A chair's frame and seat: Mirror, Solidify, Subdivision; loose parts that touch, two materials."""
    seat = mesh_object(
        "Seat",
        [(x, y, 0.02 * (x * x + y * y)) for y in np.linspace(-1, 1, 5) for x in np.linspace(0, 1, 3)],
        [(3 * j + i, 3 * j + i + 1, 3 * j + i + 4, 3 * j + i + 3) for j in range(4) for i in range(2)],
        smooth=True,
    )
    parts = [seat]
    for x, y, high in ((0.85, -0.85, 1.0), (0.85, 0.85, 2.2)):
        bpy.ops.mesh.primitive_cube_add(size=0.16, location=(x, y, high / 2 - 1))
        made().scale = (1, 1, high / 0.16)
        parts.append(made())
    bpy.ops.mesh.primitive_cube_add(size=0.3, location=(0.45, 0.87, 0.9))
    made().scale = (2.6, 0.25, 1)
    parts.append(made())
    _join(parts)
    _slots(seat, "Fabric", "Wood")
    index = np.ones(len(cast(Any, seat.data).polygons), dtype=np.int32)
    index[:8] = 0
    cast(Any, seat.data).polygons.foreach_set("material_index", index)
    _unwrapped(seat)
    _modifier(seat, "MIRROR")
    solid = _modifier(seat, "SOLIDIFY")
    solid.thickness = 0.06
    bevel = _modifier(seat, "BEVEL")
    bevel.width, bevel.segments = 0.02, 1
    _modifier(seat, "SUBSURF").render_levels = 2
    return _smooth(seat)


def gearwheel() -> bpy.types.Object:
    """A gear with bevelled edges."""
    item = mesh_object("Gear", *gear(), smooth=False)
    bevel = _modifier(item, "BEVEL")
    bevel.width, bevel.segments = 0.02, 2
    return _smooth(item)


def cube() -> bpy.types.Object:
    """The default cube."""
    bpy.ops.mesh.primitive_cube_add()
    return made()


def head() -> bpy.types.Object:
    """Blender's monkey, subdivided twice: open sockets, eyes apart."""
    bpy.ops.mesh.primitive_monkey_add()
    _modifier(made(), "SUBSURF").render_levels = 2
    return _smooth(made())


def knot() -> bpy.types.Object:
    """A tube along a knot: long, thin and closed."""
    curve: Any = bpy.data.curves.new("Knot", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", 0.18, 6
    spline = curve.splines.new("POLY")
    turns = np.linspace(0, 2 * pi, 160, endpoint=False)
    radius = 2 + np.cos(3 * turns)
    points = [radius * np.cos(2 * turns), radius * np.sin(2 * turns), np.sin(3 * turns), np.ones(160)]
    spline.points.add(159)
    spline.points.foreach_set("co", np.stack(points, axis=1).ravel())
    spline.use_cyclic_u = True
    return _meshed(curve)


def letters() -> bpy.types.Object:
    """Type with bevelled edges."""
    curve: Any = bpy.data.curves.new("Letters", "FONT")
    curve.body, curve.extrude, curve.bevel_depth = "Rag&8", 0.1, 0.02
    return _meshed(curve)


def leaves() -> bpy.types.Object:
    """A plant of 120 curved leaves on stems, open sheets all."""
    chance = np.random.default_rng(3)
    vertices: list[tuple[float, float, float]] = []
    faces: list[tuple[int, ...]] = []
    for _ in range(120):
        turn, lean, size = chance.uniform(0, 2 * pi), chance.uniform(0.2, 1.2), chance.uniform(0.3, 0.6)
        base = np.array([0, 0, chance.uniform(0, 1.5)])
        start = len(vertices)
        for along in np.linspace(0, 1, 7):
            out = base + size * along * np.array([np.cos(turn), np.sin(turn), lean * (1 - along)])
            side = (
                0.35 * size * np.sin(pi * min(along + 0.06, 1)) * np.array([-np.sin(turn), np.cos(turn), 0])
            )
            vertices += [tuple((out + k * side + [0, 0, 0.05 * k * k]).tolist()) for k in (-1, 0, 1)]
        faces += [(start + 3 * j + i, start + 3 * j + i + 1, start + 3 * j + i + 4, start + 3 * j + i + 3)
                  for j in range(6) for i in range(2)]  # fmt: skip
    return mesh_object("Leaves", vertices, faces, smooth=True)


def cloth() -> bpy.types.Object:
    """A sheet in folds, 40,000 triangles, a thickness of its own."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=100, y_subdivisions=100, size=2)
    item = made()
    place = places(item)
    x, y = place[:, 0], place[:, 1]
    place[:, 2] = 0.12 * np.sin(9 * x + 3 * np.sin(2 * y)) * (0.4 + 0.6 * np.cos(1.2 * y) ** 2)
    move_to(item, place)
    _modifier(item, "SOLIDIFY").thickness = 0.02
    return _smooth(item)


def stone() -> bpy.types.Object:
    """A chipped stone out of a photo scan: 6,000 uneven triangles."""
    item = _rough(5, 0.35)
    fewer: Any = _modifier(item, "DECIMATE")
    fewer.ratio = 0.3
    return _smooth(item)


def scan() -> bpy.types.Object:
    """An organic scan, 80,000 triangles, noise as a scanner leaves."""
    return _smooth(_rough(6, 0.5, fine=0.004))


def sculpt() -> bpy.types.Object:
    """A sculpt of half a million triangles."""
    item = _rough(6, 0.5)
    _modifier(item, "SUBSURF").render_levels = 1
    _apply(item)
    place = places(item)
    move_to(item, place * (1 + 0.01 * _noise(place * 6, seed=8)[:, None]))
    return _smooth(item)


MESHES: dict[str, Callable[[], bpy.types.Object]] = {
    made_by.__name__: made_by
    for made_by in (
        toy, case, bolts, chair, gearwheel, cube, head, knot, letters, leaves, cloth, stone, scan, sculpt,
    )
}  # fmt: skip


def _noise(place: Points, seed: int) -> Points:
    """A sum of octaves of waves in random directions, (V,), about -1 to 1."""
    chance = np.random.default_rng(seed)
    total = np.zeros(len(place))
    for octave in range(_OCTAVES):
        for _ in range(4):
            wave = chance.normal(size=3) * 1.4 * 2**octave
            total += np.sin(place @ wave + chance.uniform(0, 2 * pi)) / (4 * 1.7**octave)
    return total


def _rough(subdivisions: int, depth: float, fine: float = 0.0) -> bpy.types.Object:
    """A ball with bumps and hollows `depth` deep, and noise of `fine` on each vertex."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions + 1)
    item = made()
    place = places(item)
    out = 1 + depth * _noise(place, seed=5) + fine * np.random.default_rng(1).normal(size=len(place))
    move_to(item, place * out[:, None])
    return item


def _half() -> None:
    """Cut the active mesh at x = 0, and keep what lies beyond."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bisect(plane_co=(0, 0, 0), plane_no=(1, 0, 0), clear_inner=True)
    bpy.ops.object.mode_set(mode="OBJECT")


def _slots(item: bpy.types.Object, *names: str) -> None:
    for name in names:
        cast(Any, item.data).materials.append(bpy.data.materials.new(name))


def _inset(
    item: bpy.types.Object, facing: tuple[float, float, float], by: float, deep: float, slot: int
) -> None:
    """Inset the one face that looks that way, push its middle and give that another material."""
    mesh = cast(Any, item.data)
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="OBJECT")
    for face in mesh.polygons:
        face.select = bool(np.dot(face.normal, facing) > 0.9)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.inset(thickness=by, depth=deep)
    bpy.ops.object.mode_set(mode="OBJECT")
    for face in mesh.polygons:
        if face.select:
            face.material_index = slot


def _unwrapped(item: bpy.types.Object) -> None:
    """UVs of the base mesh, as an artist's first try: by Smart UV Project."""
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=0.02)
    bpy.ops.object.mode_set(mode="OBJECT")


def _modifier(item: bpy.types.Object, kind: Any) -> Any:
    return item.modifiers.new(kind.title(), kind)


def _apply(item: bpy.types.Object) -> None:
    bpy.context.view_layer.objects.active = item
    for modifier in list(item.modifiers):
        bpy.ops.object.modifier_apply(modifier=modifier.name)


def _join(parts: list[bpy.types.Object]) -> None:
    for part in parts:
        part.select_set(True)
    bpy.context.view_layer.objects.active = parts[0]
    bpy.ops.object.join()
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)


def _meshed(curve: bpy.types.Curve) -> bpy.types.Object:
    item = bpy.data.objects.new(curve.name, curve)
    bpy.context.scene.collection.objects.link(item)
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    bpy.ops.object.convert(target="MESH")
    return made()


def _smooth(item: bpy.types.Object) -> bpy.types.Object:
    mesh = cast(Any, item.data)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), dtype=bool))
    return item
