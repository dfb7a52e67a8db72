# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find objects whose geometry nodes use the active camera: a bake has its own camera, elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

_ASKS = "GeometryNodeInputActiveCamera"


def camera_dependent(layer: bpy.types.ViewLayer) -> list[str]:
    """Warnings about rendered objects of a view layer whose modifiers follow the active camera."""
    layer.update()  # or it lists objects that a script has just removed
    return [
        f"object '{item.name}' follows the active camera by its modifier '{name}', and a bake has "
        "a camera of its own: name the camera in an Object Info node instead"
        for item in layer.objects
        if not item.hide_render
        for name in _asking(item)
    ]


def _asking(item: bpy.types.Object) -> Iterator[str]:
    modifiers: Any = item.modifiers
    for modifier in modifiers:
        if modifier.type == "NODES" and modifier.show_render and _asks(modifier.node_group, set()):
            yield modifier.name


def _asks(tree: Any, seen: set[Any]) -> bool:
    if tree is None or tree in seen:
        return False
    seen.add(tree)
    for node in tree.nodes:
        if node.mute:
            continue
        if node.bl_idname == _ASKS and any(output.is_linked for output in node.outputs):
            return True
        if node.type == "GROUP" and _asks(node.node_tree, seen):
            return True
    return False
