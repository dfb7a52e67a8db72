# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies "NAME (baked copy)" that show a bake and are kept: what they show, and the collection they are in.

A custom property of the copy says so, which survives renaming, duplicating and appending. It has no pointer
to the original, which appending the copy would bring along: the original has a number, and the copy names it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, cast
from uuid import uuid4

import bpy
import numpy as np
from mathutils import Matrix

from ..core.errors import InputError
from ..formats.sidecar_file import AnySidecar, opened
from ..scene.mesh.copy import MATRIX
from ..scene.objects import about_matrix, is_linked
from ..scene.preview_file import give_to_mesh, is_sheared
from ..scene.scratch import find_view_layer
from .bake_group import MADE, ScriptNode, load_with_groups
from .load import remove_unused
from .swap import ORIGINAL, copy_of, is_foreign, is_on

COLLECTION = "Radiance Textures"
_COPY = "radtex_copy_of"  # custom property of a copy: the fields of `Shown`
_NUMBER = "radtex_number"  # of an object that has copies, and in that property
_GATHERS = "radtex_copies"  # of the collection of a scene's copies
_SHEAR = "matrix"  # in a copy's property: what was applied to its mesh, as an object cannot express it
_MOVED = 1e-4  # tolerance, relative to a matrix's largest value
_EARLIER = re.compile(r"(.+) \(baked\)(\.\d{3,})?")  # names of copies that earlier versions have made


@dataclass(frozen=True)
class Shown:
    """What a copy shows: the bake of the object `name`, by its `sidecar`, looked up by nodes or OSL's script.

    `digest` is that of the sidecar when the copy was made, empty for copies of earlier versions.
    """

    name: str
    sidecar: Path
    shader: str
    digest: str = ""


def shown_by(item: bpy.types.Object) -> Shown | None:
    """What a copy shows; None for any other object, previews among them.

    A copy of an earlier version is known by its mesh, its material and its name, all three.
    """
    owner = cast(Any, item)
    if ORIGINAL in owner:
        return None
    if _COPY in owner:
        record = owner[_COPY]
        return Shown(record["name"], Path(record["sidecar"]), record["shader"], record["digest"])
    named = _EARLIER.fullmatch(item.name)
    if named is None or item.type != "MESH" or MATRIX not in cast(Any, item.data):
        return None
    materials: list[Any] = [slot.material for slot in item.material_slots]
    made = [material[MADE] for material in materials if material is not None and MADE in material]
    if not made:
        return None
    title, _, sidecar = str(made[0]).partition(" of ")
    return Shown(named[1], Path(sidecar), "OSL" if title.endswith("(OSL)") else "NODES")


