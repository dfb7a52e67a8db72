# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A textured asset: a painted steel case with decals, worn edges, rivets and scratches."""

from __future__ import annotations

from math import radians
from typing import Any, cast

import bpy
import numpy as np

from .case_maps import CELLS, case_maps
from .materials import assign, connect, principled, texture
from .meshes import Faces, Vertices, as_subject, mesh_object
from .stage import Stage, finish, lamp, start

_HALF = (0.95, 0.62, 0.6)
_CORNERS: Vertices = [
    (x * _HALF[0], y * _HALF[1], z * _HALF[2]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)
]
_FACES: Faces = [  # front, right, back, left, top, bottom; each from its lower left corner
    (0, 4, 5, 1), (4, 6, 7, 5), (6, 2, 3, 7), (2, 0, 1, 3), (1, 5, 7, 3), (2, 6, 4, 0),
]  # fmt: skip


def asset() -> Stage:
    """The case, its base colour, roughness, metallic mask and normals out of image textures."""
    start("city.exr", strength=0.6, turn=200)
    case = as_subject(mesh_object("Case", _CORNERS, _FACES, smooth=True))
    case.rotation_euler = (0, 0, radians(24))
    mesh = cast(bpy.types.Mesh, case.data)
    across, up = CELLS
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    layer: Any = mesh.uv_layers.new(name="UVMap")
    cells = [np.array((face % across, face // across)) for face in range(len(_FACES))]
    layer.data.foreach_set("uv", np.concatenate([(square + cell) / (across, up) for cell in cells]).ravel())
    bevel: Any = case.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments, bevel.harden_normals = 0.06, 3, True
    assign(case, _painted())
    lamp((-1.4, -2.4, 2.4), size=0.4, watts=50)
    return finish("asset", case)


def _painted() -> bpy.types.Material:
    maps = case_maps()
    paint = principled("Painted steel", (0.5, 0.5, 0.5))
    connect(paint, "Base Color", texture(paint, "Base colour", maps.colour).outputs["Color"])
    connect(paint, "Roughness", texture(paint, "Roughness", maps.roughness, data=True).outputs["Color"])
    connect(paint, "Metallic", texture(paint, "Metallic", maps.metallic, data=True).outputs["Color"])
    tree: Any = paint.node_tree
    normal = tree.nodes.new("ShaderNodeNormalMap")
    normal.uv_map = "UVMap"
    tree.links.new(texture(paint, "Normal", maps.normal, data=True).outputs["Color"], normal.inputs["Color"])
    connect(paint, "Normal", normal.outputs["Normal"])
    return paint
