# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the object to bake, explain why an object cannot be baked, and say where it is."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.errors import InputError
from .mesh.copy import SHOWN
from .scratch import find_view_layer
from .surfaces import may_have_faces

_VISIBILITY = frozenset(("hide_render", "hide_viewport"))
_NAMED = 8  # objects that a message names at most


def find_object(scene: bpy.types.Scene, name: str, view_layer: str | None = None) -> bpy.types.Object:
    """The object with faces called `name` that renders in `view_layer` of `scene` (the first, if None).

    Raises InputError if no object or several objects have that name, or if the object is of another type or
    hidden from render.
    """
    layer = find_view_layer(scene, view_layer)
    found = scene.objects.get(name)
    if found is None:
        raise InputError(_not_there(scene, name))
    check_only_one(scene.objects, name)
    if not may_have_faces(found):
        raise InputError(_without_faces(found))
    reason = _why_hidden(found, layer)
    if reason is not None:
        raise InputError(f"object '{name}' is hidden from render: {reason}")
    return found


def is_linked(item: bpy.types.ID) -> bool:
    """Whether a data-block is linked from a library; older stubs declare that each is."""
    return cast(Any, item).library is not None


def check_only_one(items: Iterable[bpy.types.Object], name: str) -> None:
    """Raise InputError if several of the objects are called `name`, which happens with libraries."""
    found = [item for item in items if item.name == name]
    if len(found) > 1:
        homes = " and ".join(item.library.name if is_linked(item) else "this file" for item in found)
        raise InputError(
            f"several objects are called '{name}', of {homes}: rename one, a linked one in its own file"
        )


def _not_there(scene: bpy.types.Scene, name: str) -> str:
    elsewhere = bpy.data.objects.get(name)
    if elsewhere is not None:
        owners = [item.name for item in scene.objects if _instances(item, elsewhere)]
        if owners:
            return (
                f"object '{name}' is in scene '{scene.name}' only as an instance of '{owners[0]}':"
                f" join its instances, or make them real (Object > Apply), and bake these"
            )
        return f"object '{name}' is not in scene '{scene.name}': link it to one of the scene's collections"
    meshes = [item.name for item in scene.objects if may_have_faces(item)]
    close = difflib.get_close_matches(name, meshes, n=3, cutoff=0.5)
    close += [item for item in meshes if item.casefold() == name.casefold() and item not in close]
    if close:
        return f"no object '{name}' in scene '{scene.name}': did you mean {_listed(close)}?"
    if meshes:
        more = f" and {len(meshes) - _NAMED} more" if len(meshes) > _NAMED else ""
        told = f"{_listed(sorted(meshes)[:_NAMED])}{more}"
        return f"no object '{name}' in scene '{scene.name}': its meshes are {told}"
    return f"no object '{name}' in scene '{scene.name}': it has no mesh at all"


