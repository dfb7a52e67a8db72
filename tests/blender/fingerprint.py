# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All that a user could find changed: every property of every data-block, and the handlers."""

from __future__ import annotations

import hashlib
import warnings
from functools import cache
from typing import Any

import bpy
import numpy as np

NOT_THE_USERS = (
    "original",
    "bl_rna",
    "rna_type",
    "is_dirty",
    "all_ids",
    "window_managers",
    "screens",
    "workspaces",
)
# Set up when first asked for; those of UV layers move the layers in memory, beneath whoever reads them.
LAZY = ("depsgraph", "storage_type", "vertex_selection", "edge_selection", "pin")
SKIPPED = frozenset(NOT_THE_USERS + LAZY)
DEPTH = 9
LONG = 64  # items; longer collections are hashed
# Ends of links, and panels that sockets lie in: their tree has them, and leads from each to all others.
_IN_A_TREE = (bpy.types.Node, bpy.types.NodeSocket, bpy.types.NodeTreeInterfaceItem)


def fingerprint() -> dict[str, object]:
    """Path of a property -> its value, for the whole file."""
    found: dict[str, object] = {}
    _properties.cache_clear()
    for scene in bpy.data.scenes:
        for layer in scene.view_layers:
            layer.update()  # scenes that were never shown are not set up yet
            found[f"scenes[{scene.name_full}].view_layers[{layer.name}].chosen"] = _chosen(layer)
    for kind in bpy.data.bl_rna.properties:
        if kind.type == "COLLECTION" and kind.identifier not in SKIPPED:
            blocks = getattr(bpy.data, kind.identifier)
            found[kind.identifier] = [(block.name_full, block.session_uid, block.users) for block in blocks]
            with warnings.catch_warnings(action="ignore"):  # what Blender 6 will remove is still there
                for block in blocks:
                    _walk(block, f"{kind.identifier}[{block.name_full}]", found, DEPTH)
    for name in dir(bpy.app.handlers):
        if isinstance(functions := getattr(bpy.app.handlers, name), list):
            found[f"handlers.{name}"] = [id(function) for function in functions]
    for scene in bpy.data.scenes:  # which Blender points at the active object with the first step to undo
        found.pop(f"scenes[{scene.name_full}].tool_settings.particle_edit.object", None)
    window = bpy.context.window_manager.windows[0] if bpy.context.window_manager.windows else None
    found["scene"] = bpy.context.scene.name, bpy.context.mode, window and window.scene.name
    return found


def _chosen(layer: Any) -> tuple[str, list[tuple[str, bool, bool]]]:
    """The active object's name, and of each object whether it is selected, and hidden, in a view layer."""
    active = layer.objects.active
    states = [
        (item.name_full, item.select_get(view_layer=layer), item.hide_get(view_layer=layer))
        for item in layer.objects
    ]
    return active.name_full if active is not None else "", states


def differences(before: dict[str, object], after: dict[str, object]) -> dict[str, tuple[object, object]]:
    """What differs between two fingerprints."""
    return {
        path: (before.get(path), after.get(path))
        for path in before.keys() | after.keys()
        if before.get(path) != after.get(path)
    }


@cache
def _properties(kind: Any) -> list[tuple[str, Any]]:
    """Names and properties of a kind of struct. Forgotten at each fingerprint: extensions add to them."""
    named = ((prop.identifier, prop) for prop in kind.bl_rna.properties)
    return [(name, prop) for name, prop in named if name not in SKIPPED and not name.startswith("bl_")]


def _walk(struct: Any, path: str, found: dict[str, object], depth: int) -> None:
    kind: Any = type(struct)
    for name, prop in _properties(kind):
        try:
            value = getattr(struct, name)
        except (AttributeError, RuntimeError, ValueError, TypeError):
            continue
        _note(prop, value, f"{path}.{name}", found, depth)


def _note(prop: Any, value: Any, path: str, found: dict[str, object], depth: int) -> None:
    if prop.type == "COLLECTION":
        _note_items(value, path, found, depth)
    elif prop.type == "POINTER":
        if value is None or isinstance(value, bpy.types.ID):
            found[path] = value and value.name_full
        if isinstance(value, _IN_A_TREE):
            found[path] = value.name
        elif value is not None and (not isinstance(value, bpy.types.ID) or _own_tree(value)) and depth:
            _walk(value, path, found, depth - 1)
    elif getattr(prop, "is_array", False):
        found[path] = np.array(value).tolist()
    elif prop.type == "ENUM" and prop.is_enum_flag:
        found[path] = sorted(value)
    else:
        found[path] = value


def _own_tree(value: bpy.types.ID) -> bool:
    """Whether it is the tree of its owner alone: groups are among the file's data-blocks."""
    return isinstance(value, bpy.types.NodeTree) and value.is_embedded_data


def _note_items(value: Any, path: str, found: dict[str, object], depth: int) -> None:
    found[path] = len(value) if len(value) <= LONG else _digest(value)
    for index, item in enumerate(value if len(value) <= LONG and depth else ()):
        if isinstance(item, bpy.types.ID):
            found[f"{path}[{index}]"] = item.name_full
        elif item is not None:
            _walk(item, f"{path}[{index}]", found, depth - 1)


def _digest(collection: Any) -> str:
    """A hash of a long collection's coordinates and other bulk data."""
    state = hashlib.sha256(str(len(collection)).encode())
    first = collection[0]
    for prop in first.bl_rna.properties:
        if prop.type not in {"FLOAT", "INT", "BOOLEAN"} or prop.identifier in SKIPPED:
            continue
        width = prop.array_length if prop.is_array else 1
        dtype = {"FLOAT": np.float32, "INT": np.int32, "BOOLEAN": np.bool_}[prop.type]
        values: Any = np.zeros(len(collection) * max(width, 1), dtype=dtype)
        try:
            collection.foreach_get(prop.identifier, values)
        except (AttributeError, RuntimeError, TypeError):
            continue
        state.update(values.tobytes())
    return state.hexdigest()
