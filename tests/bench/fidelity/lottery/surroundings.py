# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a drawn scene's subject stands among: floor, neighbours, lamps and cameras."""

from __future__ import annotations

from math import cos, radians, sin
from typing import cast

import bpy
import numpy as np

from ..scenes.materials import assign
from ..scenes.meshes import lathe, link, made, mesh_object
from ..scenes.stage import Angles, around, lamp
from .looks import draw_plain, pattern
from .objects import sphere_profile

HDRIS = tuple(
    f"{name}.exr"
    for name in ("city", "courtyard", "forest", "interior", "night", "studio", "sunrise", "sunset")
)
_CLEAR = 28.0  # degrees between a neighbour and a camera that nothing may be tuned on


def draw_cameras(rng: np.random.Generator) -> Angles:
    """Two directions of cameras, well apart: azimuths and elevations in degrees."""
    first = rng.uniform(0, 360)
    second = first + rng.uniform(70, 290)
    return [(float(azimuth % 360), float(rng.uniform(6, 48))) for azimuth in (first, second)]


def draw_floor(height: float, rng: np.random.Generator) -> None:
    """A floor, or none: plain or patterned, far wider than the view or with its edges in it."""
    ends, turn, size = rng.random() < 0.5, rng.uniform(0, 90), rng.uniform(3.2, 6)
    if rng.random() < 0.15:
        return
    bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 0, height), rotation=(0, 0, radians(turn)))
    floor = made()
    wide = float(size) if ends else 14.0
    floor.scale = (wide, wide, 1)
    ground = draw_plain(rng)
    if rng.random() < 0.75:
        pattern(ground, rng, "UV", scale=wide * float(rng.uniform(0.7, 2)))
    assign(floor, ground)


def draw_neighbours(floor: float, held_out: Angles, rng: np.random.Generator) -> None:
    """Up to five balls, boxes and cones on the floor's height, none of them before a held-out camera."""
    for number in range(int(rng.integers(0, 6))):
        azimuth, distance, size = rng.uniform(0, 360), rng.uniform(1.6, 2.6), float(rng.uniform(0.2, 0.45))
        shape, turn = int(rng.integers(3)), float(rng.uniform(0, 90))
        look = draw_plain(rng)
        if any(abs((azimuth - camera + 180) % 360 - 180) < _CLEAR for camera, _ in held_out):
            continue
        profiles = (
            sphere_profile(16),
            np.array([(2**0.5, -1), (2**0.5, 1)]),
            np.array([(1.0, -1.0), (0.02, 1.0)]),
        )
        segments = (48, 4, 48)[shape]
        shape_of_it = lathe(profiles[shape] * size, segments, tip=0.0)
        item = mesh_object(f"Neighbour {number}", *shape_of_it, smooth=shape == 0)
        item.location = (*around(azimuth, distance), floor + size)
        item.rotation_euler = (0, 0, radians(turn))
        assign(item, look)


def draw_lamps(rng: np.random.Generator) -> None:
    """None to two lamps, squares or small balls, of any size and from anywhere above."""
    for number in range(int(rng.integers(0, 3))):
        azimuth, elevation = rng.uniform(0, 360), radians(rng.uniform(15, 80))
        distance, size = rng.uniform(2.5, 4), float(np.exp(rng.uniform(np.log(0.04), np.log(1.6))))
        watts = float(np.exp(rng.uniform(np.log(15), np.log(150))))
        x, y = around(azimuth, distance * cos(elevation))
        place = (x, y, float(distance * sin(elevation)))
        if rng.random() < 0.6:
            lamp(place, size=size, watts=watts)
        else:
            data = cast(bpy.types.PointLight, bpy.data.lights.new(f"Point {number}", "POINT"))
            data.shadow_soft_size, data.energy = min(size, 0.4) / 2, watts
            item = bpy.data.objects.new(f"Point {number}", data)
            item.location = place
            link(item)
