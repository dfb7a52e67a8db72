# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of the user's scene to render in, so that the user's own data are never changed.

The copy shares objects, collections and the world with the user's scene, and has its own render settings,
view layers, camera, markers and frame. Nothing has to be restored, since nothing of the user's is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

import bpy

from ..core.errors import InputError
from .checks.refusals import refuse_unbaked_rigid_bodies
from .render_settings import reset_render_settings, take_overrides
from .working_space import check_working_space

# Blender fills these by itself (assets, the window), or they hold no data of the user's.
_NOT_DATA = frozenset(
    (
        "all_ids",
        "brushes",
        "libraries",
        "paint_curves",
        "palettes",
        "screens",
        "window_managers",
        "workspaces",
    )
)
_HANDLERS = ("render_", "frame_change_", "depsgraph_update_", "composite_")


@contextmanager
def scratch_scene(
    scene: bpy.types.Scene, view_layer: str | None = None, keep: Sequence[bpy.types.ID] = ()
) -> Iterator[bpy.types.Scene]:
    """Copy `scene` to render its `view_layer` (the first that renders, if None); remove the copy at exit.

    At exit, also after an exception, all data-blocks made meanwhile are removed too, except those in `keep`
    (a list that may grow inside) and data-blocks that these use. Handlers of other add-ons are off meanwhile:
    they could change the bake, or fail on the copy. Raises InputError for an unknown view layer, an unknown
    working colour space, or rigid bodies that a copy would put back to their start.
    """
    layer = find_view_layer(scene, view_layer).name
    check_working_space()
    refuse_unbaked_rigid_bodies(scene)
    with new_data_removed(keep), _sleeping_handlers():
        scratch = cast("bpy.types.Scene", scene.copy())
        try:
            scratch.name = "RadTex scratch"
            _remove_overrides(scratch, layer)
            yield scratch
        finally:
            remove_scene(scratch)


@contextmanager
def scene_copied(scratch: bpy.types.Scene) -> Iterator[bpy.types.Scene]:
    """A copy of a scratch scene, for renders whose settings must not affect later renders.

    At exit it is removed, with every data-block that was made meanwhile.
    """
    with new_data_removed():
        copy = cast("bpy.types.Scene", scratch.copy())
        try:
            yield copy
        finally:
            remove_scene(copy)


def render_scene(scene: bpy.types.Scene, write: bool = False) -> set[str]:
    """Render a scene at its own frame, and `write` its output file if wanted. Returns the operator's result.

    Blender's operator takes the frame from the scene of the context, whichever scene it renders.
    """
    with cast(Any, bpy.context).temp_override(scene=scene, view_layer=scene.view_layers[0]):
        return cast("set[str]", bpy.ops.render.render(write_still=write, scene=scene.name))


def remove_scene(scene: bpy.types.Scene) -> None:
    """Remove a scene of ours, with the persistent data of its renders.

    Blender would keep these data: whenever something is linked, remapped or removed afterwards, it tags the
    scene in their dependency graph, and so writes to freed memory or crashes.
    """
    scene.render.use_persistent_data = False  # frees them
    bpy.data.scenes.remove(scene)


@contextmanager
def new_data_removed(keep: Sequence[bpy.types.ID] = ()) -> Iterator[None]:
    """At exit, remove all data-blocks made inside, except those in `keep` and data-blocks that these use."""
    before = {block.session_uid for block in _data_blocks()}
    try:
        yield
    finally:
        _remove_new(before, keep)


def find_view_layer(scene: bpy.types.Scene, name: str | None) -> bpy.types.ViewLayer:
    """The named view layer of `scene`, or the first that renders if `name` is None.

    Raises InputError if there is none of that name.
    """
    layers = list(scene.view_layers)
    if name is None:
        return next((layer for layer in layers if layer.use), layers[0])
    for layer in layers:
        if layer.name == name:
            return layer
    known = ", ".join(f"'{layer.name}'" for layer in layers)
    raise InputError(f"scene '{scene.name}' has no view layer '{name}': it has {known}")


def _remove_overrides(scene: bpy.types.Scene, view_layer: str) -> None:
    """Remove from a scene copy everything that would alter single renders of one view layer."""
    scene.animation_data_clear()  # animated render settings would override those of the captures
    scene.timeline_markers.clear()  # so would a marker's camera override ours
    reset_render_settings(scene)
    for layer in scene.view_layers:
        layer.use = layer.name == view_layer
    layer = scene.view_layers[view_layer]
    layer.use_grease_pencil = False  # the GPU draws it, which rounds the whole picture to half floats
    take_overrides(scene, layer)


@contextmanager
def _sleeping_handlers() -> Iterator[None]:
    handlers = bpy.app.handlers
    names = [name for name in dir(handlers) if name.startswith(_HANDLERS)]
    saved: dict[str, list[Callable[..., object]]] = {name: list(getattr(handlers, name)) for name in names}
    try:
        for name in names:
            getattr(handlers, name).clear()
        yield
    finally:
        for name, functions in saved.items():
            getattr(handlers, name)[:] = functions


def _data_blocks() -> Iterator[bpy.types.ID]:
    for kind in bpy.data.bl_rna.properties:
        if kind.type == "COLLECTION" and kind.identifier not in _NOT_DATA:
            yield from getattr(bpy.data, kind.identifier)


def _remove_new(before: set[int], keep: Iterable[bpy.types.ID]) -> None:
    made = (block for block in _data_blocks() if block.session_uid not in before)
    new = [block for block in made if cast("Any", block).library is None]  # 4.5's stubs know no local blocks
    kept = _with_what_they_use(set(keep), new)
    bpy.data.batch_remove([block for block in new if block not in kept])


def _with_what_they_use(kept: set[bpy.types.ID], new: list[bpy.types.ID]) -> set[bpy.types.ID]:
    if not kept:
        return kept
    users = bpy.data.user_map(subset=new)
    while True:
        more = {block for block in new if block not in kept and users[block] & kept}
        if not more:
            return kept
        kept |= more


@contextmanager
def at_frame(scene: bpy.types.Scene, frame: int | None) -> Iterator[None]:
    """Set a scene to a frame, and back to its own frame at exit; None changes nothing.

    Values of animated properties that were changed but not keyed are lost, as with any change of frame in
    Blender. Raises InputError if rigid bodies would have to be simulated up to that frame.
    """
    if frame is None:
        yield
        return
    before, part = scene.frame_current, scene.frame_subframe
    try:
        scene.frame_set(frame)
        refuse_unbaked_rigid_bodies(scene)
        yield
    finally:
        scene.frame_set(before, subframe=part)
