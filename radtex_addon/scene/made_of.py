# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender makes an object's geometry of: its own data, its modifiers, and the objects that they name.

Two evaluations of the same are the same to a user, though Blender may round them otherwise.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from .block_digests import block_settings, setting
from .content_digests import file_digest
from .mesh.attribute_arrays import stored_arrays

_DEPTH = 5  # levels of settings within settings: geometry nodes have their inputs on the fourth
_WEIGHED = 200_000  # vertices: the weights of more are not read, as each is read by itself
_READ_ONLY = frozenset(("type", "vertex_indices"))  # the read-only properties that tell something
_IDLE = frozenset(  # what editors show, what Blender notes there itself, and where it keeps caches
    (
        "bake_directory",
        "bakes",
        "bl_rna",
        "execution_time",
        "is_active",
        "name",
        "node_warnings",
        "panels",
        "persistent_uid",
        "point_cache",
        "rna_type",
        "simulation_bake_directory",
        "use_pin_to_last",
    )
)
_IDLE_STARTS = ("open_", "show_")
_MOVES_BY_UVS = frozenset(("DISPLACE", "NODES", "WARP", "WAVE"))  # modifiers


def is_made(item: bpy.types.Object) -> bool:
    """Whether modifiers make the geometry that renders of an object show."""
    return any(modifier.show_render for modifier in item.modifiers)


def drifts(item: bpy.types.Object) -> bool:
    """Whether an object's vertices may be rounded otherwise each time: moved by the UVs of a bevel."""
    kinds = [modifier.type for modifier in item.modifiers if modifier.show_render]
    return "BEVEL" in kinds and not _MOVES_BY_UVS.isdisjoint(kinds[kinds.index("BEVEL") :])


def made_of(item: bpy.types.Object) -> str:
    """A digest of what the geometry of an evaluated object is made of; "" where it is its data as they are.

    It does not tell all: simulations, and objects that nodes name, are seen by the outcome alone.
    """
    if not is_made(item):
        return ""
    state = hashlib.sha256()
    for text in _Reader().of(item):
        state.update(text.encode("utf-8", "surrogateescape") + b"\0")
    return state.hexdigest()


class _Reader:
    """Reads objects' data and modifiers as text; of what it has read before only the number."""

    def __init__(self) -> None:
        self._known: dict[str, int] = {}

    def of(self, item: bpy.types.Object) -> Iterator[str]:
        name = f"Object {item.name_full}"
        known = name in self._known
        yield f"object {item.type} {self._known.setdefault(name, len(self._known))}"
        if known:
            return
        yield from self._data(item)
        for modifier in item.modifiers:
            if modifier.show_render:
                yield from self._struct(modifier, _DEPTH)

    def _data(self, item: Any) -> Iterator[str]:
        data = item.original.data
        if data is None:
            return
        if isinstance(data, bpy.types.Volume):
            yield _of_file(data.filepath, data)
            return
        if not hasattr(data, "attributes"):
            yield from block_settings(data)
            if item.pose is not None:
                yield from (repr(setting(bone.matrix)) for bone in item.pose.bones)
            return
        state = hashlib.sha256()
        for array in stored_arrays(data):
            state.update(array.label.encode())
            state.update(array.values.tobytes())
        yield state.hexdigest()
        yield from _of_shape_keys(getattr(data, "shape_keys", None))
        if item.vertex_groups and len(getattr(data, "vertices", ())) <= _WEIGHED:
            yield from (group.name for group in item.vertex_groups)
            weights = [(each.group, each.weight) for point in data.vertices for each in point.groups]
            yield hashlib.sha256(np.array(weights, dtype=np.float32).tobytes()).hexdigest()

    def _struct(self, struct: Any, depth: int) -> Iterator[str]:
        for prop in struct.bl_rna.properties:
            name = prop.identifier
            if name in _IDLE or name.startswith(_IDLE_STARTS):
                continue
            yield from self._property(name, prop, getattr(struct, name, None), depth)
        if isinstance(struct, bpy.types.NodesModifier) and bpy.app.version < (5, 0, 0):
            for name in sorted(struct.keys()):  # the inputs, which have no properties there
                yield name
                value = int(struct[name]) if isinstance(struct[name], bool) else struct[name]  # as in files
                yield from self._block(value) if isinstance(value, bpy.types.ID) else (repr(setting(value)),)

    def _property(self, name: str, prop: Any, value: Any, depth: int) -> Iterator[str]:
        if prop.type == "COLLECTION":
            if depth:
                for each in value or ():
                    yield from self._struct(each, depth - 1)
        elif prop.type == "POINTER":
            if isinstance(value, bpy.types.ID):
                yield name
                yield from self._block(value)
            elif value is not None and depth:
                yield name
                yield from self._struct(value, depth - 1)
        elif prop.subtype in {"DIR_PATH", "FILE_PATH"}:  # a copy of the scene has other paths
            yield _of_file(value, None)
        elif not prop.is_readonly or name in _READ_ONLY:
            yield f"{name} {setting(value)!r}"

    def _block(self, block: Any) -> Iterator[str]:
        if isinstance(block, bpy.types.Object):
            yield repr(setting(block.matrix_world))
            yield from self.of(block)
        elif isinstance(block, bpy.types.Collection):
            for item in block.all_objects:
                yield from self._block(item)
        elif isinstance(block, bpy.types.NodeTree | bpy.types.Image | bpy.types.Texture):
            yield from block_settings(block)
        elif isinstance(block, bpy.types.CacheFile):
            yield _of_file(block.filepath, block)


def _of_file(path: str, block: Any) -> str:
    """A digest of the file that a data-block, or a modifier, names; "" where there is none."""
    library = None if block is None else block.library
    found = Path(bpy.path.abspath(path, library=library)) if path else None
    return file_digest(found) if found is not None and found.is_file() else ""


def _of_shape_keys(keys: Any) -> Iterator[str]:
    for key in keys.key_blocks if keys is not None else ():
        places = np.empty(3 * len(key.data), dtype=np.float32)
        if key.data and hasattr(key.data[0], "co"):
            key.data.foreach_get("co", places)
        yield hashlib.sha256(places.tobytes()).hexdigest()
        yield f"{key.value!r} {key.mute} {key.vertex_group} {key.relative_key.name}"
