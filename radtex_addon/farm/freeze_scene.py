# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the open file look the same at every frame: a farm's frames are sheets, not the user's animation.

Animated properties are fixed at their values. Objects that are moved by simulations, caches or the frame
number are found by comparing frames; their evaluated meshes and matrices replace what moves them. What still
moves is refused by name.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import bpy
from mathutils import Matrix

from ..core.errors import InputError
from ..scene.digests import Looks, differing, looks_of
from ..scene.mesh.evaluated import render_with
from ..scene.objects import is_rendered
from .animation import animated_values, hold, hold_images

_CACHED = {  # modifiers whose results depend on frames before, or on files
    "CLOTH",
    "DYNAMIC_PAINT",
    "FLUID",
    "MESH_CACHE",
    "MESH_SEQUENCE_CACHE",
    "SOFT_BODY",
}
_TRACKED = {"CAMERA_SOLVER", "FOLLOW_TRACK", "OBJECT_SOLVER", "TRANSFORM_CACHE"}  # constraints by the frame
_ON_DISK = {"FLUID", "DYNAMIC_PAINT"}  # modifiers whose caches are files
_BAKE_IT = "apply it (Object > Convert > Mesh), bake its cache into the .blend, or bake without a farm"
_REMEDY = "apply what moves it (Object > Convert > Mesh, or Make Instances Real), or bake without a farm"


@dataclass(frozen=True, eq=False)
class Held:
    """Objects by name: their matrices, and the names of the meshes that they show."""

    matrices: dict[str, Matrix]
    meshes: dict[str, str]


def read_cached(scene: bpy.types.Scene) -> Held:
    """Read all objects that depend on earlier frames or other files; makes their meshes."""
    return _read(scene, {item.name for item in scene.objects if _is_cached(item)})


def hold_still(scene: bpy.types.Scene, expected: Looks, cached: Held, last: int) -> None:
    """Make the open file's `scene` look at the frames 1 to `last` as it does now, which is `expected`.

    Raises InputError for objects and images that change with time, or are not as expected.
    """
    hold(render_with(scene, animated_values))
    hold_images(scene)
    _pin(scene, cached)
    check_looks(scene, expected)
    now = scene.frame_current, scene.frame_subframe
    if moving := _moving(scene, expected, last):
        scene.frame_set(now[0], subframe=now[1])
        _pin(scene, _read(scene, moving))
        if still := _moving(scene, expected, last):
            raise InputError(
                f"object '{min(still)}' changes with time, and cannot be held still for a farm: {_REMEDY}"
            )
    scene.frame_set(1)


def check_looks(scene: bpy.types.Scene, expected: Looks) -> None:
    """Raises InputError if an object of the open file's `scene` does not look as expected."""
    if changed := differing(looks_of(scene), expected):
        raise InputError(
            f"object '{changed[0]}' looks otherwise in a copy of the file, as by a simulation "
            f"that is not baked: {_REMEDY}"
        )


