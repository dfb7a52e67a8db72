# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""<name>.preview.blend: the user's scene with the baked copy in the object's place; the atlas lies beside it.

The file is saved from the user's own session. While it is written, a stand-in replaces the object for
everything that uses it: collections, children, constraints, other objects' modifiers, drivers.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import bpy

from ..core.errors import BakeError
from ..formats.disk.atomic import refusal, replacing
from ..scene.objects import is_linked
from .linked import linked_homes_copied

MATERIAL_PREFIX = "RadTex "  # prefix of the names of materials that show a bake

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class StandIn:
    """An object and its baked `copy`, which has no modifiers and is in no collection.

    `materials` are those of the copy's slots; if there is only one, all slots get it.
    """

    original: bpy.types.Object
    copy: bpy.types.Object
    materials: tuple[bpy.types.Material | None, ...]


def save_preview(
    scene: bpy.types.Scene,
    stand_ins: Sequence[StandIn],
    path: Path,
    hidden: Sequence[bpy.types.Object] = (),
) -> None:
    """Write a .blend in which the baked copies replace their originals and have their names.

    The file opens with `scene`. The materials' images are in the file if they are packed, else referenced by
    relative paths. The objects `hidden` are hidden in the file, because a copy shows them. Afterwards the
    session (the objects, the file's name, unsaved edits) is as it was, also after an error. Raises BakeError
    if Blender cannot write.
    """
    for image in bpy.data.images:
        if image.is_dirty and not image.packed_file:
            _log.warning("image '%s' has unsaved changes, which %s will not show", image.name, path.name)
    with replacing(path) as beside, ExitStack() as session:
        session.enter_context(_active_kept())
        session.enter_context(linked_homes_copied([stand_in.original for stand_in in stand_ins]))
        for stand_in in stand_ins:
            session.enter_context(_standing_in(stand_in))
        session.enter_context(_relative_images(stand_ins))
        session.enter_context(_shown(scene))
        session.enter_context(_hidden(hidden))
        try:
            bpy.ops.wm.save_as_mainfile(filepath=str(beside), copy=True, relative_remap=True)
        except RuntimeError as error:
            raise BakeError(refusal(path, OSError(" ".join(str(error).split())))) from error


@contextmanager
def _active_kept() -> Iterator[None]:
    """Restore every view layer's active object, and so its mode: Blender 5 loses one that is remapped."""
    layers = [layer for scene in bpy.data.scenes for layer in scene.view_layers]
    before = [layer.objects.active for layer in layers]
    try:
        yield
    finally:
        for layer, active in zip(layers, before, strict=True):
            if layer.objects.active != active:
                layer.objects.active = active


@contextmanager
def _standing_in(pair: StandIn) -> Iterator[None]:
    """Within the context, a duplicate of the copy replaces the original for all its users, by its name."""
    original, copy = pair.original, pair.copy
    name = original.name
    mesh = cast(bpy.types.Mesh, copy.data)
    bare = not mesh.materials
    standin = cast(bpy.types.Object, copy.copy())
    bearers = [item for item in bpy.data.objects if not is_linked(item) and item.name == name]
    try:
        for collection in standin.users_collection:  # Blender 5 adds a rigid body's copy to its world
            collection.objects.unlink(standin)
        if bare:
            mesh.materials.append(None)
        for index, slot in enumerate(standin.material_slots):
            slot.link = "OBJECT"  # so that the mesh keeps its own materials
            slot.material = pair.materials[index if len(pair.materials) > 1 else 0]
        for item in bearers:  # the original; if that is linked, perhaps a local object of the same name
            item.name = f"{name} (original)"
        standin.name = name
        original.user_remap(standin)
        yield
    finally:
        standin.user_remap(original)
        bpy.data.objects.remove(standin)
        for item in bearers:
            item.name = name
        if bare:
            mesh.materials.clear()


@contextmanager
def _hidden(items: Sequence[bpy.types.Object]) -> Iterator[None]:
    before = {item: (item.hide_render, item.hide_viewport) for item in items}
    try:
        for item in items:
            item.hide_render = item.hide_viewport = True
        yield
    finally:
        for item, (render, viewport) in before.items():
            item.hide_render, item.hide_viewport = render, viewport


@contextmanager
def _relative_images(stand_ins: Sequence[StandIn]) -> Iterator[None]:
    """Make the previews' image paths relative to the open file; Blender converts them for the new file.

    If the open file was never saved, nothing can be relative to it; Blender then makes all paths relative.
    """
    worn = {material for stand_in in stand_ins for material in stand_in.materials}
    own = {slot.material for stand_in in stand_ins for slot in stand_in.original.material_slots}
    shown = [material for material in worn - own if material is not None]
    images = {image for material in shown for image in images_of(material.node_tree)}
    paths = {image: image.filepath_raw for image in images if not image.packed_file}
    try:
        if bpy.data.filepath:
            for image, path in paths.items():
                image.filepath_raw = _relative(path)
        yield
    finally:
        for image, path in paths.items():
            image.filepath_raw = path


def _relative(path: str) -> str:
    try:
        return bpy.path.relpath(bpy.path.abspath(path))
    except ValueError:  # on another Windows drive
        return path


def images_of(tree: bpy.types.NodeTree | None) -> set[bpy.types.Image]:
    """The images that a material's nodes use, also inside groups."""
    images: set[bpy.types.Image] = set()
    for node in tree.nodes if tree else ():
        if isinstance(node, bpy.types.ShaderNodeTexImage) and node.image:
            images.add(node.image)
        elif isinstance(node, bpy.types.ShaderNodeGroup):
            images |= images_of(node.node_tree)
    return images


@contextmanager
def _shown(scene: bpy.types.Scene) -> Iterator[None]:
    """Make `scene` the one that the file opens with."""
    manager = bpy.context.window_manager
    window = manager.windows[0] if manager and manager.windows else None
    if window is None or window.scene == scene:
        yield
        return
    before, layer = window.scene, window.view_layer
    window.scene = scene
    try:
        yield
    finally:
        window.scene, window.view_layer = before, layer
