# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of libraries in a saved preview: their collections are local copies while the file is written.

A library decides what is in its collections: a file that uses them shows the originals, whatever stood in for
them when it was saved.
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
    """Refuse a linked object of which the file has a library override, too: that would come apart.

    Raises InputError.
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
    """Give local copies to all that uses linked collections which hold the originals, and take them back."""
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
    """Linked collections that hold one of the objects, at whatever depth."""
    linked = [item for item in bpy.data.collections if is_linked(item)]
    return [item for item in linked if not set(originals).isdisjoint(item.all_objects)]


@dataclass(frozen=True, eq=False)
class _Shown:
    """How a view layer shows its collections, which Blender forgets when they are exchanged.

    `flags` are in the order of `_tree`; `active` is the place of the active one among them.
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