def _listed(names: list[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)


def _instances(item: bpy.types.Object, of: bpy.types.Object) -> bool:
    collection = item.instance_collection if item.instance_type == "COLLECTION" else None
    return collection is not None and of.name in collection.all_objects


def _without_faces(found: bpy.types.Object) -> str:
    types = cast("bpy.types.EnumProperty", found.bl_rna.properties["type"]).enum_items
    kind = types[found.type].name.lower()
    if found.type == "EMPTY" and found.instance_type == "COLLECTION":
        return (
            f"object '{found.name}' instances a collection: join its instances, or make them real "
            "(Object > Apply), and bake these"
        )
    if found.type in {"CURVES", "POINTCLOUD", "GREASEPENCIL"}:
        return f"object '{found.name}' is a {kind}, not a mesh: convert it to a mesh (Object > Convert)"
    return f"object '{found.name}' is a {kind}, not a mesh: name a mesh object"


def _why_hidden(found: bpy.types.Object, layer: bpy.types.ViewLayer) -> str | None:
    """Why an object is hidden from renders of a view layer, with the remedy; None if it renders."""
    if found.hide_render and SHOWN in cast("Any", found):
        return "its preview is shown in its place; switch that off"
    if found.hide_render:
        return "enable it in renders (the camera icon in the Outliner)"
    if found.instance_type != "NONE" and not found.show_instancer_for_render:
        return "it is an instancer; enable Show Instancer > Render in its Instancing panel"
    if any(True for _ in rendered_homes(found, layer)):
        return None
    homes = [
        home for home in _homes(layer.layer_collection, None) if found.name in home[0].collection.objects
    ]
    hiders = [hider for home, hider in homes if hider is not None and not home.exclude]
    if hiders:
        return f"enable its collection '{hiders[0].name}' in renders (the camera icon in the Outliner)"
    names = _listed(sorted(home.name for home, _ in homes))
    return f"include its collection {names} in view layer '{layer.name}'"


def is_rendered(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> bool:
    """Whether a view layer renders an object by itself, instances aside."""
    return not item.hide_render and any(True for _ in rendered_homes(item, layer))


def rendered_homes(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> Iterator[bpy.types.LayerCollection]:
    """The collections by which a view layer renders an object; the object's own visibility is not checked."""
    for home, hider in _homes(layer.layer_collection, None):
        if hider is None and not home.exclude and item.name in home.collection.objects:
            yield home


def _homes(
    layer: bpy.types.LayerCollection, hider: bpy.types.Collection | None
) -> Iterator[tuple[bpy.types.LayerCollection, bpy.types.Collection | None]]:
    """A layer collection and all below it, each with the outermost collection that hides it from render."""
    if hider is None and layer.collection.hide_render:
        hider = layer.collection
    yield layer, hider
    for child in layer.children:
        yield from _homes(child, hider)


def animates_visibility(item: bpy.types.Object) -> bool:
    """Whether an action or a driver decides if the object is seen in views or renders."""
    return any(curve.data_path in _VISIBILITY and not curve.mute for curve in curves_of(item))


def curves_of(item: bpy.types.Object) -> list[bpy.types.FCurve]:
    """The curves and drivers that animate an object's own properties, muted ones too."""
    data = item.animation_data
    if data is None:
        return []
    strips = [strip for track in data.nla_tracks for strip in track.strips]
    curves: list[bpy.types.FCurve] = list(data.drivers)
    played = [(data.action, data.action_slot), *((strip.action, strip.action_slot) for strip in strips)]
    for action, slot in played:
        curves += _curves(action, slot)
    return curves


def _curves(action: bpy.types.Action | None, slot: bpy.types.ActionSlot | None) -> Iterator[bpy.types.FCurve]:
    if action is None or slot is None:
        return
    for layer in action.layers:
        for strip in layer.strips:
            bag = cast("bpy.types.ActionKeyframeStrip", strip).channelbag(slot)
            if bag is not None:
                yield from bag.fcurves


def world_box(item: Any, matrix_world: Any) -> tuple[Floats, Floats]:
    """The least and the greatest coordinates, (3,) each, of the corners of an object's box under a matrix."""
    matrix = np.array(matrix_world)
    corners = np.array(item.bound_box) @ matrix[:3, :3].T + matrix[:3, 3]
    return corners.min(axis=0), corners.max(axis=0)


def about_matrix(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> Floats:
    """An object's matrix (4, 4), from object to world, where no render may be made to ask for it.

    Blender does not evaluate for a viewport what is hidden there (the monitor icon), and leaves its
    `matrix_world` as it was: then it is the object's own transform and its parents', constraints left out.
    """
    graph = layer.depsgraph
    if graph is not None and cast(Any, item.evaluated_get(graph)).is_evaluated:
        return np.array(item.matrix_world, dtype=np.float64)
    own = np.array(item.matrix_basis, dtype=np.float64)
    if item.parent is None:
        return own
    placed: Floats = (
        about_matrix(item.parent, layer) @ np.array(item.matrix_parent_inverse, dtype=np.float64) @ own
    )
    return placed
