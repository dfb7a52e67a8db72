# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A shelf of twenty baked objects as one web page, and one of them alone, for tests.bench.web_page to visit.

    python -m tests.bench.web_scene OUT [--count 20] [--texels 48] [--samples 2]

Bakes them in the layered layout into OUT/bakes, and exports OUT/many and OUT/one.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Layout
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None

_COLUMNS = 5
_APART = 3.0  # units between neighbours


def main() -> None:
    """Bake what is missing, and export."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--texels", type=int, default=48)
    parser.add_argument("--samples", type=int, default=2)
    asked = parser.parse_args()
    names = _build(asked.count)
    bakes = asked.out / "bakes"
    spec = BakeSpec(layout=Layout.LAYERED, texels=asked.texels, samples=asked.samples)
    sidecars = [bakes / f"{name}.radiance.json" for name in names]
    for name, sidecar in zip(names, sidecars, strict=True):
        if not sidecar.is_file():
            bake_object(context.scene, name, spec, bakes, preview=Filter.QUADRILINEAR)
            print(f"{name} is baked", flush=True)
    web = ExportSpec(Target.WEB)
    finished(export_scene_steps(sidecars, web, "Shelf", asked.out / "many", overwrite=True))
    finished(export_steps(sidecars[0], web, asked.out / "one", overwrite=True))


def _build(count: int) -> list[str]:
    """An empty file with so many glossy objects under an HDRI; returns their names."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.hdri(stage.world())
    names = []
    for number in range(count):
        if number % 2:
            bpy.ops.mesh.primitive_monkey_add()
        else:
            bpy.ops.mesh.primitive_torus_add(major_segments=32, minor_segments=16)
        item = context.object
        item.name = f"Thing{number:02}"
        item.location = (_APART * (number % _COLUMNS), 0, _APART * (number // _COLUMNS))
        item.rotation_euler = (0.9, 0.0, 0.3 * number)
        share = number / count
        colour = (0.2 + 0.7 * share, 0.5, 0.9 - 0.7 * share, 1)
        gloss = stage.material(
            item.name, "ShaderNodeBsdfGlossy", Color=colour, Roughness=0.1 + 0.1 * (number % 5)
        )
        item.data.materials.append(gloss)
        bpy.ops.object.shade_smooth()
        names.append(item.name)
    return names


if __name__ == "__main__":
    main()
