# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of evaluated objects' geometry, of what Cycles renders of it: edges are of no consequence."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.near_digest import NearDigest, NearHash
from .content_digests import file_digest
from .made_of import drifts, is_made, made_of
from .mesh.attribute_arrays import PLACES, bulk, stored_arrays

_MADE_OF_MESH = {"CURVE", "FONT", "META", "SURFACE"}  # object types that Cycles converts to meshes


class Geometry:
    """Digests of evaluated objects' geometry; data that instances share are read once.

    Where modifiers make it, the digest tells what it is near to.
    """

    def __init__(self) -> None:
        self._known: dict[int, NearDigest] = {}

    def of(self, item: bpy.types.Object) -> NearDigest:
        """Digest of an object's faces, hair or points with all attributes, or of its volume's file.

        It is empty for an object without any.
        """
        data: Any = item.data
        if data is None:
            return NearDigest("")
        key = data.as_pointer()
        if key not in self._known:
            self._known[key] = self._read(item, data)
        return self._known[key]

    def _read(self, item: bpy.types.Object, data: Any) -> NearDigest:
        if isinstance(data, bpy.types.Volume):
            path = Path(bpy.path.abspath(data.filepath, library=data.library))
            return NearDigest(hashlib.sha256(file_digest(path).encode()).hexdigest())
        if item.type not in _MADE_OF_MESH or isinstance(data, bpy.types.Mesh):
            return self._digest(item, data)
        with suppress(RuntimeError):  # no mesh, as for a metaball that belongs to another object
            made = self._digest(item, item.to_mesh())
            item.to_mesh_clear()
            return made
        return NearDigest(hashlib.sha256().hexdigest())

    def _digest(self, item: bpy.types.Object, data: Any) -> NearDigest:
        exact, made, shown = hashlib.sha256(), is_made(item), []
        for array in stored_arrays(data):
            exact.update(array.label.encode())
            exact.update(array.values.tobytes())
            if made and array.domain != "EDGE":
                shown.append(array)
        if not made:
            return NearDigest(exact.hexdigest())
        near, moved = NearHash(made_of(item)), drifts(item)
        for array in sorted(shown, key=lambda array: array.label):  # Realize Instances has no order
            near.feed(array.label, array.values, varies=moved or array.label != PLACES)
        if isinstance(data, bpy.types.Mesh):
            near.feed("normals", bulk(data.corner_normals, "vector", 3, np.float32), varies=moved)
        return near.digest(exact.hexdigest())
