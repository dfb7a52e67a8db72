# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One object of three materials in bands, made by modifiers, under one small lamp."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np

from .materials import assign, principled
from .meshes import as_subject, lathe, mesh_object
from .stage import Stage, finish, lamp, start

_SEGMENTS = 16
_PAINT, _CHROME, _RUBBER = range(3)
_BANDS = (  # radius and height of a ring, and the material from there up
    (0.3, -0.9, _RUBBER), (0.72, -0.9, _RUBBER), (0.72, -0.62, _RUBBER), (0.66, -0.62, _PAINT),
    (0.85, -0.5, _PAINT), (0.85, -0.1, _PAINT), (0.78, -0.1, _CHROME), (0.72, 0.1, _CHROME),
    (0.74, 0.32, _CHROME), (0.82, 0.36, _RUBBER), (0.82, 0.58, _RUBBER), (0.6, 0.58, _PAINT),
    (0.5, 0.74, _PAINT), (0.34, 0.76, _CHROME), (0.34, 0.95, _CHROME), (0.2, 0.95, _CHROME),
)  # fmt: skip


def bands() -> Stage:
    """A knob of paint under a coat, chrome and rubber, at night under a lamp of 5 cm."""
    start("night.exr", strength=0.8, turn=0)
    profile = np.array([(radius, height) for radius, height, _ in _BANDS])
    knob = as_subject(mesh_object("Knob", *lathe(profile, _SEGMENTS, tip=0.0), smooth=True))
    paint = principled("Paint", (0.55, 0.03, 0.02), Roughness=0.4, Coat_Weight=1.0, Coat_Roughness=0.03)
    assign(knob, paint)
    assign(knob, principled("Chrome", (0.8, 0.8, 0.82), Metallic=1.0, Roughness=0.06))
    assign(knob, principled("Rubber", (0.03, 0.03, 0.03), Roughness=0.7))
    mesh = cast(bpy.types.Mesh, knob.data)
    ring = [material for *_, material in _BANDS[:-1] for _ in range(_SEGMENTS)]
    caps = [_BANDS[0][2], _BANDS[-1][2]] * _SEGMENTS
    mesh.polygons.foreach_set("material_index", ring + caps)
    bevel: Any = knob.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.03, 2
    subdivision: Any = knob.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    lamp((1.2, -2.0, 2.6), size=0.05, watts=130)
    return finish("bands", knob)
