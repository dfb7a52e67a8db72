# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A .blend for farms: a scene set up for a capture, saved without animation and with all files it needs.

Its animation has a sheet per frame, or a sheet in another light, each written as a picture.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..bake.plan import sheet_seed
from ..core.errors import BakeError, InputError
from ..cycles.path_ends import light_tree
from ..cycles.portal import FIRST_ROW
from ..preview.save import images_of
from ..scene.digests import Looks, looks_of
from .animation import curves_of
from .freeze_scene import Held, check_looks, hold_still, read_cached
from .self_contained import PackedFiles, make_local

_SCENE = "RadTex farm"


@dataclass(frozen=True)
class SheetFrames:
    """What frames 1, 2 … of a .blend show: the sheets with the numbers `sheet`, of so many rows of buckets.

    The pictures are written to `output`, with the `note` in their headers. The bake has the `seed`. The nodes
    of `light_tree` that are labelled as in `values` take these, one for every frame.
    """

    sheet: Sequence[int]
    sheet_rows: int
    seed: int
    output: str
    note: str
    values: Mapping[str, Sequence[float]] = field(default_factory=dict)


def check_seed(seed: int, sheets: int) -> None:
    """Raises InputError for a seed that keyframes cannot store exactly: they are single-precision floats."""
    if sheets > 1 and np.floor(np.float32(seed) + np.float32(0.5)) != seed:
        raise InputError(f"seed {seed}: a farm's frames hold no such number, give one below {2**23}")


def animate_sheets(scene: bpy.types.Scene, frames: SheetFrames) -> None:
    """Make each frame render what it shows, and write its picture with the job's name in the header."""
    rows = [0.5 + frames.sheet_rows * sheet for sheet in frames.sheet]
    seeds = [sheet_seed(frames.seed, sheet) for sheet in frames.sheet]
    _key_node(portal_tree(scene), FIRST_ROW, rows)
    for label, values in frames.values.items():
        _key_node(light_tree(scene), label, values)
    _key(scene, "cycles.seed", seeds)
    scene.frame_start, scene.frame_end, scene.frame_step = 1, len(frames.sheet), 1
    scene.use_preview_range = False
    render = scene.render
    render.frame_map_old = render.frame_map_new = 100
    render.use_border = render.use_crop_to_border = False
    render.filepath = frames.output
    render.image_settings.exr_codec = "ZIP"  # loses nothing, and tells by its sums of what was damaged
    _stamp(render, frames.note)
    scene.frame_set(1)


def portal_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    """The nodes that send the camera's rays to their texels."""
    slots = (slot for item in scene.objects for slot in item.material_slots)
    trees = (slot.material.node_tree for slot in slots if slot.material is not None)
    return next(tree for tree in trees if tree and any(node.label == FIRST_ROW for node in tree.nodes))


def _key_node(tree: Any, label: str, values: Sequence[float]) -> None:
    node = next(node for node in tree.nodes if node.label == label)
    _key(tree, f'nodes["{node.name}"].outputs[0].default_value', values)


def _key(owner: Any, path: str, values: Sequence[float]) -> None:
    """Keyframe a property with a value per frame from 1 on, without interpolation."""
    for frame, value in enumerate(values, 1):
        of, _, name = path.rpartition(".")
        setattr(owner.path_resolve(of), name, value)
        owner.keyframe_insert(path, frame=frame)
    curve = next(curve for curve in curves_of(owner) if curve.data_path == path)
    for point in curve.keyframe_points:
        point.interpolation = "CONSTANT"
    found = [curve.evaluate(frame) for frame in range(1, len(values) + 1)]
    if found != list(values):
        raise BakeError(
            f"Blender keeps no keyframes of {path}: it makes {found} of {list(values)}; report this"
        )


def _stamp(render: Any, note: str) -> None:
    """Make Blender write the job and the frame into each picture's header, and nothing else."""
    for prop in render.bl_rna.properties:
        if prop.identifier.startswith("use_stamp") and prop.type == "BOOLEAN":
            setattr(render, prop.identifier, False)
    render.metadata_input = "SCENE"
    render.use_stamp_note, render.stamp_note_text = True, note
    render.use_stamp_frame = True


def without_extras(scene: bpy.types.Scene) -> None:
    """Remove what no frame shows: compositing, the sequencer, other scenes."""
    anything = cast(Any, scene)
    anything.sequence_editor_clear()
    if hasattr(anything, "compositing_node_group"):  # Blender 5
        anything.compositing_node_group = None
    elif anything.node_tree is not None:
        anything.node_tree.nodes.clear()
    for manager in bpy.data.window_managers:
        for window in manager.windows:
            window.scene = scene
    for other in list(bpy.data.scenes):
        if other != scene:
            bpy.data.scenes.remove(other)


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
    draft: Path,
    scene_name: str,
    blend: Path,
    frames: SheetFrames,
    looks: Looks,
    cached: Held,
    pack: Callable[[], PackedFiles],
) -> PackedFiles:
    """Open a draft, and save from it the .blend that farms render; the session is empty afterwards.

    `pack` makes the open file independent of others. Returns the files beside the .blend, and the files of
    this machine that go with it. Raises InputError for what a farm cannot render.
    """
    bpy.ops.wm.open_mainfile(filepath=str(draft), load_ui=False, use_scripts=False)
    try:
        scene: Any = bpy.data.scenes[scene_name]
        without_extras(scene)
        libraries = make_local()
        hold_still(scene, looks, cached, len(frames.sheet))
        scene.name = _SCENE
        animate_sheets(scene, frames)
        packed = pack()
        check_looks(scene, looks)  # packing removes what is not used
        bpy.ops.wm.save_as_mainfile(filepath=str(blend), compress=True, relative_remap=False)
    except RuntimeError as error:
        raise BakeError(f"{blend}: Blender cannot make it ({' '.join(str(error).split())})") from error
    finally:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return replace(packed, carried=libraries + packed.carried)
