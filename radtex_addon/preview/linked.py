# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews of linked objects: while the file is saved, local copies replace their linked collections.

The contents of a linked collection come from its library: a saved preview that used one would show the
originals again, whatever replaced them when it was saved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import cast

import bpy

from ..core.errors import InputError
from ..scene.objects import is_linked

_FLAGS = ("exclude", "holdout", "indirect_only", "hide_viewport")


def check_replaceable(originals: Sequence[bpy.types.Object]) -> None:
    """Raise InputError if the file has a library override of a linked original or of its linked collection.

    Replacing the original in the saved file would break such an override.
    """
    linked = [item for item in originals if is_linked(item)]
    homes = {home for item in linked for home in (item, *_linked_homes([item]))}
    every: list[bpy.types.ID] = [*bpy.data.objects, *bpy.data.collections]
    for item in every if linked else ():
        if item.override_library is not None and item.override_library.reference in homes:
            names = ", ".join(f"'{one.name}'" for one in linked)
            raise InputError(
                f"object {names} is linked, and '{item.name}' is a library override of it in the same file: "
                "bake the override, or bake without a preview"
            )


@contextmanager
def linked_homes_copied(originals: Sequence[bpy.types.Object]) -> Iterator[None]:
    """Within the context, local copies replace the linked collections that hold the originals."""
    homes = _linked_homes(originals)
    if not homes:
        yield
        return
    shown = [_Shown.of(layer) for scene in bpy.data.scenes for layer in scene.view_layers]
    copies: dict[bpy.types.Collection, bpy.types.Collection] = {}
    try:
        for home in homes:
            copies[home] = cast(bpy.types.Collection, home.copy())
        for home, copy in copies.items():
            home.user_remap(copy)
        _restore(shown)
        yield
    finally:
        for home, copy in copies.items():
            copy.user_remap(home)
        for copy in copies.values():
            bpy.data.collections.remove(copy)
        _restore(shown)


def _linked_homes(originals: Sequence[bpy.types.Object]) -> list[bpy.types.Collection]:
    """Linked collections that hold one of the objects, directly or in a child collection."""
    linked = [item for item in bpy.data.collections if is_linked(item)]
    return [item for item in linked if not set(originals).isdisjoint(item.all_objects)]


@dataclass(frozen=True, eq=False)
class _Shown:
    """A view layer's collection settings, which Blender resets when collections are replaced.

    `flags` are in the order of `_tree`; `active` is the active collection's index in that order.
    """

    layer: bpy.types.ViewLayer
    flags: tuple[dict[str, bool], ...]
    active: int

    @classmethod
    def of(cls, layer: bpy.types.ViewLayer) -> _Shown:
        tree = list(_tree(layer.layer_collection))
        active = cast(bpy.types.LayerCollection, layer.active_layer_collection)  # there is always one
        flags = tuple({name: bool(getattr(shown, name)) for name in _FLAGS} for shown in tree)
        return cls(layer, flags, tree.index(active))


def _restore(every: Sequence[_Shown]) -> None:
    for shown in every:
        shown.layer.update()
        tree = list(_tree(shown.layer.layer_collection))
        for found, flags in zip(tree, shown.flags, strict=True):
            for name, value in flags.items():
                if getattr(found, name) != value:
                    setattr(found, name, value)
        shown.layer.active_layer_collection = tree[shown.active]


def _tree(layer_collection: bpy.types.LayerCollection) -> Iterator[bpy.types.LayerCollection]:
    yield layer_collection
    for child in layer_collection.children:
        yield from _tree(child)
