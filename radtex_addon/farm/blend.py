# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The farm's .blend: a scene set up for a capture, saved without animation and with all files it needs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy

from ..core.errors import BakeError, InputError
from ..preview.save import images_of
from ..scene.digests import Looks, looks_of
from .farm_files import FarmFiles
from .farm_manifest import Manifest
from .freeze_scene import Held, hold_still, read_cached
from .self_contained import Packed, make_local, pack_files
from .sheets import animate_sheets, portal_tree, without_extras

_SCENE = "RadTex farm"


def check_images_saved() -> None:
    """Raises InputError for an image with unsaved changes: Blender would not write them."""
    for image in bpy.data.images:
        if image.is_dirty and not image.packed_files and image.type not in {"RENDER_RESULT", "COMPOSITING"}:
            raise InputError(f"image '{image.name}' has unsaved changes: save it, or pack it")


def save_draft(scratch: bpy.types.Scene, path: Path) -> tuple[Looks, Held]:
    """Write a scratch scene, with all that it uses, to a .blend.

    Returns digests of what it shows, and the animated values to fix. Raises BakeError if Blender cannot
    write.
    """
    for image in images_of(portal_tree(scratch)):
        image.pack()
    looks, cached = looks_of(scratch), read_cached(scratch)
    meshes = {bpy.data.meshes[name] for name in cached.meshes.values()}
    try:
        bpy.data.libraries.write(str(path), {scratch, *meshes}, path_remap="ABSOLUTE")
    except RuntimeError as error:
        raise BakeError(f"{path}: Blender cannot write it ({error}); choose another folder") from error
    return looks, cached


def finish_blend(
    draft: Path, scene_name: str, files: FarmFiles, manifest: Manifest, looks: Looks, cached: Held
) -> Packed:
    """Open a draft, and save from it the .blend that farms render; the session is empty afterwards.

    Returns the files beside the .blend, and the files of this machine that go with it. Raises InputError for
    what a farm cannot render.
    """
    bpy.ops.wm.open_mainfile(filepath=str(draft), load_ui=False, use_scripts=False)
    try:
        scene: Any = bpy.data.scenes[scene_name]
        without_extras(scene)
        libraries = make_local()
        hold_still(scene, looks, cached, manifest.sheets)
        scene.name = _SCENE
        animate_sheets(scene, manifest)
        packed = pack_files(files.folder)
        bpy.ops.wm.save_as_mainfile(filepath=str(files.blend), compress=True, relative_remap=False)
    except RuntimeError as error:
        raise BakeError(f"{files.blend}: Blender cannot make it ({' '.join(str(error).split())})") from error
    finally:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return replace(packed, carried=libraries + packed.carried)
