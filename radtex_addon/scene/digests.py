# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of everything that a bake depends on, to notice if the scene has changed since the bake began.

The baked mesh and other geometry are digested to the last bit. Not noticed are changes between the slices
that are read of image and volume files beyond 64 MB, in later frames of image sequences, and in caches of gas
simulations.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..bake.key import DIGEST
from ..core.arrays import Floats
from .content_digests import Geometry, file_digest, image_contents
from .mesh.evaluated import EvaluatedMesh, render_with
from .render_settings import KEPT_OF_RENDER, LIGHT_PATHS
from .working_space import working_space

_DEPTH = 4  # levels of settings within settings, such as the points of a curve
_SHOWN = sorted(KEPT_OF_RENDER - {"engine", "threads", "threads_mode"})
_LIGHT = sorted(LIGHT_PATHS | {"dicing_rate", "feature_set", "max_subdivisions", "shading_system"})
_CURVES = ("shape", "subdivisions")
_OBJECT = ("is_holdout", "is_shadow_catcher", "pass_index", "color", "instance_type", "hide_render")
_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")
# Properties that do not change renders.
_IDLE = frozenset(
    (
        "animation_data",
        "asset_data",
        "bl_rna",
        "inputs",
        "interface",
        "internal_links",
        "library",
        "library_weak_reference",
        "original",
        "outputs",
        "override_library",
        "parent",
        "preview",
        "rna_type",
        "tag",
        "use_extra_user",
        "use_fake_user",
    )
)
# Properties of nodes that do not change renders, such as their place in the editor.
_IDLE_OF_NODES = _IDLE | {
    "color",
    "height",
    "hide",
    "label",
    "location",
    "location_absolute",
    "select",
    "show_options",
    "show_preview",
    "show_texture",
    "use_custom_color",
    "width",
    "width_hidden",
}


def mesh_digest(mesh: EvaluatedMesh) -> str:
    """Digest of a mesh's geometry, normals, attributes (including UV layers) and material indices."""
    state = hashlib.sha256()
    for array in (mesh.position, mesh.triangles, mesh.normal, mesh.material_index, *mesh.texture_space):
        _feed(state, array)
    for attribute in mesh.attributes:
        state.update(repr((attribute.name, attribute.domain, attribute.data_type)).encode())
        _feed(state, attribute.values)
    state.update(repr((mesh.flat, mesh.active_uv, mesh.active_color, mesh.render_color)).encode())
    return DIGEST + state.hexdigest()


def array_digest(array: Floats) -> str:
    """Digest of an array's shape, dtype and values."""
    state = hashlib.sha256()
    _feed(state, array)
    return DIGEST + state.hexdigest()


def matrix_digest(mesh: EvaluatedMesh) -> str:
    """Digest of the object's matrix."""
    return array_digest(mesh.matrix_world)


def scene_digests(scratch: bpy.types.Scene) -> dict[str, str]:
    """Digests of everything else that renders of the scratch scene show, by names for messages."""
    found: dict[str, str] = {}

    def read(depsgraph: bpy.types.Depsgraph) -> None:
        found.update(_of_instances(depsgraph))

    render_with(scratch, read)
    frame = scratch.frame_current + scratch.frame_subframe
    cycles, render, curves = cast(Any, scratch).cycles, scratch.render, cast(Any, scratch).cycles_curves
    return {
        **found,
        "world": _digest(_walk(scratch.world, set())),
        "light paths": _digest(
            f"{name} {getattr(of, name, None)!r}"
            for of, names in ((cycles, _LIGHT), (render, _SHOWN), (curves, _CURVES))
            for name in names
        ),
        "working colour space": working_space(),
        "frame": f"{frame:g}",
    }


def _of_instances(depsgraph: bpy.types.Depsgraph) -> dict[str, str]:
    """Digests of objects (with their geometry), of lights and of materials."""
    objects: list[str] = []
    lights: list[str] = []
    materials: dict[str, bpy.types.Material] = {}
    geometry = Geometry()
    for instance in depsgraph.object_instances:
        item = instance.object
        assert item is not None  # every instance has an object
        if item.type == "CAMERA":  # the bake has cameras of its own
            continue
        place = np.array(instance.matrix_world, dtype=np.float32).tobytes().hex()
        said = f"{item.name_full} {item.type} {instance.is_instance} {place} {_of_object(item)}"
        if item.type == "LIGHT":
            lights.append(" ".join((said, *_walk(item.data, set()))))
            continue
        objects.append(f"{said} {geometry.of(item)}")
        for material in _materials(item):
            materials[material.name_full] = material
    return {
        "objects": _digest(sorted(objects)),
        "lights": _digest(sorted(lights)),
        "materials": _digest(
            text for name in sorted(materials) for text in (name, *_walk(materials[name], set()))
        ),
    }


