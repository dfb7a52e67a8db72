# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Let an object follow its preview: whoever moves the preview means the object, which is hidden meanwhile.

The preview's record has the transform that it began with. Only what the user has changed of it since is taken
over, so that animation, drivers and constraints of the object go on as they were.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import blake2b
from typing import Any

import numpy as np

from ..scene.objects import curves_of

_VECTORS = (
    "location",
    "rotation_euler",
    "rotation_quaternion",
    "rotation_axis_angle",
    "scale",
    "delta_location",
    "delta_rotation_euler",
    "delta_rotation_quaternion",
    "delta_scale",
)
_PARENT = ("parent_type", "parent_bone")


def transform_record(copy: Any) -> dict[str, Any]:
    """What a preview's custom property keeps of its transform, parent and mesh, to compare with later."""
    return {
        "vectors": {name: list(getattr(copy, name)) for name in _VECTORS},
        "rotation_mode": copy.rotation_mode,
        "parent": _parent_of(copy),
        "has_action": _action_of(copy) is not None,
        "mesh": _shape_of(copy.data),
    }


def follow_preview(original: Any, copy: Any, record: Any) -> bool:
    """Give an object what the user has changed of its preview: transform, parent, and a first action.

    The preview's children become the object's. Returns whether the object may have moved. A preview whose
    mesh was changed is not followed: its transform may have been applied to the mesh.
    """
    _take_children(original, copy)
    if not _is_followed(copy, record):
        return False
    moved = _take_transform(original, copy, record)
    action = _action_of(copy)
    if action is not None and not record["has_action"] and _action_of(original) is None:
        data = original.animation_data or original.animation_data_create()
        data.action = action
        data.action_slot = copy.animation_data.action_slot
        moved = True
    return moved


@contextmanager
def following(pairs: Iterable[tuple[Any, Any, Any]]) -> Iterator[None]:
    """Within the context, objects stand where their previews do: of each original, copy and record."""
    before: list[tuple[Any, dict[str, Any]]] = []
    try:
        for original, copy, record in pairs:
            if _is_followed(copy, record):
                held = _held(original)
                if _take_transform(original, copy, record):
                    before.append((original, held))
        yield
    finally:
        for original, held in before:
            _put_back(original, held)


def _is_followed(copy: Any, record: Any) -> bool:
    return record is not None and bool(record["mesh"] == _shape_of(copy.data))


def _take_transform(original: Any, copy: Any, record: Any) -> bool:
    parent_changed = _parent_of(copy) != record["parent"]
    if parent_changed and not _is_above(original, copy.parent):
        _set_parent(original, copy.parent, copy)
    if changed_mode := copy.rotation_mode != record["rotation_mode"]:
        original.rotation_mode = copy.rotation_mode
    animated = {(curve.data_path, curve.array_index) for curve in curves_of(copy) if not curve.mute}
    moved: bool = parent_changed or changed_mode
    for name in _VECTORS:
        mine, theirs = getattr(original, name), getattr(copy, name)
        for index, before in enumerate(record["vectors"][name]):
            if theirs[index] != before and (name, index) not in animated:
                mine[index] = theirs[index]
                moved = True
    return moved


def _parent_of(item: Any) -> str:
    """What an object is parented to and how, as one text; a renamed parent counts as another."""
    if item.parent is None:
        return ""
    inverse = np.array(item.matrix_parent_inverse, dtype=np.float32).ravel().tolist()
    return f"{item.parent.name_full}\n{[getattr(item, name) for name in _PARENT]}\n{inverse}"


def _is_above(item: Any, parent: Any) -> bool:
    """Whether an object would become its own ancestor below `parent`."""
    while parent is not None and parent != item:
        parent = parent.parent
    return parent is not None


def _set_parent(item: Any, parent: Any, like: Any) -> None:
    """Parent an object to `parent` in the way that `like` is parented, which Blender would reset."""
    how = {name: getattr(like, name) for name in _PARENT}
    vertices, inverse = tuple(like.parent_vertices), like.matrix_parent_inverse.copy()
    item.parent = parent
    for name, value in how.items():
        setattr(item, name, value)
    item.parent_vertices = vertices
    item.matrix_parent_inverse = inverse


def _take_children(original: Any, copy: Any) -> None:
    """What was parented to a preview, which is about to go, is parented to its object."""
    for child in copy.children:
        if not _is_above(child, original):
            _set_parent(child, original, child)


def _held(item: Any) -> dict[str, Any]:
    """All that `_take_transform` may change of an object."""
    held: dict[str, Any] = {name: tuple(getattr(item, name)) for name in _VECTORS}
    held |= {name: getattr(item, name) for name in (*_PARENT, "parent", "rotation_mode")}
    held["parent_vertices"] = tuple(item.parent_vertices)
    held["matrix_parent_inverse"] = item.matrix_parent_inverse.copy()
    return held


def _put_back(item: Any, held: dict[str, Any]) -> None:
    if item.parent != held["parent"]:
        item.parent = held["parent"]
    for name, value in held.items():
        if name != "parent":
            setattr(item, name, value)


def _action_of(item: Any) -> Any:
    return None if item.animation_data is None else item.animation_data.action


def _shape_of(mesh: Any) -> str:
    """A digest of the places of a mesh's vertices."""
    places = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", places)
    return blake2b(places.tobytes(), digest_size=16).hexdigest()
