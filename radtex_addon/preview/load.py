# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked mesh of a saved preview, wearing the material that shows the bake, for the open file to keep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import FormatError, InputError
from ..formats.json_reader import Facts
from ..formats.sidecar import part_in, preview_path, read_facts
from ..scene.preview_file import appended
from .save import TITLE, images_of
from .sun import forget_sun
from .taps import image_size

OURS = "radtex_preview"  # of every data-block that came with a preview


def load_baked_meshes(sidecar: Path, names: Sequence[str]) -> list[bpy.types.Mesh]:
    """The meshes of the bake whose sidecar is the file `sidecar`; their materials show the atlas.

    Of several that share it those of the objects `names`; one that was baked alone may have another name by
    now. What they use (materials, node groups, images) is loaded with them, and nothing else of the preview's
    file. Raises InputError where a file is missing, or an object has no part in the bake; FormatError for
    a file that cannot be read or fits no other.
    """
    facts = read_facts(sidecar)
    baked = _baked_names(sidecar, facts, names)
    preview = preview_path(sidecar, facts.text("kind"), part_in(facts))
    if not preview.is_file():
        raise InputError(f"{preview} is missing, which holds what a preview shows: bake again with a preview")
    before = {block.session_uid for block in _blocks()}
    kept: list[bpy.types.ID] = []
    with appended(preview, baked, kept) as loaded:
        meshes = [
            _dressed(preview, name, found, facts.text("uv_map"))
            for name, found in zip(baked, loaded, strict=True)
        ]
        kept.extend(meshes)
    for block in _blocks():
        if block.session_uid not in before:
            cast(Any, block)[OURS] = True
    return meshes


def _baked_names(sidecar: Path, facts: Facts, names: Sequence[str]) -> list[str]:
    """What the objects `names` were called when they were baked."""
    if "objects" not in facts.values:
        return [facts.text("object")]
    shared = facts.texts("objects")
    for name in names:
        if name not in shared:
            listed = ", ".join(f"'{other}'" for other in shared)
            raise InputError(f"{sidecar} is the atlas of {listed}, and '{name}' is none of them")
    return list(names)


def remove_unused() -> None:
    """Remove what came with previews and is used by nothing any more."""
    while unused := [block for block in _blocks() if block.users == 0 and OURS in cast(Any, block)]:
        bpy.data.batch_remove(unused)


def _blocks() -> Iterator[bpy.types.ID]:
    """All that a preview could have brought."""
    data = bpy.data
    for kind in (data.meshes, data.materials, data.node_groups, data.images):
        yield from cast("Iterator[bpy.types.ID]", kind)


def _dressed(preview: Path, name: str, found: bpy.types.Object | None, layer: str) -> bpy.types.Mesh:
    """The mesh of a baked copy, with what the copy wears: its own materials were hidden by that."""
    mesh = None if found is None else found.data
    if found is None or not isinstance(mesh, bpy.types.Mesh):
        raise FormatError(f"{preview} holds no mesh '{name}': bake again with a preview")
    if layer not in cast(Any, mesh).attributes or not any(slot.material for slot in found.material_slots):
        raise FormatError(f"{preview} is of another bake than its sidecar: bake again with a preview")
    for index, slot in enumerate(found.material_slots):
        material, slot.material = slot.material, None  # or it would count the object as a user for ever
        mesh.materials[index] = material
        if material is None:
            continue
        if material.name.startswith(TITLE):  # of a part that is not baked it is the user's own
            _check_images(material, preview)
            forget_sun(material)  # which is in the preview's own scene
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