def _of_object(item: bpy.types.Object) -> str:
    rays = [getattr(item, f"visible_{ray}") for ray in _RAYS]
    settings = [repr(_value(getattr(item, name))) for name in _OBJECT]
    return f"{rays} {settings}"


def _materials(item: bpy.types.Object) -> Iterator[bpy.types.Material]:
    """The original materials of an evaluated object, including those that its modifiers set."""
    slots = (slot.material for slot in item.material_slots)
    for material in (*slots, *getattr(item.data, "materials", ())):
        if material is not None:
            yield cast("bpy.types.Material", material.original)


def _walk(struct: Any, seen: set[str], depth: int = _DEPTH) -> Iterator[str]:
    """Yield the settings of a data-block, or of a part of one, as text, with its node groups and images."""
    if struct is None:
        return
    if isinstance(struct, bpy.types.ID):
        name = f"{type(struct).__name__} {struct.name_full}"
        yield name
        if name in seen:
            return
        seen.add(name)
    if isinstance(struct, bpy.types.Image):
        yield _of_image(struct)
        return
    if isinstance(struct, bpy.types.NodeTree):
        yield from _walk_tree(struct, seen)
        return
    idle = _IDLE_OF_NODES if isinstance(struct, bpy.types.Node) else _IDLE
    for prop in struct.bl_rna.properties:
        if prop.identifier in idle or prop.identifier.startswith("bl_"):
            continue
        with warnings.catch_warnings(action="ignore"):  # reading properties that Blender 6 will remove
            value = getattr(struct, prop.identifier, None)
        yield from _walk_property(prop, value, seen, depth)


def _walk_property(prop: Any, value: Any, seen: set[str], depth: int) -> Iterator[str]:
    if prop.type == "COLLECTION":
        if depth:
            for item in value or ():
                yield from _walk(item, seen, depth - 1)
    elif prop.type == "POINTER":
        if isinstance(value, bpy.types.NodeTree | bpy.types.Image):
            yield from _walk(value, seen)
        elif isinstance(value, bpy.types.Text):
            yield value.as_string()
        elif isinstance(value, bpy.types.ID):
            yield f"{prop.identifier} {value.name_full}"
        elif depth:
            yield from _walk(value, seen, depth - 1)
    elif not prop.is_readonly or prop.identifier == "type":
        yield f"{prop.identifier} {_value(value)!r}"


def _walk_tree(tree: bpy.types.NodeTree, seen: set[str]) -> Iterator[str]:
    for node in tree.nodes:
        yield node.bl_idname
        yield from _walk(node, seen)
        if path := getattr(node, "filepath", ""):  # of an OSL script or an IES file
            yield file_digest(Path(bpy.path.abspath(path, library=tree.library)))
        for socket in (*node.inputs, *node.outputs):
            default = getattr(socket, "default_value", None)
            value = default.name_full if isinstance(default, bpy.types.ID) else _value(default)
            yield f"{socket.identifier} {value!r}"
    for link in tree.links:
        ends = (link.from_node, link.from_socket), (link.to_node, link.to_socket)
        yield " ".join(f"{node and node.name}.{socket and socket.identifier}" for node, socket in ends)


def _of_image(image: bpy.types.Image) -> str:
    """An image's settings and contents; its path and date may differ, as in a copy of the scene."""
    settings = (image.source, image.colorspace_settings.name, image.alpha_mode, _value(image.size))
    generated = f"{image.generated_type} {_value(image.generated_color)}"
    return f"{settings} {image_contents(image)} {generated}"


def _value(value: Any) -> Any:
    """A property's value in Python's own types; vectors and the like become lists of numbers."""
    if value is None or isinstance(value, str | bytes | int | float):
        return value
    if isinstance(value, set):
        return sorted(value)
    try:
        return np.array(value).tolist()
    except (TypeError, ValueError):
        return str(type(value))


def _feed(state: Any, array: Any) -> None:
    state.update(repr((array.shape, str(array.dtype))).encode())
    state.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8))


def _digest(texts: Iterable[str]) -> str:
    state = hashlib.sha256()
    for text in texts:
        state.update(text.encode("utf-8", "surrogateescape"))
        state.update(b"\0")
    return DIGEST + state.hexdigest()
