# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small room with an object to bake, as scene and as file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None


def fill_room(fineness: int = 2) -> None:
    """A shiny ball on a floor, under a lamp and a grey sky."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=fineness)
    context.object.name = "Ball"
    shiny = stage.material("shiny", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.6, 0.3, 1), Roughness=0.2)
    context.object.data.materials.append(shiny)
    bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 0, -1))
    context.object.name = "Floor"
    floor = stage.material("floor", "ShaderNodeBsdfDiffuse", Color=(0.2, 0.5, 0.8, 1))
    context.object.data.materials.append(floor)
    bpy.ops.object.light_add(type="POINT", location=(2, 1, 3))
    context.object.name = "Lamp"
    context.object.data.energy = 200


def save_room(path: Path, fineness: int = 2) -> Path:
    """The room as a .blend at `path`, whose folder is made."""
    fill_room(fineness)
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path
