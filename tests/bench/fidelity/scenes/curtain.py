# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A wavy sheet of cloth, partly transparent and translucent."""

from __future__ import annotations

from math import radians

import bpy
import numpy as np

from .materials import assign, colour_by, principled, translucent, waves
from .meshes import as_subject, made, move_to, places
from .stage import Stage, finish, lamp, start


def curtain() -> Stage:
    """A curtain in folds that lets 40% of the light pass straight and scatters half of the rest through."""
    start("sunset.exr", strength=0.6, turn=30)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=120, y_subdivisions=60, size=2)
    sheet = as_subject(made())
    place = places(sheet)
    x, y, _ = place.T.copy()
    fold = 0.17 * np.sin(7.5 * x + 0.5 * np.sin(2 * y)) + 0.04 * np.sin(17 * x + y)
    place[:, 0] = x * (0.95 - 0.08 * y)
    place[:, 1] = fold * (1.1 - 0.35 * y)
    place[:, 2] = 0.85 * y
    move_to(sheet, place)
    sheet.rotation_euler = (0, 0, radians(20))
    bpy.ops.object.shade_smooth()
    cloth = principled("Cloth", (0.8, 0.8, 0.8), Roughness=0.8, Sheen_Weight=0.3, Alpha=0.6)
    colour_by(cloth, waves(cloth.node_tree), ((0.4, (0.7, 0.12, 0.05)), (0.55, (0.8, 0.62, 0.3))))
    translucent(cloth, 0.5)
    assign(sheet, cloth)
    lamp((-2.4, 1.6, 2.0), size=0.5, watts=120)
    return finish("curtain", sheet, see_through=True)
