# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of everything that a bake depends on, to notice if the scene has changed since the bake began.

The baked mesh and other geometry are digested to the last bit. Not noticed are changes between the slices
that are read of image and volume files beyond 64 MB, in later frames of image sequences, and in caches of gas
simulations.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.near_digest import DIGEST, NearDigest, NearHash, joined
from .block_digests import block_settings, digest_of, setting
from .geometry_digests import Geometry
from .mesh.evaluated import EvaluatedMesh, render_with
from .render_settings import KEPT_OF_RENDER, LIGHT_PATHS
from .working_space import working_space

_SHOWN = sorted(KEPT_OF_RENDER - {"engine", "threads", "threads_mode"})
_LIGHT = sorted(LIGHT_PATHS | {"dicing_rate", "feature_set", "max_subdivisions", "shading_system"})
_CURVES = ("shape", "subdivisions")
_OBJECT = ("is_holdout", "is_shadow_catcher", "pass_index", "color", "instance_type", "hide_render")
_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


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


def scene_digests(scratch: bpy.types.Scene) -> dict[str, str]:
    """Digests of everything else that renders of the scratch scene show, by names for messages."""
    found: dict[str, str] = {}

    def read(depsgraph: bpy.types.Depsgraph) -> None:
        found.update(_of_instances(depsgraph))

    render_with(scratch, read)
    frame = scratch.frame_current + scratch.frame_subframe
    return {
        **found,
        "world": digest_of(block_settings(scratch.world)),
        "light paths": light_paths_digest(scratch),
        "working colour space": working_space(),
        "frame": f"{frame:g}",
    }


def light_paths_digest(scratch: bpy.types.Scene) -> str:
    """Digest of the scratch scene's settings of how light travels and what renders show."""
    cycles, render, curves = cast(Any, scratch).cycles, scratch.render, cast(Any, scratch).cycles_curves
    return digest_of(
        f"{name} {getattr(of, name, None)!r}"
        for of, names in ((cycles, _LIGHT), (render, _SHOWN), (curves, _CURVES))
        for name in names
    )


def _of_instances(depsgraph: bpy.types.Depsgraph) -> dict[str, str]:
    """Digests of objects (with their geometry), of lights and of materials."""
    objects: list[tuple[str, NearDigest]] = []
    lights: list[str] = []
    materials: dict[str, bpy.types.Material] = {}
    geometry = Geometry()
    for instance in depsgraph.object_instances:
        item = instance.object
        assert item is not None  # every instance has an object
        if item.type == "CAMERA":  # the bake has cameras of its own
            continue
        place = np.array(instance.matrix_world, dtype=np.float32).tobytes().hex()
        said = f"{item.name_full} {item.type} {instance.is_instance} {place} {object_settings(item)}"
        if item.type == "LIGHT":
            lights.append(" ".join((said, *block_settings(item.data))))
            continue
        objects.append((said, geometry.of(item)))
        for material in materials_of(item):
            materials[material.name_full] = material
    return {
        "objects": str(_joined(objects)),
        "lights": digest_of(sorted(lights)),
        "materials": digest_of(
            text for name in sorted(materials) for text in (name, *block_settings(materials[name]))
        ),
    }


def _joined(objects: list[tuple[str, NearDigest]]) -> NearDigest:
    """One digest of what is said of each object, and of its geometry's, in no order."""
    objects = sorted(objects, key=lambda each: (each[0], each[1].of))
    exact = digest_of(sorted(f"{said} {shape.exact}" for said, shape in objects))
    return joined(exact, (shape for _, shape in objects), (said for said, _ in objects))


def object_settings(item: bpy.types.Object) -> str:
    """What rays see of an object, its empty material slots, and settings that shaders know, as text."""
    rays = [getattr(item, f"visible_{ray}") for ray in _RAYS]
    settings = [repr(setting(getattr(item, name))) for name in _OBJECT]
    empty = [slot.material is None for slot in item.material_slots]  # `materials_of` leaves these out
    return f"{rays} {settings} {empty}"


def materials_of(item: bpy.types.Object) -> Iterator[bpy.types.Material]:
    """The original materials of an evaluated object, including those that its modifiers set."""
    slots = (slot.material for slot in item.material_slots)
    for material in (*slots, *getattr(item.data, "materials", ())):
        if material is not None:
            yield cast("bpy.types.Material", material.original)


def _feed(state: Any, array: Any) -> None:
    state.update(repr((array.shape, str(array.dtype))).encode())
    state.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8))
