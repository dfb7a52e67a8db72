# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of a collection that can be baked."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..core.errors import InputError
from ..scene.scratch import find_view_layer
from ..scene.surfaces import may_have_faces
from .swap import is_on, original_of

_LISTED = 8  # most names in a message


def meshes_of(
    collection: bpy.types.Collection | None, view_layer: bpy.types.ViewLayer
) -> list[bpy.types.Object]:
    """The meshes of a collection, and of those in it, that are in the view layer, sorted by name.

    What is hidden from render, such as a modifier's cutter, is left out, unless its bake is shown.
    """
    found = [] if collection is None else [item for item in collection.all_objects if may_have_faces(item)]
    here = set(view_layer.objects)
    seen = (item for item in found if item in here and (not item.hide_render or is_on(item)))
    return sorted(seen, key=lambda item: item.name)


def objects_named(
    scene: bpy.types.Scene, collection: str, view_layer: str | None = None
) -> tuple[bpy.types.Object, ...]:
    """All objects of the scene's collection of that name, sorted by name; originals, not previews.

    Raises InputError, which lists the scene's collections, if there is none of that name, or if it has no
    mesh that `meshes_of` finds.
    """
    layer = find_view_layer(scene, view_layer)
    known = {each.name: each for each in _collections(scene)}
    if collection not in known:
        raise InputError(
            f"there is no collection '{collection}' in scene '{scene.name}': it has {_listed(list(known))}"
        )
    if not meshes_of(known[collection], layer):
        others = [name for name, each in known.items() if meshes_of(each, layer)]
        remedy = f"those that have some are {_listed(others)}" if others else "no collection has any"
        raise InputError(f"collection '{collection}' has no mesh that is seen in renders: {remedy}")
    found = sorted(known[collection].all_objects, key=lambda item: item.name)
    return tuple(dict.fromkeys(original_of(item) or item for item in found))


def _collections(scene: bpy.types.Scene) -> Iterator[bpy.types.Collection]:
    yield scene.collection
    yield from scene.collection.children_recursive


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(f"'{name}'" for name in names[:_LISTED]) + more
