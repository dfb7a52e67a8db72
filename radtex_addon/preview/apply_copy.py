# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A real, independent object that shows a finished bake: a copy that may be selected, moved and kept.

`preview.swap` only shows a bake in the object's place, and hides the object meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy

from ..core.errors import InputError
from ..formats.sidecar_file import AnySidecar
from ..scene.preview_file import settle
from .bake_group import ScriptNode, load_with_groups
from .light_linking import link_alike
from .swap import copy_of, has_moved, homes, is_in, stand_in

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
    """Make a copy "NAME (baked)" of each object, with the bake's mesh, UVs and material.

    It stands where the object is now, or its preview, in its collections, without parent, constraints,
    modifiers and animation; visible, also where the object is hidden. In `layer` the copies are selected, and
    nothing else.
    The objects are not changed. `script` is as in `load_with_groups`, whose errors it raises, and InputError
    for an object that is no mesh or in no scene; then nothing has changed.
    """
    for original in originals:
        _check(original)
    matrices = [(copy_of(original) or original).matrix_world.copy() for original in originals]
    scene = originals[0].users_scene[0]
    meshes = load_with_groups(sidecar, [original.name for original in originals], scene, script)
    made = []
    for original, mesh, matrix in zip(originals, meshes, matrices, strict=True):
        moved = has_moved(matrix, mesh)
        copy = stand_in(original, mesh)
        settle(copy, mesh, matrix)
        _free(copy)
        link_alike(copy, original, homes(original))
        made.append(Applied(original, copy, moved))
    _select([one.copy for one in made], layer)
    return made


def _check(original: bpy.types.Object) -> None:
    if original.type != "MESH":
        raise InputError(f"object '{original.name}' is no mesh: only a baked mesh has a bake to apply")
    if not original.users_scene:
        raise InputError(f"object '{original.name}' is in no scene: link it to a collection")


def _free(copy: bpy.types.Object) -> None:
    """Let the copy be seen, selected and moved."""
    copy.hide_render = copy.hide_viewport = copy.hide_select = False
    for lock in _LOCKS:
        setattr(copy, lock, (False, False, False))


def _select(copies: Sequence[bpy.types.Object], layer: bpy.types.ViewLayer) -> None:
    layer.update()
    for item in list(layer.objects.selected):
        item.select_set(False, view_layer=layer)
    there = [copy for copy in copies if is_in(layer, copy)]
    for copy in there:
        copy.select_set(True, view_layer=layer)
    if there:
        layer.objects.active = there[0]