def _moving(scene: bpy.types.Scene, expected: Looks, last: int) -> set[str]:
    """Names of the objects that do not look as expected at some frame."""
    found: set[str] = set()
    for frame in sorted({1, min(2, last), (1 + last) // 2, last}):
        scene.frame_set(frame)
        found.update(differing(looks_of(scene), expected))
    return found


def _is_cached(item: Any) -> bool:
    return (
        item.rigid_body is not None
        or any(modifier.type in _CACHED and modifier.show_render for modifier in item.modifiers)
        or any(constraint.type in _TRACKED for constraint in item.constraints)
    )


def _read(scene: bpy.types.Scene, names: Collection[str]) -> Held:
    held = Held({}, {})

    def read(depsgraph: Any) -> None:
        for evaluated in _evaluated(depsgraph, names):
            name = evaluated.original.name
            held.matrices[name] = evaluated.matrix_world.copy()
            if evaluated.original.type == "MESH" and not evaluated.original.particle_systems:
                mesh = bpy.data.meshes.new_from_object(
                    evaluated, preserve_all_data_layers=True, depsgraph=depsgraph
                )
                held.meshes[name] = mesh.name

    if names:
        render_with(scene, read)
    return held


def _evaluated(depsgraph: Any, names: Collection[str]) -> Iterator[Any]:
    for block in depsgraph.ids:
        if isinstance(block, bpy.types.Object) and block.original.name in names:
            yield block.original.evaluated_get(depsgraph)


def _pin(scene: Any, held: Held) -> None:
    """Give objects exactly the meshes and matrices that were read, and remove what could change them."""
    if not held.matrices:
        return
    if scene.rigidbody_world is not None:
        scene.rigidbody_world.collection = None
    anchor = bpy.data.objects.new("RadTex anchor", None)
    scene.collection.objects.link(anchor)
    for name, matrix in held.matrices.items():
        item: Any = scene.objects[name]
        if name in held.meshes:
            item.data = bpy.data.meshes[held.meshes[name]]
            item.modifiers.clear()
        item.constraints.clear()
        item.parent, item.parent_type = anchor, "OBJECT"
        _place(item, matrix)


def _place(item: Any, matrix: Matrix) -> None:
    """Store an object's matrix in the parent inverse: location, rotation and scale would round it."""
    item.matrix_parent_inverse = matrix
    item.matrix_basis = Matrix.Identity(4)
    item.delta_location = item.delta_rotation_euler = (0, 0, 0)
    item.delta_rotation_quaternion = (1, 0, 0, 0)
    item.delta_scale = (1, 1, 1)


def check_holdable(scene: bpy.types.Scene) -> None:
    """Raises InputError for objects that change with time and are no meshes, which could be stored."""
    for item in _rendered(scene):
        for modifier in item.modifiers:
            if not modifier.show_render:
                continue
            if modifier.type == "PARTICLE_SYSTEM":
                _refuse_particles(item, modifier.particle_system)
            elif _is_smoke(modifier):
                raise InputError(f"object '{item.name}' holds smoke, and no .blend its cache: {_REMEDY}")
        if isinstance(item.data, bpy.types.Volume) and item.data.is_sequence:
            raise InputError(
                f"volume '{item.data.name}' is a sequence: show one file of it (its Sequence option), "
                "or bake without a farm"
            )


def _is_smoke(modifier: Any) -> bool:
    if modifier.type != "FLUID" or modifier.fluid_type != "DOMAIN":
        return False
    return bool(modifier.domain_settings.domain_type == "GAS")


def _refuse_particles(item: Any, system: Any) -> None:
    if system.settings.type == "EMITTER":
        raise InputError(f"object '{item.name}' emits particles ('{system.name}'): {_REMEDY}")
    if system.use_hair_dynamics:
        raise InputError(f"object '{item.name}': the hair '{system.name}' is simulated: {_REMEDY}")


def check_caches_travel(scene: bpy.types.Scene) -> None:
    """Raises InputError for simulations whose results are in files, or not baked."""
    for item in _rendered(scene):
        for modifier in item.modifiers:
            if modifier.show_render and (fault := _cache_fault(modifier)):
                raise InputError(
                    f"object '{item.name}': {fault} of its modifier '{modifier.name}': {_BAKE_IT}"
                )


def _cache_fault(modifier: Any) -> str:
    """Why a modifier's results do not travel with the .blend; "" if they do."""
    if modifier.type in _ON_DISK:
        return "no .blend holds the files"
    cache = getattr(modifier, "point_cache", None)
    if modifier.type == "PARTICLE_SYSTEM":
        system = modifier.particle_system
        dynamic = system.settings.type == "EMITTER" or system.use_hair_dynamics
        cache = system.point_cache if dynamic else None
    if cache is None:
        return ""
    if not cache.is_baked:
        return "nothing is baked of the simulation"
    return "no .blend holds the disk cache" if cache.use_disk_cache else ""


def _rendered(scene: bpy.types.Scene) -> Iterable[Any]:
    layers = list(scene.view_layers)
    return (item for item in scene.objects if any(is_rendered(item, layer) for layer in layers))
