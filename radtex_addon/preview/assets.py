# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake's node group and material as assets of the open file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import bpy

from ..formats.json_reader import Facts
from ..formats.sidecar_file import AnySidecar, opened
from .bake_group import ScriptNode, group_in, load_with_groups, made_materials
from .load import remove_unused


def make_assets(
    sidecar: AnySidecar, names: Sequence[str], scene: bpy.types.Scene, script: ScriptNode | None = None
) -> list[bpy.types.Material]:
    """Mark a bake's materials (several, of a split object) and node groups as assets; returns the materials.

    Both have the name of the bake's file, `Vase.radiance`. Those that were made before are kept, with their
    catalog and the user's tags, and show the new bake. For arguments and errors see `load_with_groups`.
    """
    file = opened(sidecar)
    meshes = load_with_groups(file, names, scene, script)
    materials = made_materials(meshes)
    for material in materials:
        for block in (material, group_in(material)):
            if block is not None:
                _mark(block, file.facts, is_script=script is not None)
    bpy.data.batch_remove(meshes)
    remove_unused()
    return materials


def _mark(block: bpy.types.ID, facts: Facts, *, is_script: bool) -> None:
    block.asset_mark()
    data: Any = cast(Any, block).asset_data
    kind, layout = facts.text("kind"), facts.text("layout")
    width, height = facts.size("texels")
    engines = "Cycles on the CPU (OSL)" if is_script else "Eevee and Cycles"
    data.description = (
        f"Baked {kind} of {facts.text('object')}, {width} x {height} texels, for {engines}. For objects with "
        f"the bake's mesh, whose UV layer is {facts.text('uv_map')}"
    )
    for tag in ("RadTex", kind, layout):
        data.tags.new(tag, skip_if_exists=True)
