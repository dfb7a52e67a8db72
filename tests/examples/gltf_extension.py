# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The example of our glTF extension: a glossy ball between two coloured lamps, baked and exported.

python -m tests.examples.gltf_extension     writes docs/gltf/RADTEX_radiance_texture/example
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Layout
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.gltf_schema import EXTENSION_FOLDER

FOLDER = EXTENSION_FOLDER / "example"
NAME = "Ball"
SPEC = BakeSpec(layout=Layout.BUCKETS, texels=24, bucket=4, samples=16)
_LAMPS = {(2.5, -1.5, 1.5): (1.0, 0.55, 0.25), (-2.5, -1.0, 0.5): (0.25, 0.5, 1.0)}


def main() -> None:
    """Bake the ball and write the example's files."""
    _build_scene()
    with tempfile.TemporaryDirectory() as folder:
        bake_object(_context().scene, NAME, SPEC, Path(folder), preview=Filter.QUADRILINEAR)
        steps = export_steps(Path(folder) / f"{NAME}.radiance.json", ExportSpec(Target.GLTF))
        made = finished(steps)
        FOLDER.mkdir(parents=True, exist_ok=True)
        for name in made.files:
            if name.startswith(f"{NAME}."):
                shutil.copyfile(made.folder / name, FOLDER / name)
                print(f"{FOLDER / name}: {(FOLDER / name).stat().st_size} bytes")


def _build_scene() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    _context().scene.render.engine = "CYCLES"
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    bpy.ops.object.shade_smooth()
    ball = _context().object
    ball.name = NAME
    paint: Any = bpy.data.materials.new("Paint")
    if paint.node_tree is None:
        paint.use_nodes = True
    shader = next(node for node in paint.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (0.6, 0.6, 0.6, 1)
    shader.inputs["Roughness"].default_value = 0.35
    ball.data.materials.append(paint)
    for place, colour in _LAMPS.items():
        bpy.ops.object.light_add(type="POINT", location=place)
        lamp = _context().object.data
        lamp.energy, lamp.color, lamp.shadow_soft_size = 250, colour, 0.5


def _context() -> Any:
    """Blender's context; to the stubs, every pointer in it may be None."""
    return bpy.context


if __name__ == "__main__":
    main()
