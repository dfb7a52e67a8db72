# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Show to camera rays what other rays see, and find out whether any material lets light through."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
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
    with _evaluated_changed(scratch, lambda item: _show(item, "shadow"), objects):
        yield


@contextmanager
def as_glossy_rays_see(scratch: bpy.types.Scene) -> Iterator[None]:
    """In renders of the scratch scene, show to camera rays what glossy rays see, as a mirror would.

    Holdouts and shadow catchers render as plain objects. The user's objects are not changed.
    """
    with _evaluated_changed(scratch, lambda item: _show(item, "glossy")):
        yield


@contextmanager
def _evaluated_changed(
    scratch: bpy.types.Scene, change: Callable[[Any], None], objects: Collection[int] | None = None
) -> Iterator[None]:
    """Change the evaluated copies of objects in renders of the scratch scene: of all, or by `session_uid`."""

    def each(_: bpy.types.Scene, graph: bpy.types.Depsgraph | None = None) -> None:
        if graph is None or graph.mode != "RENDER" or cast(Any, graph.scene).original != scratch:
            return
        for item in graph.ids:
            if isinstance(item, bpy.types.Object) and (
                objects is None or item.original.session_uid in objects
            ):
                change(item)

    heard = cast("list[Any]", bpy.app.handlers.frame_change_post)  # called after a render's evaluation
    heard.append(each)
    try:
        yield
    finally:
        heard.remove(each)


def _show(item: Any, ray: str) -> None:
    """Let the camera see an evaluated object if rays of that kind do."""
    wanted = {
        "visible_camera": getattr(item, f"visible_{ray}"),
        "is_holdout": False,
        "is_shadow_catcher": False,
    }
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
