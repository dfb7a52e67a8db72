# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Show shadow casters to camera rays, and find out whether any material lets light through."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any, cast

import bpy

# Shader nodes that let rays through, and those that do if a socket is not at its default.
_CLEAR = frozenset({"BSDF_TRANSPARENT", "BSDF_RAY_PORTAL", "SCRIPT", "HOLDOUT"})
_OPACITY = {"BSDF_PRINCIPLED": "Alpha"}


@contextmanager
def shadow_casters_visible(scratch: bpy.types.Scene, objects: Collection[int]) -> Iterator[None]:
    """In renders of the scratch scene, show those objects to camera rays that shadow rays see.

    `objects` are `session_uid`s. Holdouts and shadow catchers render as plain objects. Only the evaluated
    copies that belong to a render are changed: so instances follow too, and the user's objects are never
    touched.
    """

    def show(_: bpy.types.Scene, graph: bpy.types.Depsgraph | None = None) -> None:
        if graph is None or graph.mode != "RENDER" or cast(Any, graph.scene).original != scratch:
            return
        for item in graph.ids:
            if isinstance(item, bpy.types.Object) and item.original.session_uid in objects:
                _show_as_caster(item)

    heard = cast("list[Any]", bpy.app.handlers.frame_change_post)  # called after a render's evaluation
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
    """Turn off Holdout and Indirect Only of all collections in a scratch scene's view layers."""
    for layer in scene.view_layers:
        waiting: list[Any] = [layer.layer_collection]
        while waiting:
            collection = waiting.pop()
            collection.holdout = collection.indirect_only = False
            waiting.extend(collection.children)


def may_be_clear() -> bool:
    """Whether any material in use may let rays through, or has a volume."""
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
