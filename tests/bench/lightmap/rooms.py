# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small furnished room, lit by sun and sky through a window, or by a lamp behind a shade."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import bpy
from mathutils import Vector

from ..fidelity.scenes.materials import assign, principled
from ..fidelity.scenes.meshes import link, made, mesh_object

_SIZE = (5.0, 4.0, 2.7)
_WINDOW = ((1.2, 2.8), (0.9, 2.2))  # along y and z, in the wall x = 0
_GAP = 0.01  # metres between things that would lie in one plane
_LAMP = (1.2, 2.9, 1.3)

_Place = tuple[float, float, float]


def sunlit() -> None:
    """A sunbeam on floor and table; everything else is lit by the sky in the window, and by bounces."""
    _room(window=True)
    _world((0.5, 0.7, 1.0), 1.0)
    data: Any = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.angle = 5.0, 0.009
    item = bpy.data.objects.new("Sun", data)
    item.rotation_euler = Vector((1.0, 0.25, -0.8)).to_track_quat("-Z", "Y").to_euler()
    link(item)


def lamplit() -> None:
    """A small lamp in an opaque shade, open above and below: nearly all light has bounced."""
    _room(window=False)
    _world((0.0, 0.0, 0.0), 0.0)
    data: Any = bpy.data.lights.new("Lamp", "POINT")
    data.energy, data.shadow_soft_size = 60.0, 0.03
    item = bpy.data.objects.new("Lamp", data)
    item.location = _LAMP
    link(item)
    bpy.ops.mesh.primitive_cylinder_add(radius=0.16, depth=0.3, end_fill_type="NOTHING", location=_LAMP)
    shade = made()
    shade.name = "Shade"
    assign(shade, principled("Shade", (0.75, 0.73, 0.7)))


ROOMS: dict[str, Callable[[], None]] = {"sunlit": sunlit, "lamplit": lamplit}


def _world(colour: _Place, strength: float) -> None:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    background: Any = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (*colour, 1)
    background.inputs["Strength"].default_value = strength
    cast(bpy.types.Scene, bpy.context.scene).world = world


def _room(window: bool) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    cast(Any, bpy.context.scene).render.engine = "CYCLES"
    wide, deep, _ = _SIZE
    wood = principled("Wood", (0.4, 0.25, 0.13), Roughness=0.4)
    white = principled("White", (0.75, 0.73, 0.7), Roughness=0.6)
    red = principled("Red", (0.6, 0.12, 0.08), Roughness=0.3)
    _rectangle("Floor", (_GAP, _GAP), (wide - _GAP, deep - _GAP), 0.0, wood)
    _rectangle("Ground", (-1, -1), (wide + 1, deep + 1), -_GAP, wood)
    _shell(window, white)
    _box("Table", (2.6, 1.6, 0.66), (1.2, 0.8, 0.08), red)
    for number in range(4):
        x, y = (-1) ** (number // 2) * 0.5, (-1) ** number * 0.3
        _box(f"Leg {number}", (2.6 + x, 1.6 + y, 0.31), (0.06, 0.06, 0.61), red)
    _box("Cupboard", (4.6, 3.2, 0.805), (0.6, 1.2, 1.6), principled("Green", (0.15, 0.4, 0.2)))
    _box("Stool", (1.2, 2.9, 0.255), (0.4, 0.4, 0.5), white)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(3.6, 0.8, 0.305))
    ball = made()
    ball.name = "Ball"
    bpy.ops.object.shade_smooth()
    assign(ball, white)


def _shell(window: bool, material: bpy.types.Material) -> None:
    """Four walls, of which one may have a window, and a ceiling."""
    wide, deep, high = _SIZE
    (left, right), (low, top) = _WINDOW
    floor = [(0, 0), (wide, 0), (wide, deep), (0, deep), (0, left), (0, right)]
    points = [(x, y, z) for z in (-_GAP, high) for x, y in floor]
    points += [(0, y, z) for z in (low, top) for y in (left, right)]
    faces: list[tuple[int, ...]] = [(1, 0, 6, 7), (2, 1, 7, 8), (3, 2, 8, 9), (9, 8, 7, 6)]
    faces += [(0, 4, 10, 6), (5, 3, 9, 11), (4, 5, 13, 12), (14, 15, 11, 10)]
    if not window:
        faces.append((12, 13, 15, 14))
    assign(mesh_object("Walls", points, faces, smooth=False), material)


def _rectangle(
    name: str,
    low: tuple[float, float],
    top: tuple[float, float],
    height: float,
    material: bpy.types.Material,
) -> None:
    corners = [(x, y, height) for x, y in (low, (top[0], low[1]), top, (low[0], top[1]))]
    assign(mesh_object(name, corners, [(0, 1, 2, 3)], smooth=False), material)


def _box(name: str, middle: _Place, size: _Place, material: bpy.types.Material) -> None:
    bpy.ops.mesh.primitive_cube_add(size=1, location=middle)
    item = made()
    item.name = name
    item.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    assign(item, material)
