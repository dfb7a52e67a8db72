# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The stage that every scene is built on: its light, its floor, the things near the subject, the cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, radians, sin
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector

from .materials import assign, checker, principled
from .meshes import Points, link, made, places

PIXELS = 192  # of a picture's side
TUNING = ((-32.0, 16.0), (152.0, 38.0))  # azimuths and elevations of cameras, degrees
HELD_OUT = ((42.0, 30.0), (-112.0, 9.0))

_FILL = 0.8  # of the frame, by the object's longer side
_DISTANCE = 5.0  # of the cameras, from the object's middle
_GAP = 0.06  # between the subject and the floor

Angles = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Stage:
    """A built scene: its name, the object to bake, and the cameras.

    `see_through` is whether camera rays pass through the subject without being scattered, as they do where it
    is partly transparent; refraction scatters.
    """

    name: str
    subject: bpy.types.Object
    tuning: tuple[bpy.types.Object, ...]
    held_out: tuple[bpy.types.Object, ...]
    see_through: bool = False


def start(hdri: str, strength: float, turn: float) -> None:
    """Empty the open file; light it by an HDRI, turned by degrees about the vertical."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    cast(Any, scene.render).engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.resolution_percentage = 100
    cycles = cast(Any, scene).cycles
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    folder: str = cast(Any, bpy.utils).system_resource("DATAFILES", path="studiolights/world")
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:  # Blender 4.5; later every world has one
        world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = bpy.data.images.load(str(Path(folder, hdri)))
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, radians(turn))
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], environment.inputs["Vector"])
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = strength
    scene.world = world


def finish(
    name: str,
    subject: bpy.types.Object,
    floor: Callable[[float], None] | None = None,
    see_through: bool = False,
) -> Stage:
    """Lay the floor (checkered if not given), set the near things and the cameras about the subject."""
    height = floor_height(subject)
    (floor or checkered_floor)(height)
    neighbours(height)
    return with_cameras(name, subject, see_through=see_through)


def floor_height(subject: bpy.types.Object) -> float:
    """The height of a floor close below the subject."""
    return float(world_corners(subject)[:, 2].min()) - _GAP


def checkered_floor(height: float) -> None:
    """Lay a floor of squares, far wider than the view."""
    bpy.ops.mesh.primitive_plane_add(size=14, location=(0, 0, height))
    assign(made(), checker(tiles=28))


def neighbours(floor: float) -> None:
    """Stand two balls and a box about the subject on the floor's height."""
    ball((95, 1.75), 0.42, floor, (0.75, 0.06, 0.05))
    ball((-64, 1.85), 0.36, floor, (0.06, 0.2, 0.75))
    bpy.ops.mesh.primitive_cube_add(size=0.62, rotation=(0, 0, radians(25)))
    box = made()
    box.location = (*around(0, 1.85), floor + 0.31)
    assign(box, principled("Box", (0.1, 0.5, 0.12), Roughness=0.4))


def with_cameras(
    name: str,
    subject: bpy.types.Object,
    tuning: Angles = TUNING,
    held_out: Angles = HELD_OUT,
    see_through: bool = False,
) -> Stage:
    """Set the cameras, by azimuth and elevation in degrees."""
    corners = world_corners(subject)
    middle = Vector(((corners.min(axis=0) + corners.max(axis=0)) / 2).tolist())
    seen = [Vector(corner) for corner in corners.tolist()]
    cameras = [
        camera(f"{kind} {index}", azimuth, elevation, middle, seen)
        for kind, views in (("tuning", tuning), ("held out", held_out))
        for index, (azimuth, elevation) in enumerate(views, 1)
    ]
    cast(bpy.types.Scene, bpy.context.scene).camera = cameras[0]
    count = len(tuning)
    return Stage(name, subject, tuple(cameras[:count]), tuple(cameras[count:]), see_through)


def camera(
    name: str, azimuth: float, elevation: float, middle: Vector, seen: Sequence[Vector]
) -> bpy.types.Object:
    """A camera that looks at the points from an azimuth (degrees from -Y) and elevation, filled by them."""
    away = Vector((*around(azimuth, cos(radians(elevation))), sin(radians(elevation))))
    place = middle + away * _DISTANCE
    aim = middle
    half = 1.0
    for _ in range(4):  # each aim turns the frame a little
        rotation = (aim - place).to_track_quat("-Z", "Y")
        local = [rotation.inverted() @ (point - place) for point in seen]
        across = [(point.x / -point.z, point.y / -point.z) for point in local]
        low, high = np.min(across, axis=0), np.max(across, axis=0)
        half = float(max(high - low)) / 2
        centre = (low + high) / 2
        aim = place + rotation @ Vector((float(centre[0]), float(centre[1]), -1.0))
    data = bpy.data.cameras.new(name)
    data.sensor_width = 36
    data.lens = 18 * _FILL / half
    item = bpy.data.objects.new(name, data)
    item.location = place
    item.rotation_euler = (aim - place).to_track_quat("-Z", "Y").to_euler()
    link(item)
    return item


def world_corners(subject: bpy.types.Object) -> Points:
    """The evaluated mesh's vertices in world space, (V, 3)."""
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = subject.evaluated_get(graph)
    place = places(evaluated)
    matrix = np.array(evaluated.matrix_world)
    moved: Points = place @ matrix[:3, :3].T + matrix[:3, 3]
    return moved


def around(azimuth: float, distance: float) -> tuple[float, float]:
    """A place on the ground, its azimuth in degrees from -Y towards +X."""
    return sin(radians(azimuth)) * distance, -cos(radians(azimuth)) * distance


def ball(where: tuple[float, float], radius: float, floor: float, colour: tuple[float, float, float]) -> None:
    """Lay a ball on the floor's height, at an azimuth (degrees) and distance."""
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=48, ring_count=24, radius=radius, location=(*around(*where), floor + radius)
    )
    bpy.ops.object.shade_smooth()
    assign(made(), principled("Ball", colour, Roughness=0.35))


def lamp(place: tuple[float, float, float], size: float, watts: float, shape: str = "SQUARE") -> None:
    """Hang an area lamp that shines at the origin, or with the shape BALL a point lamp; so wide."""
    if shape == "BALL":
        data: Any = bpy.data.lights.new("Lamp", "POINT")
        data.shadow_soft_size = size / 2
    else:
        data = bpy.data.lights.new("Lamp", "AREA")
        data.shape, data.size = shape, size
    data.energy = watts
    item = bpy.data.objects.new("Lamp", data)
    item.location = place
    item.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()
    link(item)
