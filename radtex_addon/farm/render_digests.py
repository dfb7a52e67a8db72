# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A digest of what each object shows in a render: like digests are the same surfaces in the same places."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, TypeAlias

import bpy
import numpy as np

from ..core.near_digest import NearDigest, NearHash, joined
from ..scene.made_of import drifts
from ..scene.mesh.attribute_arrays import PLACES, bulk, stored_arrays
from ..scene.mesh.evaluated import render_with

Looks: TypeAlias = dict[str, NearDigest]  # a digest for each object, by its name


def looks_of(scene: bpy.types.Scene) -> Looks:
    """The digests of all objects of the scene's render, and of their instances."""
    found: list[Looks] = []
    render_with(scene, lambda depsgraph: found.append(_looks(depsgraph)))
    return found[0]


def differing(one: Looks, other: Looks) -> list[str]:
    """Names of objects whose digests differ, or that are in one of the two only; sorted."""
    none = NearDigest("")
    return sorted(
        name for name in one.keys() | other.keys() if not one.get(name, none).is_like(other.get(name, none))
    )


def _looks(depsgraph: bpy.types.Depsgraph) -> Looks:
    said: dict[str, list[str]] = {}
    shown: dict[str, list[NearDigest]] = {}
    shapes: dict[int, NearDigest] = {}
    for instance in depsgraph.object_instances:
        item: Any = instance.object
        owner = instance.parent if instance.is_instance else item
        if owner is None or item is None or item.type in {"CAMERA", "EMPTY"}:
            continue
        name = owner.original.name
        place = np.array(instance.matrix_world, dtype=np.float32) + np.float32(0)  # no zero is negative
        text = f"{item.name} {item.type} {instance.is_instance} {instance.random_id} {place.tobytes().hex()}"
        said.setdefault(name, []).append(text)
        key = item.data.as_pointer() if item.data is not None else 0
        if key not in shapes:
            shapes[key] = _shape(item)
        shown.setdefault(name, []).append(shapes[key])
    return {name: _joined(shown[name], texts) for name, texts in said.items()}


def _joined(shapes: list[NearDigest], texts: list[str]) -> NearDigest:
    exact = hashlib.sha256(" ".join((*texts, *(shape.exact for shape in shapes))).encode()).hexdigest()
    return joined(exact, shapes, texts)


def _shape(item: Any) -> NearDigest:
    data = item.data
    exact, near = hashlib.sha256(), NearHash("")
    if isinstance(data, bpy.types.Volume):
        exact.update(f"{Path(data.filepath).name} {data.grids.frame}".encode())
    elif hasattr(data, "attributes"):
        moved = drifts(item)
        for array in sorted(stored_arrays(data), key=lambda array: array.label):
            if array.domain != "EDGE":
                exact.update(array.label.encode() + array.values.tobytes())
                near.feed(array.label, array.values, varies=moved or array.label != PLACES)
        if isinstance(data, bpy.types.Mesh):
            normals = bulk(data.corner_normals, "vector", 3, np.float32)
            exact.update(normals.tobytes())
            near.feed("normals", normals, varies=moved)
        return near.digest(exact.hexdigest())
    elif item.type != "LIGHT":
        exact.update(np.array(item.bound_box, dtype=np.float32).tobytes())
    return NearDigest(exact.hexdigest())
