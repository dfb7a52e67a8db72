# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Remove the lamps and the world of a scratch scene, to light it otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import bpy

from ..nodes import open_world

_FLAGS = ("exclude", "holdout", "indirect_only")


def take_light_away(scene: bpy.types.Scene) -> None:
    """Remove lamps from a scratch scene, as `take_lamps_away` does, and make its world black."""
    scene.world, _ = open_world("RadTex black")
    take_lamps_away(scene)


def take_lamps_away(scene: bpy.types.Scene) -> None:
    """Remove lamps from a scratch scene.

    Its collections are replaced by copies without lamps, with the same flags in view layers: the user's
    collections are not changed. The copies are removed with the scratch scene's other data. Instanced lamps
    stay, and so does the light of materials.
    """
    flags = {layer.name: list(_flags(layer.layer_collection)) for layer in scene.view_layers}
    root, copies = scene.collection, dict[bpy.types.Collection, bpy.types.Collection]()
    children = list(root.children)
    for child in children:
        root.children.unlink(child)
    for child in children:
        root.children.link(_copied(child, copies))
    _drop_lamps(root)
    for layer in scene.view_layers:
        for shown, before in zip(_tree(layer.layer_collection), flags[layer.name], strict=True):
            for name, value in before.items():
                setattr(shown, name, value)


def _copied(
    collection: bpy.types.Collection, copies: dict[bpy.types.Collection, bpy.types.Collection]
) -> bpy.types.Collection:
    """The copy of a collection, made once, with copies of its children; Blender copies its own flags."""
    if collection not in copies:
        copy = copies[collection] = cast(bpy.types.Collection, collection.copy())
        children = list(copy.children)
        for child in children:
            copy.children.unlink(child)
        for child in children:
            copy.children.link(_copied(child, copies))
        _drop_lamps(copy)
    return copies[collection]


def _drop_lamps(collection: bpy.types.Collection) -> None:
    for item in list(collection.objects):
        if item.type == "LIGHT":
            collection.objects.unlink(item)


def _tree(layer_collection: bpy.types.LayerCollection) -> Iterator[Any]:
    """All layer collections below this one, in order; a view layer's root itself has no flags."""
    for child in layer_collection.children:
        yield child
        yield from _tree(child)


def _flags(layer_collection: bpy.types.LayerCollection) -> Iterator[dict[str, bool]]:
    for child in _tree(layer_collection):
        yield {name: getattr(child, name) for name in _FLAGS}
