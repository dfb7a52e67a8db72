# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A digest of what each object shows in a render: equal digests are the same surfaces in the same places."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, TypeAlias

import bpy
import numpy as np

from ..scene.mesh.evaluated import ATTRIBUTE_LAYOUT, render_with

Looks: TypeAlias = dict[str, str]  # a digest for each object, by its name

_EDITING = (".select", ".uv_select", ".hide", ".vs.", ".es.", ".pn.")  # of no consequence to a picture


def looks_of(scene: bpy.types.Scene) -> Looks:
    """The digests of all objects of the scene's render, and of their instances."""
    found: list[Looks] = []
    render_with(scene, lambda depsgraph: found.append(_looks(depsgraph)))
    return found[0]


def differing(one: Looks, other: Looks) -> list[str]:
    """Names of objects whose digests differ, or that are in one of the two only; sorted."""
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))


def _looks(depsgraph: bpy.types.Depsgraph) -> Looks:
    states: dict[str, Any] = {}
    shapes: dict[int, bytes] = {}
    for instance in depsgraph.object_instances:
        item: Any = instance.object
        owner = instance.parent if instance.is_instance else item
        if owner is None or item is None or item.type in {"CAMERA", "EMPTY"}:
            continue
        state = states.setdefault(owner.original.name, hashlib.sha256())
        place = np.array(instance.matrix_world, dtype=np.float32) + np.float32(0)  # no zero is negative
        state.update(f"{item.name} {item.type} {instance.is_instance} {instance.random_id}".encode())
        state.update(place.tobytes())
        key = item.data.as_pointer() if item.data is not None else 0
        if key not in shapes:
            shapes[key] = _shape(item)
        state.update(shapes[key])
    return {name: state.hexdigest() for name, state in states.items()}


def _shape(item: Any) -> bytes:
    state = hashlib.sha256()
    data = item.data
    if isinstance(data, bpy.types.Volume):
        state.update(f"{Path(data.filepath).name} {data.grids.frame}".encode())
    elif hasattr(data, "attributes"):
        for attribute in sorted(data.attributes, key=lambda attribute: attribute.name):
            _feed_attribute(state, attribute)
        if isinstance(data, bpy.types.Mesh):
            normals = np.empty(3 * len(data.loops), dtype=np.float32)
            data.corner_normals.foreach_get("vector", normals)
            state.update(normals.tobytes())
    elif item.type != "LIGHT":
        state.update(np.array(item.bound_box, dtype=np.float32).tobytes())
    return state.digest()


def _feed_attribute(state: Any, attribute: Any) -> None:
    if attribute.name.startswith(_EDITING):
        return
    state.update(f"{attribute.name} {attribute.domain} {attribute.data_type}".encode())
    if attribute.data_type not in ATTRIBUTE_LAYOUT:
        return
    prop, width, kind = ATTRIBUTE_LAYOUT[attribute.data_type]
    values: Any = np.empty(width * len(attribute.data), dtype=kind)
    attribute.data.foreach_get(prop, values)
    state.update(values.tobytes())
