# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What casts shadows, shown to camera rays; and whether any of it lets light through."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

import bpy

# Shader nodes that let rays go on where they are, and those that may: by a socket that is not at its default.
_CLEAR = frozenset({"BSDF_TRANSPARENT", "BSDF_RAY_PORTAL", "SCRIPT", "HOLDOUT"})
_OPACITY = {"BSDF_PRINCIPLED": "Alpha"}


@contextmanager
def casters_seen(objects: Collection[int]) -> Iterator[None]:
    """Let camera rays see, of these objects, what shadow rays see; then all is as it was.

    `objects` are `session_uid`s. Those that hold out, or catch shadows, are plain ones meanwhile. Few objects
    need any change.
    """
    before: list[tuple[Any, str, bool]] = []
    try:
        for item in (item for item in bpy.data.objects if item.session_uid in objects):
            wanted = {
                "visible_camera": item.visible_shadow,
                "is_holdout": False,
                "is_shadow_catcher": False,
            }
            for name, value in wanted.items():
                now = getattr(item, name)
                if now != value:
                    before.append((item, name, now))
                    setattr(item, name, value)
        yield
    finally:
        for item, name, value in reversed(before):
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
