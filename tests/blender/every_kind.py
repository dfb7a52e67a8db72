# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small bake of every kind and layout, to export."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from radtex_addon.bake.layers import Layer
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.report.finished_bake import find_bake
from radtex_addon.settings.spec import BakeSpec, Kind, Layout, View
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target
from tests.blender import stage
from tests.finished_bakes import finished_bake

context: Any = bpy.context  # to the stubs, every pointer may be None

NAME = "Box"
LAYERS = (Layer.BASE, Layer.REST)
SPECS = {
    "radiance": BakeSpec(layout=Layout.BUCKETS, texels=12, bucket=4, samples=1, layers=LAYERS),
    "incident": BakeSpec(kind=Kind.INCIDENT, texels=12, bucket=4, samples=1),
    "reflection": BakeSpec(kind=Kind.REFLECTION, texels=12, bucket=4, samples=1),
    "proxy": BakeSpec(kind=Kind.PROXY, texels=12, bucket=4, samples=1),
    "shadow": BakeSpec(kind=Kind.SHADOW, texels=12, bucket=8),
    "ao": BakeSpec(kind=Kind.AO, texels=12, bucket=4, samples=1),
    "transfer": BakeSpec(kind=Kind.TRANSFER, texels=16, samples=1),
    "transfer around": BakeSpec(kind=Kind.TRANSFER, texels=16, samples=1, view=View.AROUND),
    "layered": BakeSpec(layout=Layout.LAYERED, texels=16, samples=1),
}
EXPORTS = {
    **{name: (name, ExportSpec(Target.GLTF)) for name in SPECS},
    "layers": ("radiance", ExportSpec(Target.GLTF, layers=LAYERS)),
    "slices": ("radiance", ExportSpec(Target.GLTF, arrangement=Arrangement.SLICES)),
    "pages": ("radiance", ExportSpec(Target.GLTF, limit=16, levels=1)),
    "mirror": ("radiance", ExportSpec(Target.GODOT, mirror=True)),
    "layered mirror": ("layered", ExportSpec(Target.GODOT, mirror=True)),
}


def every_kind(folder: Path) -> dict[str, Path]:
    """The sidecars of a box that was baked by each of SPECS, by their names."""
    finished_bake(folder, _bake_every_kind)
    return {name: find_bake(folder / name, None, "shown", tuple(Kind)).path for name in SPECS}


def _bake_every_kind(folder: Path) -> None:
    """Bake a box of two materials around a ball by each of SPECS."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.hdri(stage.world())
    bpy.ops.mesh.primitive_cube_add(size=2, location=(1, 2, 3))
    box = context.object
    box.name = NAME
    red, gold = (0.8, 0.2, 0.2, 1), (0.9, 0.7, 0.3, 1)
    box.data.materials.append(stage.material("Red", "ShaderNodeBsdfDiffuse", Color=red))
    box.data.materials.append(stage.material("Gold", "ShaderNodeBsdfGlossy", Color=gold, Roughness=0.4))
    box.data.polygons[0].material_index = 1
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.6, location=(1, 2, 3))
    context.object.data.materials.append(stage.material("Ball", "ShaderNodeEmission"))
    for name, spec in SPECS.items():
        bake_object(context.scene, NAME, spec, folder / name, preview=Filter.QUADRILINEAR)
