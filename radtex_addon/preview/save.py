# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""<name>.preview.blend: the user's scene with the baked copy in the object's place; the atlas lies beside it.

The file holds what the scene shows and nothing else of the user's file: the baked copy with its material,
the objects that are visible, camera, lights and world. No other scenes, texts, brushes, window layouts, and
nothing that only a fake user keeps. Images with a file on disk are linked; large packed ones are stored once
for all previews of a folder.

It is written from the user's own session. Meanwhile a stand-in replaces the object for everything that uses
it (collections, children, constraints, other objects' modifiers, drivers), and a trimmed copy the scene.

Packed images of the surroundings, such as an HDRI, are stored once for all previews of a folder.

The surroundings light what stands beside the bake, so a preview needs their images. An image with a file on
disk stays a link to it. One that is packed into the user's .blend would be in each object's preview again:
it is written to the folder `preview-images` beside them instead, named after its content, and linked by a
relative path. If the file that it was packed from is still there, unchanged, that is linked.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import BakeError
from ..formats.disk.atomic import refusal, replacing, replacing_together
from ..formats.disk.path_checks import render_path
from ..scene.objects import is_linked
from ..scene.render_settings import reset_render_settings
from .linked import linked_homes_copied
from .trimmed_scene import replaced, trimmed_scene

FOLDER = "preview-images"  # beside the previews
_LARGE = 1 << 16  # bytes: smaller ones stay packed
_SUFFIXES = {"HDR": ".hdr", "OPEN_EXR": ".exr", "OPEN_EXR_MULTILAYER": ".exr", "JPEG": ".jpg", "TIFF": ".tif"}
MATERIAL_PREFIX = "RadTex "  # prefix of the names of materials that show a bake

_log = logging.getLogger(__name__)


@contextmanager
def packed_images_shared(images: Iterable[bpy.types.Image], folder: Path) -> Iterator[None]:
    """Within the context, links to files replace the large packed ones of these images, for all users.

    Files are written to FOLDER in `folder`, unless they are there. Images of several files (UDIM tiles,
    views) and those of libraries stay as they are. Raises BakeError where the system refuses.
    """
    with ExitStack() as session:
        for image in sorted(images, key=lambda image: image.name):
            data = _packed_data(image)
            if data is None:
                continue
            path = _source_of(image, data) or _stored(image, data, folder / FOLDER)
            link = cast("bpy.types.Image", image.copy())
            session.callback(bpy.data.images.remove, link)
            link.unpack(method="REMOVE")
            link.filepath_raw = path
            session.enter_context(replaced(image, link))
        yield


def relative_path(path: str) -> str:
    """The path relative to the open file, or as it is, on another Windows drive."""
    try:
        return bpy.path.relpath(bpy.path.abspath(path))
    except ValueError:
        return path


def _packed_data(image: bpy.types.Image) -> bytes | None:
    packed = image.packed_file
    if packed is None or is_linked(image) or image.source != "FILE" or len(image.packed_files) != 1:
        return None
    return cast(bytes, cast(Any, packed).data) if packed.size >= _LARGE else None


def _source_of(image: bpy.types.Image, data: bytes) -> str | None:
    """The image's path if its file has this content."""
    path = Path(bpy.path.abspath(image.filepath_raw)) if image.filepath_raw else None
    try:
        if path is None or not path.is_file() or path.stat().st_size != len(data):
            return None
        return image.filepath_raw if path.read_bytes() == data else None
    except OSError:
        return None


def _stored(image: bpy.types.Image, data: bytes, folder: Path) -> str:
    """The path of a file with this content, which is written if it is not there."""
    named = Path(bpy.path.basename(image.filepath_raw) or image.name)
    suffix = _SUFFIXES.get(image.file_format, f".{image.file_format.lower()}")
    path = folder / f"{bpy.path.clean_name(named.stem)}-{hashlib.sha256(data).hexdigest()[:12]}{suffix}"
    if not path.is_file() or path.stat().st_size != len(data):
        with replacing(path) as beside:
            beside.write_bytes(data)
    return relative_path(str(path)) if bpy.data.filepath else str(path)


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

    The file has `scene` alone (and its background scenes), with the objects that it shows and what these
    need. The materials' images are in the file if they are packed, else referenced by relative paths. The
    objects `hidden` are left out, because a copy shows them, or hidden if others need them. Afterwards the
    session (the objects, the file's name, unsaved edits) is as it was, also after an error. Raises BakeError
    if Blender cannot write.
    """
    with replacing(path) as beside, ExitStack() as session:
        session.enter_context(_active_kept())
        session.enter_context(linked_homes_copied([stand_in.original for stand_in in stand_ins]))
        shown = [session.enter_context(_standing_in(stand_in)) for stand_in in stand_ins]
        session.enter_context(_relative_images(stand_ins))
        session.enter_context(_hidden(hidden))
        trimmed = session.enter_context(trimmed_scene(scene, shown, hidden))
        images = {block for block in trimmed.used if isinstance(block, bpy.types.Image)}
        _warn_of_unsaved(images, path)
        ours = _images_shown(stand_ins) - _images_of_originals(stand_ins)
        session.enter_context(packed_images_shared(images - ours, path.parent))
        try:
            bpy.data.libraries.write(str(beside), {trimmed.scene}, path_remap="RELATIVE", compress=True)
        except (RuntimeError, OSError) as error:
            raise BakeError(refusal(path, OSError(" ".join(str(error).split())))) from error


def _warn_of_unsaved(images: Iterable[bpy.types.Image], path: Path) -> None:
    for image in images:
        if image.is_dirty and not image.packed_file:
            _log.warning("image '%s' has unsaved changes, which %s will not show", image.name, path.name)


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
def _standing_in(pair: StandIn) -> Iterator[bpy.types.Object]:
    """Within the context, a duplicate of the copy replaces the original for all its users, by its name.

    The copy's mesh has no materials meanwhile: they would bring the original's images into the file.
    """
    original, copy = pair.original, pair.copy
    name = original.name
    mesh = cast(bpy.types.Mesh, copy.data)
    own = list(mesh.materials)
    standin = cast(bpy.types.Object, copy.copy())
    bearers = [item for item in bpy.data.objects if not is_linked(item) and item.name == name]
    try:
        for collection in standin.users_collection:  # Blender 5 adds a rigid body's copy to its world
            collection.objects.unlink(standin)
        if not own:
            mesh.materials.append(None)
        for index, slot in enumerate(standin.material_slots):
            slot.link = "OBJECT"
            slot.material = pair.materials[index if len(pair.materials) > 1 else 0]
        for index in range(len(own)):
            mesh.materials[index] = None
        for item in bearers:  # the original; if that is linked, perhaps a local object of the same name
            item.name = f"{name} (original)"
        standin.name = name
        original.user_remap(standin)
        yield standin
    finally:
        standin.user_remap(original)
        bpy.data.objects.remove(standin)
        for item in bearers:
            item.name = name
        for index, material in enumerate(own):
            mesh.materials[index] = material
        if not own:
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
    images = _images_shown(stand_ins) - _images_of_originals(stand_ins)
    paths = {image: image.filepath_raw for image in images if not image.packed_file}
    try:
        if bpy.data.filepath:
            for image, path in paths.items():
                image.filepath_raw = relative_path(path)
        yield
    finally:
        for image, path in paths.items():
            image.filepath_raw = path


def _images_shown(stand_ins: Sequence[StandIn]) -> set[bpy.types.Image]:
    """The images of the materials that show the bakes."""
    worn = {material for stand_in in stand_ins for material in stand_in.materials}
    own = {slot.material for stand_in in stand_ins for slot in stand_in.original.material_slots}
    shown = [material for material in worn - own if material is not None]
    return {image for material in shown for image in images_of(material.node_tree)}


def _images_of_originals(stand_ins: Sequence[StandIn]) -> set[bpy.types.Image]:
    """The images of the materials that were baked, which some previews show, too."""
    own = [slot.material for stand_in in stand_ins for slot in stand_in.original.material_slots]
    return {image for material in own if material is not None for image in images_of(material.node_tree)}


def images_of(tree: bpy.types.NodeTree | None) -> set[bpy.types.Image]:
    """The images that a material's nodes use, also inside groups."""
    images: set[bpy.types.Image] = set()
    for node in tree.nodes if tree else ():
        if isinstance(node, bpy.types.ShaderNodeTexImage) and node.image:
            images.add(node.image)
        elif isinstance(node, bpy.types.ShaderNodeGroup):
            images |= images_of(node.node_tree)
    return images


def render_picture(preview: Path, picture: Path, pixels: int = 512, samples: int = 32) -> None:
    """Open the .blend `preview` in place of the open file, and render its camera's view as a PNG, `picture`.

    Raises BakeError if Blender renders nothing.
    """
    bpy.ops.wm.open_mainfile(filepath=str(preview), load_ui=False, use_scripts=False)
    scene: Any = bpy.context.scene
    reset_render_settings(scene, graded=True)
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    render.resolution_x = render.resolution_y = pixels
    if hasattr(render.image_settings, "media_type"):  # Blender 5: set before the format
        render.image_settings.media_type = "IMAGE"
    render.image_settings.file_format = "PNG"
    with replacing_together(picture) as beside:
        render.filepath = render_path(beside)
        render.use_file_extension = False
        bpy.ops.render.render(write_still=True)
        if not beside.exists():
            raise BakeError(f"Blender rendered no picture of {preview}")
