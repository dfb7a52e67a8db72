# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Load the baked mesh of a saved preview, with the material that shows the bake, into the open file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import FormatError, InputError
from ..formats.sidecar import part_in, preview_path
from ..formats.sidecar_file import SidecarFile
from ..scene.preview_file import appended
from .lit_material import forget_sun
from .save import MATERIAL_PREFIX, images_of
from .taps import image_size

PREVIEW_TAG = "radtex_preview"  # custom property that marks data-blocks loaded from a preview


def load_baked_meshes(sidecar: SidecarFile, names: Sequence[str]) -> list[bpy.types.Mesh]:
    """Load the meshes of a bake, with the materials that show the atlas.

    If several objects share the atlas, those of the objects `names` are loaded; an object that was baked
    alone may have been renamed since. Only what the meshes use (materials, node groups, images) is loaded
    with them. Raises InputError if a file is missing or an object is not in the bake, FormatError for a file
    that cannot be read or is of another bake.
    """
    facts = sidecar.facts
    baked = _baked_names(sidecar, names)
    preview = preview_path(sidecar.path, facts.text("kind"), part_in(facts))
    if not preview.is_file():
        raise InputError(f"{preview} is missing, which holds what a preview shows: bake again with a preview")
    before = {block.session_uid for block in _blocks()}
    kept: list[bpy.types.ID] = []
    with appended(preview, baked, kept) as loaded:
        meshes = [
            _mesh_with_materials(preview, name, found, facts.text("uv_map"))
            for name, found in zip(baked, loaded, strict=True)
        ]
        kept.extend(meshes)
    for block in _blocks():
        if block.session_uid not in before:
            cast(Any, block)[PREVIEW_TAG] = True
    return meshes


def _baked_names(sidecar: SidecarFile, names: Sequence[str]) -> list[str]:
    """The names that the objects `names` had when they were baked. Raises InputError."""
    facts = sidecar.facts
    if "objects" not in facts.values:
        return [facts.text("object")]
    shared = facts.texts("objects")
    for name in names:
        if name not in shared:
            listed = ", ".join(f"'{other}'" for other in shared)
            raise InputError(f"{sidecar} is the atlas of {listed}, and '{name}' is none of them")
    return list(names)


def remove_unused() -> None:
    """Remove the data-blocks that were loaded from previews and have no users any more."""
    while unused := [block for block in _blocks() if block.users == 0 and PREVIEW_TAG in cast(Any, block)]:
        bpy.data.batch_remove(unused)


def _blocks() -> Iterator[bpy.types.ID]:
    """All data-blocks of the types that are loaded from previews."""
    data = bpy.data
    for kind in (data.meshes, data.materials, data.node_groups, data.images, data.texts):
        yield from cast("Iterator[bpy.types.ID]", kind)


def _mesh_with_materials(
    preview: Path, name: str, found: bpy.types.Object | None, layer: str
) -> bpy.types.Mesh:
    """The mesh of a loaded copy, after the materials of the object's slots replaced the mesh's own."""
    mesh = None if found is None else found.data
    if found is None or not isinstance(mesh, bpy.types.Mesh):
        raise FormatError(f"{preview} holds no mesh '{name}': bake again with a preview")
    if layer not in cast(Any, mesh).attributes or not any(slot.material for slot in found.material_slots):
        raise FormatError(f"{preview} is of another bake than its sidecar: bake again with a preview")
    for index, slot in enumerate(found.material_slots):
        material, slot.material = slot.material, None  # else the removed object stays a user
        mesh.materials[index] = material
        if material is None:
            continue
        if material.name.startswith(
            MATERIAL_PREFIX
        ):  # parts that are not baked have the user's own materials
            _check_images(material, preview)
            forget_sun(material)  # its drivers refer to the sun in the preview file's scene
    return mesh


def _check_images(material: bpy.types.Material, preview: Path) -> None:
    for image in sorted(images_of(material.node_tree), key=lambda image: image.name):
        if image.packed_file:
            continue
        path = Path(bpy.path.abspath(image.filepath))
        if not path.is_file():
            raise InputError(f"{path} is missing, which {preview.name} shows: put it back, or bake again")
        if 0 in image_size(image):
            raise FormatError(f"{path}: Blender reads no image in it; bake again")
