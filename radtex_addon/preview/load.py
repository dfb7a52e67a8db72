# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked mesh of a saved preview, wearing the material that shows the bake, for the open file to keep."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import FormatError, InputError
from ..formats.sidecar import preview_path, read_facts
from ..scene.preview_file import appended
from .save import images_of
from .sun import forget_sun

_OURS = "radtex_preview"  # of every data-block that came with a preview


def load_baked_mesh(sidecar: Path) -> bpy.types.Mesh:
    """The mesh of the bake whose sidecar is the file `sidecar`; its one material shows the atlas.

    What it uses (material, node groups, images) is loaded with it, and nothing else of the preview's file.
    Raises InputError where a file is missing, FormatError for one that cannot be read or fits no other.
    """
    facts = read_facts(sidecar)
    name, kind = facts.text("object"), facts.text("kind")
    preview = preview_path(sidecar, kind)
    if not preview.is_file():
        raise InputError(f"{preview} is missing, which holds what a preview shows: bake again with a preview")
    before = {block.session_uid for block in _blocks()}
    kept: list[bpy.types.ID] = []
    with appended(preview, name, kept) as found:
        mesh, material = _parts(preview, name, found, facts.text("uv_map"))
        _check_images(material, preview)
        forget_sun(material)  # which is in the preview's own scene
        mesh.materials.clear()  # the object's own, which the preview's material hid
        mesh.materials.append(material)
        kept.append(mesh)
    for block in _blocks():
        if block.session_uid not in before:
            cast(Any, block)[_OURS] = True
    return mesh


def remove_unused() -> None:
    """Remove what came with previews and is used by nothing any more."""
    while unused := [block for block in _blocks() if block.users == 0 and _OURS in cast(Any, block)]:
        bpy.data.batch_remove(unused)


def _blocks() -> Iterator[bpy.types.ID]:
    """All that a preview could have brought."""
    data = bpy.data
    for kind in (data.meshes, data.materials, data.node_groups, data.images):
        yield from cast("Iterator[bpy.types.ID]", kind)


def _parts(
    preview: Path, name: str, found: bpy.types.Object | None, layer: str
) -> tuple[bpy.types.Mesh, bpy.types.Material]:
    mesh = None if found is None else found.data
    if found is None or not isinstance(mesh, bpy.types.Mesh):
        raise FormatError(f"{preview} holds no mesh '{name}': bake again with a preview")
    material = None
    for slot in found.material_slots:
        material, slot.material = slot.material, None  # or it would count the object as a user for ever
    if material is None or layer not in cast(Any, mesh).attributes:
        raise FormatError(f"{preview} is of another bake than its sidecar: bake again with a preview")
    return mesh, material


def _check_images(material: bpy.types.Material, preview: Path) -> None:
    for image in sorted(images_of(material.node_tree), key=lambda image: image.name):
        if image.packed_file:
            continue
        path = Path(bpy.path.abspath(image.filepath))
        if not path.is_file():
            raise InputError(f"{path} is missing, which {preview.name} shows: put it back, or bake again")
        if 0 in tuple(cast(Any, image).size):
            raise FormatError(f"{path}: Blender reads no image in it; bake again")
