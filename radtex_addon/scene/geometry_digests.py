# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of geometry: of meshes as they are baked, and of what renders show of an object.

Where modifiers make the geometry, two evaluations are the same to a user though Blender may round them
otherwise. So a digest of what it is made of counts there: the object's own data, its modifiers, and the
objects that they name; and the values that vary count as sums (`core.near_digest`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.near_digest import DIGEST, NearDigest, NearHash, hash_of
from .block_digests import block_settings, file_digest, setting
from .mesh.attribute_arrays import PLACES, bulk, stored_arrays
from .surfaces import MADE_TO_MESHES, shown_mesh

if TYPE_CHECKING:
    from .mesh.evaluated import EvaluatedMesh

MADE_OF, DRIFTS = "radtex_made_of", "radtex_drifts"  # custom properties of meshes that were joined of others
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


def mesh_digest(mesh: EvaluatedMesh) -> NearDigest:
    """Digest of a mesh's geometry, normals, attributes (including UV layers) and material indices."""
    exact = _exact_digest(mesh)
    if not mesh.made_of:
        return NearDigest(exact)
    near = NearHash(f"{mesh.made_of} {_layers_of(mesh)}")
    for array in (mesh.position, mesh.normal, *mesh.texture_space):
        near.feed("", array, varies=mesh.drifts)
    for numbers in (mesh.triangles, mesh.material_index):
        near.feed("", numbers)
    for attribute in sorted(mesh.attributes, key=lambda attribute: attribute.name):  # they have no order
        near.feed(f"{attribute.name} {attribute.domain} {attribute.data_type}", attribute.values, varies=True)
    return near.digest(exact)


def _exact_digest(mesh: EvaluatedMesh) -> str:
    state = hashlib.sha256()
    for array in (mesh.position, mesh.triangles, mesh.normal, mesh.material_index, *mesh.texture_space):
        _feed(state, array)
    for attribute in mesh.attributes:
        state.update(repr((attribute.name, attribute.domain, attribute.data_type)).encode())
        _feed(state, attribute.values)
    state.update(_layers_of(mesh).encode())
    return DIGEST + state.hexdigest()


def _layers_of(mesh: EvaluatedMesh) -> str:
    return repr((mesh.flat, mesh.active_uv, mesh.active_color, mesh.render_color))


def array_digest(array: Floats) -> str:
    """Digest of an array's shape, dtype and values."""
    state = hashlib.sha256()
    _feed(state, array)
    return DIGEST + state.hexdigest()


def matrix_digest(mesh: EvaluatedMesh) -> str:
    """Digest of the object's matrix."""
    return array_digest(mesh.matrix_world)


def _feed(state: Any, array: Any) -> None:
    state.update(repr((array.shape, str(array.dtype))).encode())
    state.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8))


class Geometry:
    """Digests of evaluated objects' geometry; data that instances share are read once.

    Where modifiers make it, the digest tells what it is near to. `by_outcome` it always does, and what it is
    made of does not count: a mesh with its modifiers is like one to which they were applied.
    """

    def __init__(self, by_outcome: bool = False) -> None:
        self._by_outcome = by_outcome
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
        if item.type not in MADE_TO_MESHES:
            return self._digest(item, data)
        with shown_mesh(item) as mesh:
            return NearDigest(hashlib.sha256().hexdigest()) if mesh is None else self._digest(item, mesh)

    def _digest(self, item: bpy.types.Object, data: Any) -> NearDigest:
        exact, nears, shown = hashlib.sha256(), self._by_outcome or is_made(item), []
        for array in stored_arrays(data):
            exact.update(array.label.encode())
            exact.update(array.values.tobytes())
            if nears and array.domain != "EDGE":
                shown.append(array)
        if not nears:
            return NearDigest(exact.hexdigest())
        near, moved = NearHash("" if self._by_outcome else made_of(item)), drifts(item)
        for array in sorted(shown, key=lambda array: array.label):  # Realize Instances has no order
            near.feed(array.label, array.values, varies=moved or array.label != PLACES)
        if isinstance(data, bpy.types.Mesh):
            near.feed("normals", bulk(data.corner_normals, "vector", 3, np.float32), varies=moved)
        return near.digest(exact.hexdigest())


def is_made(item: bpy.types.Object) -> bool:
    """Whether modifiers make the geometry that renders of an object show, or made what was joined in it."""
    return _is_joined(item) or any(modifier.show_render for modifier in item.modifiers)


def drifts(item: bpy.types.Object) -> bool:
    """Whether an object's vertices may be rounded otherwise each time: moved by the UVs of a bevel."""
    if _is_joined(item):
        return bool(cast(Any, item.data)[DRIFTS])
    kinds = [modifier.type for modifier in item.modifiers if modifier.show_render]
    return "BEVEL" in kinds and not _MOVES_BY_UVS.isdisjoint(kinds[kinds.index("BEVEL") :])


def made_of(item: bpy.types.Object) -> str:
    """A digest of what the geometry of an evaluated object is made of; "" where it is its data as they are.

    It does not tell all: simulations, and objects that nodes name, are seen by the outcome alone.
    """
    if _is_joined(item):
        return str(cast(Any, item.data)[MADE_OF])
    return hash_of(_Reader().of(item)) if is_made(item) else ""


def _is_joined(item: bpy.types.Object) -> bool:
    return isinstance(item.data, bpy.types.Mesh) and MADE_OF in cast(Any, item.data)


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
