# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of a scene's large data: geometry, images and other files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..bake.key import DIGEST
from ..formats.disk.regular import open_regular
from .mesh.evaluated import ATTRIBUTE_LAYOUT

_WHOLE = 64 << 20  # bytes: of larger files only evenly spaced slices are read
_SLICES = 64
_CORNERS = ".corner_vert"  # other attributes whose names begin with a dot only matter to the editor
_MADE_OF_MESH = {"CURVE", "FONT", "META", "SURFACE"}  # object types that Cycles converts to meshes


class Geometry:
    """Digests of evaluated objects' geometry; data that instances share are read once."""

    def __init__(self) -> None:
        self._known: dict[int, str] = {}

    def of(self, item: bpy.types.Object) -> str:
        """Digest of an object's faces, hair or points with all attributes, or of its volume file; else ""."""
        data: Any = item.data
        if data is None:
            return ""
        key = data.as_pointer()
        if key not in self._known:
            state = hashlib.sha256()
            for part in _parts(item, data):
                state.update(part)
            self._known[key] = state.hexdigest()
        return self._known[key]


def file_digest(path: Path) -> str:
    """Digest of a file's size and contents (of large files only slices); "" if it cannot be read."""
    with suppress(OSError), open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        state = hashlib.sha256(str(size).encode())
        for start, length in _slices(size):
            file.seek(start)
            state.update(file.read(length))
        return DIGEST + state.hexdigest()
    return ""


def image_contents(image: Any) -> str:
    """Digests of the pixels of a `bpy.types.Image`: painted and not saved, packed, or in its files."""
    if image.is_dirty and image.source in {"FILE", "GENERATED"} and image.size[0]:
        pixels = np.empty(image.size[0] * image.size[1] * image.channels, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        return DIGEST + hashlib.sha256(pixels.tobytes()).hexdigest()
    packed = [file.packed_file.data for file in image.packed_files if file.packed_file]
    if packed:
        return " ".join(hashlib.sha256(data).hexdigest() for data in packed)
    path = bpy.path.abspath(image.filepath, library=image.library)
    numbers = [str(tile.number) for tile in image.tiles] if image.source == "TILED" else [""]
    return " ".join(file_digest(Path(path.replace("<UDIM>", number))) for number in numbers)


def _slices(size: int) -> Iterator[tuple[int, int]]:
    if size <= _WHOLE:
        yield 0, size
        return
    length = _WHOLE // _SLICES
    for number in range(_SLICES):
        yield (size - length) * number // (_SLICES - 1), length


def _parts(item: bpy.types.Object, data: Any) -> Iterator[bytes]:
    if isinstance(data, bpy.types.Volume):
        yield file_digest(Path(bpy.path.abspath(data.filepath, library=data.library))).encode()
    elif item.type in _MADE_OF_MESH and not isinstance(data, bpy.types.Mesh):
        with suppress(RuntimeError):  # no mesh, as for a metaball that belongs to another object
            yield from _arrays(item.to_mesh())
            item.to_mesh_clear()
    else:
        yield from _arrays(data)


def _arrays(data: Any) -> Iterator[bytes]:
    """Yield all attributes of a mesh, hair or a point cloud, and the first corners of a mesh's faces."""
    for layer in getattr(data, "attributes", ()):
        if (layer.name.startswith(".") and layer.name != _CORNERS) or layer.data_type not in ATTRIBUTE_LAYOUT:
            continue
        name, width, dtype = ATTRIBUTE_LAYOUT[layer.data_type]
        yield f"{layer.name} {layer.domain} {layer.data_type}".encode()
        yield _bulk(layer.data, name, width, dtype)
    if isinstance(data, bpy.types.Mesh):
        yield _bulk(data.polygons, "loop_start", 1, np.int32)


def _bulk(collection: Any, name: str, width: int, dtype: type[np.generic]) -> bytes:
    values = np.empty(len(collection) * width, dtype=dtype)
    collection.foreach_get(name, values)
    return values.tobytes()
