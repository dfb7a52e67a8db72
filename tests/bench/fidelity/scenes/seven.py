# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Seven scenes on a checkered floor, between two balls and a box."""

from __future__ import annotations

from collections.abc import Callable
from math import radians
from typing import Any

import bpy
import numpy as np

from .materials import assign, colour_by, patches, principled, waves
from .meshes import Points, as_subject, gear, lathe, made, mesh_object, move_to, places, smooth_curve
from .stage import Stage, finish, lamp, start


def metal(roughness: float) -> Stage:
    """A gold head between two balls and a box."""
    start("courtyard.exr", strength=0.9, turn=40)
    bpy.ops.mesh.primitive_monkey_add()
    head = as_subject(made())
    subdivision: Any = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    bpy.ops.object.shade_smooth()
    assign(head, principled("Gold", (0.9, 0.6, 0.22), Metallic=1.0, Roughness=roughness))
    return finish(f"metal_{round(100 * roughness):02d}", head)


def ceramic() -> Stage:
    """A lidded jar, dark blue waves on white under a clear coat, lit by the sky of a forest and a lamp."""
    start("forest.exr", strength=0.8, turn=200)
    jar = as_subject(mesh_object("Jar", *lathe(jar_profile(), segments=88), smooth=True))
    glaze = principled("Glaze", (0.8, 0.8, 0.8), Roughness=0.25, Coat_Weight=1.0, Coat_Roughness=0.08)
    colour_by(glaze, waves(glaze.node_tree), ((0.45, (0.012, 0.03, 0.17)), (0.5, (0.72, 0.73, 0.7))))
    assign(jar, glaze)
    lamp((1.8, -2.2, 2.8), size=0.6, watts=60)
    return finish("ceramic", jar)


def textured() -> Stage:
    """A waxy blob of clear-cut patches."""
    start("sunset.exr", strength=0.8, turn=120)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6)
    blob = as_subject(made())
    displace(blob)
    bpy.ops.object.shade_smooth()
    wax = principled(
        "Wax", (0.8, 0.8, 0.8), Roughness=0.6, Subsurface_Weight=0.2, Subsurface_Radius=(0.2, 0.1, 0.06)
    )
    steps = ((0.3, (0.75, 0.2, 0.08)), (0.42, (0.78, 0.68, 0.45)), (0.6, (0.08, 0.3, 0.33)))
    colour_by(wax, patches(wax.node_tree), steps)
    assign(blob, wax)
    lamp((-2.4, -1.8, 2.6), size=0.8, watts=70)
    return finish("textured", blob)


def glass() -> Stage:
    """A clear pebble, in which everything behind it is seen upside down."""
    start("interior.exr", strength=0.5, turn=100)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48)
    pebble = as_subject(made())
    place = places(pebble)
    place *= (1.0, 0.8, 0.85)
    place[:, 0] *= 1 + 0.22 * place[:, 2]
    place[:, 2] += 0.12 * place[:, 0] ** 2
    move_to(pebble, place)
    bpy.ops.object.shade_smooth()
    clear = principled("Glass", (0.98, 1, 0.99), Transmission_Weight=1.0, IOR=1.45, Roughness=0.03)
    assign(pebble, clear)
    return finish("glass", pebble)


def mechanical() -> Stage:
    """A gear of flat faces, its steel tempered to colours."""
    start("city.exr", strength=0.55, turn=60)
    wheel = as_subject(mesh_object("Gear", *gear(), smooth=False))
    wheel.rotation_euler = (radians(62), 0, radians(18))
    steel = principled(
        "Steel",
        (0.62, 0.6, 0.58),
        Metallic=1.0,
        Roughness=0.15,
        Thin_Film_Thickness=400.0,
        Thin_Film_IOR=1.4,
    )
    assign(wheel, steel)
    return finish("mechanical", wheel)


def displace(blob: bpy.types.Object) -> None:
    """Bulge a unit sphere smoothly."""
    place = places(blob)
    x, y, z = place.T
    bulge = 0.12 * np.sin(2.4 * x + 1) * np.cos(2.1 * y) + 0.1 * np.sin(3.3 * z + 1.7 * x)
    bulge += 0.05 * np.sin(5 * y + 2 * z) * np.cos(4 * x)
    move_to(blob, place * (1 + bulge)[:, None])


def jar_profile() -> Points:
    """Radius and height from the foot's middle to the knob's top, (P, 2), as a smooth curve of key points."""
    keys = np.array(
        [
            (0.3, -1.0), (0.46, -1.0), (0.5, -0.95), (0.56, -0.75), (0.82, -0.3), (0.93, 0.1), (0.8, 0.42),
            (0.5, 0.56), (0.44, 0.62), (0.53, 0.67), (0.5, 0.74), (0.26, 0.84), (0.1, 0.88), (0.13, 0.97),
            (0.07, 1.05),
        ]
    )  # fmt: skip
    return smooth_curve(keys)


SEVEN: dict[str, Callable[[], Stage]] = {
    "metal_05": lambda: metal(0.05),
    "metal_20": lambda: metal(0.2),
    "metal_50": lambda: metal(0.5),
    "ceramic": ceramic,
    "textured": textured,
    "glass": glass,
    "mechanical": mechanical,
}
