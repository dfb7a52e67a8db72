# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects the panel bakes: the selected ones, those of a collection, or a list in an order."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, PointerProperty

from ...scene.surfaces import may_have_faces
from .update_callbacks import notice

SOURCES = (
    (
        "selection",
        "Selected Objects",
        "The selected meshes, or else the active one",
        "RESTRICT_SELECT_OFF",
        0,
    ),
    (
        "collection",
        "Collection",
        "Every mesh of a collection, whatever is selected",
        "OUTLINER_COLLECTION",
        1,
    ),
    ("list", "Bake List", "The objects of a list, in its order, whatever is selected", "LONGDISPLAY", 2),
)


def _has_faces(_: Any, item: bpy.types.Object) -> bool:
    return may_have_faces(item)


class RADTEX_PG_listed(bpy.types.PropertyGroup):
    """An object on the bake list"""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        item: bpy.types.Object | None
        use: bool
    else:
        item: PointerProperty(
            name="Object",
            description="The object to bake",
            type=bpy.types.Object,
            poll=_has_faces,
            update=notice,
        )
        use: BoolProperty(
            name="Bake",
            description="Bake it with the others of the list",
            default=True,
            update=notice,
        )


class RADTEX_PG_chosen(bpy.types.PropertyGroup):
    """Which objects to bake"""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        source: str
        collection: bpy.types.Collection | None
        listed: Any
        active: int
    else:
        source: EnumProperty(
            name="Objects",
            description="Which objects are baked",
            items=SOURCES,
            default="selection",
            update=notice,
        )
        collection: PointerProperty(
            name="Collection",
            description="Its meshes are baked, and those of the collections in it",
            type=bpy.types.Collection,
            update=notice,
        )
        listed: CollectionProperty(
            name="Bake List", description="Objects to bake, the first one first", type=RADTEX_PG_listed
        )
        active: IntProperty(
            name="Active",
            description="The marked row of the bake list: the buttons beside it work on it, and the panel "
            "shows the settings of its object",
            default=0,
            min=0,
        )


def chosen_by(scene: bpy.types.Scene) -> RADTEX_PG_chosen:
    """The scene's choice of objects."""
    found: RADTEX_PG_chosen = scene.radtex_chosen  # type: ignore[attr-defined]  # ours, not Blender's
    return found


def marked_object(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The object of the marked row of the bake list, where that chooses what is baked; else None."""
    chosen = chosen_by(scene)
    if chosen.source != "list" or not 0 <= chosen.active < len(chosen.listed):
        return None
    found: bpy.types.Object | None = chosen.listed[chosen.active].item
    return found


def chosen_meshes(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The objects that the panel bakes, in the order in which they are baked; originals, not previews."""
    from ...preview.collection_meshes import meshes_of
    from ...preview.swap import original_of

    chosen = chosen_by(scene)
    if chosen.source == "selection":
        found = selected_meshes(view_layer)
    elif chosen.source == "collection":
        found = meshes_of(chosen.collection, view_layer)
    else:
        here = set(view_layer.objects)
        found = [item for item in _listed(chosen) if item in here]
    return list(dict.fromkeys(original_of(item) or item for item in found))


def _listed(chosen: RADTEX_PG_chosen) -> list[bpy.types.Object]:
    """The objects that are ticked on the bake list, without those that were deleted."""
    rows = [row.item for row in chosen.listed if row.use]
    return [item for item in rows if item is not None and item.users_collection]


def chosen_names(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[str, ...]:
    """Their names; those of selected objects and of a collection's are sorted.

    Also those of objects on the list that the view layer does not have: a bake says why it leaves them out.
    """
    from ...preview.swap import original_of

    chosen = chosen_by(scene)
    if chosen.source != "list":
        return tuple(sorted(item.name for item in chosen_meshes(scene, view_layer)))
    listed = (original_of(item) or item for item in _listed(chosen))
    return tuple(dict.fromkeys(item.name for item in listed))


def told_names(names: Iterable[str]) -> str:
    """Names in any order as one text, to compare with those of a later choice."""
    return "\n".join(sorted(names))


def nothing_chosen(scene: bpy.types.Scene) -> str:
    """What to do where the choice has no object, in one line."""
    chosen = chosen_by(scene)
    if chosen.source == "list":
        return _nothing_listed(chosen)
    if chosen.source == "selection":
        return "select a mesh object to bake"
    if chosen.collection is None:
        return "no collection is chosen: choose the one whose meshes are to be baked"
    return f"collection '{chosen.collection.name}' has no mesh that is seen in renders: choose another"


def _nothing_listed(chosen: RADTEX_PG_chosen) -> str:
    """The same for the bake list."""
    if not chosen.listed:
        return "the bake list is empty: select objects and press its plus"
    if any(row.item is not None and row.item.users_collection for row in chosen.listed):
        return "no object of the bake list is ticked: tick those to bake"
    return "the objects of the bake list were deleted: take them off, and add others"


def selected_meshes(layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The selected meshes, sorted by name, or else the active one."""
    found = [item for item in layer.objects.selected if may_have_faces(item)]
    active = layer.objects.active
    if not found and active is not None and may_have_faces(active):
        found = [active]
    return sorted(found, key=lambda item: item.name)
