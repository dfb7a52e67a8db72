# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An open file that needs no other: libraries are made local, images packed, volumes lie beside it."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import InputError

log = logging.getLogger(__name__)

FILES = "files"  # the folder beside the .blend for what it cannot hold


def make_local() -> None:
    """Take everything linked or overridden for the file's own."""
    linked = list(_linked())
    while linked:
        for block in linked:
            block.make_local(clear_liboverride=True)
        left = list(_linked())
        if len(left) == len(linked):  # what nothing local uses
            break
        linked = left
    libraries: Any = bpy.data.libraries
    for library in list(libraries):
        libraries.remove(library)


def pack_files(folder: Path) -> tuple[str, ...]:
    """Pack what a .blend can hold, and put volumes beside it; the open file lies in `folder`.

    Returns the names of the files beside it, relative to the folder. Raises InputError, by name, for what
    needs a file that can be neither.
    """
    cast(Any, bpy.data).orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
    _pack_images()
    for font in bpy.data.fonts:
        if font.packed_file is None and not font.filepath.startswith("<"):
            font.pack()
    _keep_light_shapes()
    beside = tuple(_copy_volume(volume, folder) for volume in bpy.data.volumes)
    _refuse_other_files()
    return beside


def _pack_images() -> None:
    image: Any
    for image in bpy.data.images:
        packed = any(file.packed_file is not None for file in image.packed_files)
        if packed or image.type in {"RENDER_RESULT", "COMPOSITING"} or image.source == "VIEWER":
            continue
        if image.source == "GENERATED" and not image.is_dirty:
            continue
        try:
            image.pack()
        except RuntimeError:
            log.warning("image '%s': its file is missing, and the bake shows it in pink", image.name)


def _keep_light_shapes() -> None:
    """Hold the text of IES files, which shape lamps."""
    for light in bpy.data.lights:
        tree: Any = light.node_tree
        for node in tree.nodes if tree is not None else ():
            if node.type == "TEX_IES" and node.mode == "EXTERNAL" and node.filepath:
                text = bpy.data.texts.load(bpy.path.abspath(node.filepath, library=light.library))
                node.mode, node.ies = "INTERNAL", text


def _copy_volume(volume: Any, folder: Path) -> str:
    source = Path(bpy.path.abspath(volume.filepath, library=volume.library))
    name = f"{FILES}/{volume.session_uid}-{source.name}"
    target = folder / name
    target.parent.mkdir(exist_ok=True)
    try:
        shutil.copyfile(source, target)
    except OSError as error:
        raise InputError(
            f"volume '{volume.name}': {source} cannot be read ({error.strerror}): put it back"
        ) from error
    volume.filepath = f"//{name}"
    return name


def _refuse_other_files() -> None:
    owner: Any
    for owner, paths in cast(Any, bpy.data).file_path_map().items():
        if isinstance(owner, bpy.types.Image | bpy.types.VectorFont | bpy.types.Volume | bpy.types.Text):
            continue
        for path in sorted(paths):
            if Path(bpy.path.abspath(path)).exists():
                raise InputError(
                    f"'{owner.name}' needs the file {path}, which no .blend can hold: do without it, "
                    "or bake without a farm"
                )


def _linked() -> Iterator[Any]:
    for kind in bpy.data.bl_rna.properties:
        if kind.type == "COLLECTION" and kind.identifier not in {"all_ids", "libraries"}:
            for block in getattr(bpy.data, kind.identifier):
                if block.library is not None or block.override_library is not None:
                    yield block
