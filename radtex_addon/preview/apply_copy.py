# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A real, independent object that shows a finished bake: a copy that may be selected, moved and kept.

`preview.swap` only shows a bake in the object's place, and hides the object meanwhile.

A bake's node group and material can also become assets of the open file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import bpy

from ..core.errors import InputError
from ..formats.json_reader import Facts
from ..formats.sidecar_file import AnySidecar, opened
from ..scene.preview_file import settle
from ..scene.surfaces import may_have_faces
from .bake_group import ScriptNode, group_in, load_with_groups, made_materials
from .kept_copies import home_of_copies, keep
from .light_linking import link_alike
from .load import remove_unused
from .swap import copy_of, has_moved, homes, is_in, shown_name, stand_in

_LOCKS = ("lock_location", "lock_rotation", "lock_scale")


@dataclass(frozen=True, eq=False)
class Applied:
    """A `copy` that shows the bake of `original`, which may have `moved` since the bake."""

    original: bpy.types.Object
    copy: bpy.types.Object
    moved: bool


def apply_to_copies(
    originals: Sequence[bpy.types.Object],
    sidecar: AnySidecar,
    layer: bpy.types.ViewLayer,
    script: ScriptNode | None = None,
) -> list[Applied]:
    """Make a copy "NAME (baked copy)" of each object, with the bake's mesh, UVs and material.

    NAME is the object's, or the bake's where that has one of its own.

    It stands where the object is now, or its preview, in the collection of the scene's copies, without
    parent, constraints, modifiers and animation; visible, also where the object is hidden. In `layer` the
    copies are selected, and nothing else.
    The objects only get a number by which their copies know them. `script` is as in `load_with_groups`, whose
    errors it raises, and InputError for an object that is no mesh or in no scene; then nothing has changed.
    """
    for original in originals:
        _check(original)
    matrices = [(copy_of(original) or original).matrix_world.copy() for original in originals]
    scene = originals[0].users_scene[0]
    file = opened(sidecar)
    meshes = load_with_groups(file, [original.name for original in originals], scene, script)
    home = home_of_copies(cast(bpy.types.Scene, layer.id_data))
    made = []
    for original, mesh, matrix in zip(originals, meshes, matrices, strict=True):
        moved = has_moved(matrix, mesh)
        copy = stand_in(original, mesh)
        copy.name = f"{shown_name(original, file)} (baked copy)"
        settle(copy, mesh, matrix)
        _free(copy)
        link_alike(copy, original, homes(original) if home is None else [home])
        keep(copy, original, file.path, "NODES" if script is None else "OSL", matrix)
        made.append(Applied(original, copy, moved))
    select_only([one.copy for one in made], layer)
    return made


def _check(original: bpy.types.Object) -> None:
    if not may_have_faces(original):
        raise InputError(f"object '{original.name}' is no mesh: only a baked mesh has a bake to apply")
    if not original.users_scene:
        raise InputError(f"object '{original.name}' is in no scene: link it to a collection")


def _free(copy: bpy.types.Object) -> None:
    """Let the copy be seen, selected and moved."""
    copy.hide_render = copy.hide_viewport = copy.hide_select = False
    for lock in _LOCKS:
        setattr(copy, lock, (False, False, False))


def select_only(copies: Sequence[bpy.types.Object], layer: bpy.types.ViewLayer) -> None:
    """Select these objects in a view layer, as far as it has them, and nothing else; the first is active."""
    layer.update()
    for item in list(layer.objects.selected):
        item.select_set(False, view_layer=layer)
    there = [copy for copy in copies if is_in(layer, copy)]
    for copy in there:
        copy.select_set(True, view_layer=layer)
    if there:
        layer.objects.active = there[0]


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
