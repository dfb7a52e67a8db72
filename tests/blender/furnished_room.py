# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of a small room, to export as one scene: a shared atlas, parts, levels of detail, a layered bake."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object, part_specs
from radtex_addon.settings.spec import BakeSpec, Layout, Split
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None

NODES = ["Ball", "Chair", "Table", "Gem", "Crate.Red", "Crate.Gold", "Tree_LOD0"]
LEVELS = ["Tree_LOD1", "Tree_lod2"]
_PLAIN = BakeSpec(layout=Layout.BUCKETS, texels=16, bucket=4, samples=1)
_LAYERED = BakeSpec(layout=Layout.LAYERED, texels=16, samples=1)
_SPHERES = {"Ball": 2, "Gem": 2, "Tree_LOD0": 3, "Tree_LOD1": 2, "Tree_lod2": 1}  # how finely divided


def bake_room(folder: Path) -> list[Path]:
    """Build the room in an empty file and bake it; returns the sidecars, in the order of NODES."""
    _build()
    scene = context.scene

    def baked(name: str, spec: BakeSpec) -> Path:
        return bake_object(scene, name, spec, folder, preview=Filter.QUADRILINEAR).files.sidecar

    return [
        baked("Ball", _PLAIN),
        baked("Furniture", replace(_PLAIN, objects=("Chair", "Table"))),
        baked("Gem", _LAYERED),
        *(baked("Crate", spec) for spec in part_specs(scene, "Crate", replace(_PLAIN, split=Split.MATERIAL))),
        *(baked(name, _PLAIN) for name in ("Tree_LOD1", "Tree_LOD0", "Tree_lod2")),
    ]


def _build() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.hdri(stage.world())
    red = stage.material("Red", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.1, 0.1, 1))
    gold = stage.material("Gold", "ShaderNodeBsdfGlossy", Color=(0.9, 0.7, 0.3, 1), Roughness=0.4)
    names = ("Ball", "Chair", "Table", "Gem", "Crate", "Tree_LOD0", "Tree_LOD1", "Tree_lod2")
    for number, name in enumerate(names):
        if name in _SPHERES:
            bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=_SPHERES[name])
        else:
            bpy.ops.mesh.primitive_cube_add(size=1.5)
        item = context.object
        item.name = name
        item.location, item.rotation_euler = (2.5 * min(number, 5), 1.5, 0.5), (0.3, 0.2, 0.4)
        item.scale = (1, 1.2, 0.7)
        item.data.materials.append(red)
        if name in ("Gem", "Crate"):
            item.data.materials.append(gold)
            item.data.polygons[0].material_index = 1
    context.view_layer.update()