def original_of_copy(copy: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The object of `scene` that a copy was made of, also where that was renamed; None if it is not there."""
    shown = shown_by(copy)
    if shown is None:
        return None
    number = cast(Any, copy)[_COPY][_NUMBER] if _COPY in cast(Any, copy) else ""
    others = [item for item in scene.objects if ORIGINAL not in cast(Any, item) and shown_by(item) is None]
    alike = [item for item in others if cast(Any, item).get(_NUMBER, "") == number]
    named = next((item for item in alike if item.name == shown.name), None)
    return named or (alike[0] if number and alike else None)


def refuse_copy(item: bpy.types.Object) -> None:
    """Raise InputError if the object is a copy that shows a bake."""
    shown = shown_by(item)
    if shown is not None:
        raise InputError(
            f"object '{item.name}' is a copy that shows the bake of '{shown.name}': "
            f"bake '{shown.name}', then update the copy"
        )


def digest_of(sidecar: Path) -> str:
    """A digest of a bake's sidecar, which another bake changes; empty if it cannot be read."""
    try:
        return sha256(sidecar.read_bytes()).hexdigest()[:16]
    except OSError:
        return ""


def keep(
    copy: bpy.types.Object, original: bpy.types.Object, sidecar: Path, shader: str, matrix: Matrix
) -> None:
    """Write on a new copy what it shows. It was put at `matrix`, by `settle`."""
    owner = cast(Any, original)
    if not is_foreign(original) and _NUMBER not in owner:  # else it is known by its name alone
        owner[_NUMBER] = uuid4().hex[:16]
    record: dict[str, Any] = {
        "name": original.name,
        "sidecar": str(sidecar.absolute()),
        "shader": shader,
        "digest": digest_of(sidecar),
        _NUMBER: owner.get(_NUMBER, ""),
    }
    if is_sheared(matrix):
        record[_SHEAR] = [value for row in cast(Any, matrix) for value in row]
    if _NUMBER in cast(Any, copy):  # copied with the original
        del cast(Any, copy)[_NUMBER]
    cast(Any, copy)[_COPY] = record


def home_of_copies(scene: bpy.types.Scene) -> bpy.types.Collection | None:
    """The scene's collection of copies, made if there is none; None if nothing can be linked to the scene."""
    inside = scene.collection.children_recursive
    for one in inside:
        if _GATHERS in cast(Any, one) and not is_foreign(one):
            return one
    if is_foreign(scene):
        return None
    made = bpy.data.collections.new(COLLECTION)
    cast(Any, made)[_GATHERS] = True
    scene.collection.children.link(made)
    return made


def update_copies(copies: Iterable[bpy.types.Object], sidecar: AnySidecar, script: ScriptNode | None) -> None:
    """Give copies the mesh and the material of the bake with this sidecar. They stay where they are.

    Materials that the user has put on a copy stay on it. Raises as `load_with_groups` does, before anything
    has changed.
    """
    file = opened(sidecar)
    wanted = [(copy, shown) for copy in copies if (shown := shown_by(copy)) is not None]
    if not wanted:
        return
    scene = wanted[0][0].users_scene[0]
    meshes = [load_with_groups(file, [shown.name], scene, script)[0] for _, shown in wanted]
    for (copy, shown), mesh in zip(wanted, meshes, strict=True):
        owner, before = cast(Any, copy), cast(Any, copy.data)
        record = owner[_COPY].to_dict() if _COPY in owner else {"name": shown.name, _NUMBER: ""}
        if _SHEAR in record:
            values = list(record[_SHEAR])
            give_to_mesh(Matrix([values[row : row + 4] for row in range(0, 16, 4)]), mesh)
        for index, material in enumerate(before.materials):
            if material is not None and MADE not in material and index < len(mesh.materials):
                mesh.materials[index] = material
        copy.data = mesh
        if not before.users:
            bpy.data.meshes.remove(before)
        owner[_COPY] = record | {
            "sidecar": str(file.path.absolute()),
            "shader": shown.shader,
            "digest": digest_of(file.path),
        }
    remove_unused()


def delete_copies(copies: Iterable[bpy.types.Object]) -> None:
    """Delete copies, their meshes and materials if nothing else uses them, and then empty collections."""
    homes: dict[bpy.types.Collection, None] = {}
    for copy in copies:
        homes |= dict.fromkeys(home for home in copy.users_collection if _GATHERS in cast(Any, home))
        mesh = cast(Any, copy.data)
        materials = [one for one in mesh.materials if one is not None and MADE in one]
        bpy.data.objects.remove(copy)
        if not mesh.users:
            bpy.data.meshes.remove(mesh)
        for material in dict.fromkeys(materials):
            if not material.users and material.asset_data is None:
                bpy.data.materials.remove(material)
    for home in homes:
        if not home.objects and not home.children and home.library is None:
            bpy.data.collections.remove(home)


@contextmanager
def copies_not_rendered(scene: bpy.types.Scene) -> Iterator[None]:
    """Within the context, renders of a scene leave out copies that stand where their originals are rendered.

    There both would lie on one another. Copies that were moved, or whose original is hidden, are rendered.
    """
    layer = find_view_layer(scene, None)
    there = [item for item in scene.objects if not item.hide_render and not is_linked(item)]
    copies = [item for item in there if shown_by(item) is not None]
    hidden = [copy for copy in copies if _is_in_place(copy, original_of_copy(copy, scene), layer)]
    try:
        for copy in hidden:
            copy.hide_render = True
        yield
    finally:
        for copy in hidden:
            copy.hide_render = False


def _is_in_place(
    copy: bpy.types.Object, original: bpy.types.Object | None, layer: bpy.types.ViewLayer
) -> bool:
    if original is None or (original.hide_render and not is_on(original)):
        return False
    place, wanted = about_matrix(copy, layer), about_matrix(seen_of(original), layer)
    record = cast(Any, copy).get(_COPY)
    if record is not None and _SHEAR in record:
        place = place @ np.array(record[_SHEAR]).reshape(4, 4)
    return bool(np.abs(place - wanted).max() <= _MOVED * np.abs(wanted).max())


def seen_of(original: bpy.types.Object) -> bpy.types.Object:
    """What is seen of an object: its preview while that is on, else the object itself."""
    return copy_of(original) or original
