# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What casts shadows, shown to camera rays; and whether any of it lets light through."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any, cast

import bpy

# Shader nodes that let rays go on where they are, and those that may: by a socket that is not at its default.
_CLEAR = frozenset({"BSDF_TRANSPARENT", "BSDF_RAY_PORTAL", "SCRIPT", "HOLDOUT"})
_OPACITY = {"BSDF_PRINCIPLED": "Alpha"}


@contextmanager
def casters_seen(scratch: bpy.types.Scene, objects: Collection[int]) -> Iterator[None]:
    """Let camera rays of the scratch scene's renders see, of these objects, what shadow rays see.

    `objects` are `session_uid`s. Those that hold out, or catch shadows, are plain ones to these renders.
    Written are the copies of objects that a render evaluates for itself, which nobody else ever sees: so
    instances follow too, and no object of the user's is touched, not even for a moment.
    """

    def show(_: bpy.types.Scene, graph: bpy.types.Depsgraph | None = None) -> None:
        if graph is None or graph.mode != "RENDER" or cast(Any, graph.scene).original != scratch:
            return
        for item in graph.ids:
            if isinstance(item, bpy.types.Object) and item.original.session_uid in objects:
                _show_as_caster(item)

    heard = cast("list[Any]", bpy.app.handlers.frame_change_post)  # a render sends it, once it has evaluated
    heard.append(show)
    try:
        yield
    finally:
        heard.remove(show)


def _show_as_caster(item: bpy.types.Object) -> None:
    wanted = {"visible_camera": item.visible_shadow, "is_holdout": False, "is_shadow_catcher": False}
    for name, value in wanted.items():
        if getattr(item, name) != value:
            setattr(item, name, value)


def show_all_collections(scene: bpy.types.Scene) -> None:
    """Take out of a scratch scene's view layers what hides collections from camera rays alone."""
    for layer in scene.view_layers:
        waiting: list[Any] = [layer.layer_collection]
        while waiting:
            collection = waiting.pop()
            collection.holdout = collection.indirect_only = False
            waiting.extend(collection.children)


def may_be_clear() -> bool:
    """Whether any material that is in use may let rays through, or fill a volume."""
    return any(_is_clear(material.node_tree, set()) for material in bpy.data.materials if material.users)


def _is_clear(tree: Any, known: set[Any]) -> bool:
    if tree is None or tree in known:
        return False
    known.add(tree)
    for node in tree.nodes:
        if node.type in _CLEAR or (node.type == "GROUP" and _is_clear(node.node_tree, known)):
            return True
        if node.type == "OUTPUT_MATERIAL" and node.inputs["Volume"].is_linked:
            return True
        if node.type in _OPACITY:
            alpha = node.inputs[_OPACITY[node.type]]
            if alpha.is_linked or alpha.default_value < 1:
                return True
    return False
