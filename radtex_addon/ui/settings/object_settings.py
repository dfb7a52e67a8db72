# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake settings of single objects, stored on them; all other objects are baked by the scene's."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import BoolProperty

from ...scene.surfaces import may_have_faces
from .bake_settings import NAMES, BakeSettings
from .chosen_objects import marked_object
from .update_callbacks import notice

_CHOICES = frozenset({"atlas_layout", "kind", "unwrap"})  # "" if a file has the number of a former choice


def _start_from_the_scenes(own: Any, context: bpy.types.Context) -> None:
    """Update callback: settings that were never changed start as a copy of the scene's."""
    if own.use and not any(own.is_property_set(name) for name in NAMES):
        of_scene: Any = context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's
        for name in NAMES:
            if (value := getattr(of_scene, name)) != "" or name not in _CHOICES:
                setattr(own, name, value)
    notice(own, context)


class RADTEX_PG_object(BakeSettings, bpy.types.PropertyGroup):
    """Bake settings of one object"""

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        use: bool
    else:
        use: BoolProperty(
            name="Own Settings",
            description="Keep settings of its own with this object. It is baked by them whenever it is "
            "baked, alone or among others",
            default=False,
            update=_start_from_the_scenes,
        )


def own_settings(item: bpy.types.Object | None) -> RADTEX_PG_object | None:
    """The settings stored on an object, None if it is baked by the scene's, as linked ones always are."""
    local = item is not None and item.library is None
    own: RADTEX_PG_object | None = getattr(item, "radtex", None) if local else None
    return own if own is not None and own.use else None


def owner_of(
    scene: bpy.types.Scene, active: bpy.types.Object | None, names: Collection[str]
) -> bpy.types.Object | None:
    """The object among `names`, which are to be baked, whose own settings the panel offers.

    That is the object of the bake list's marked row, where the list is chosen, or else the active one; where
    such an object is a preview, the one whose bake it shows. Linked objects have no settings of their own.
    """
    from ...preview.swap import original_of

    for item in (marked_object(scene), active):
        found = None if item is None or not may_have_faces(item) else original_of(item)
        if found is not None and found.name in names:
            local: bool = cast(Any, found).library is None  # older stubs declare that each has one
            return found if local else None
    return None


def edited_settings(
    scene: bpy.types.Scene, active: bpy.types.Object | None, names: Collection[str]
) -> BakeSettings:
    """The settings that the panel shows and presets change, while the objects `names` are to be baked."""
    own = own_settings(owner_of(scene, active, names))
    return own if own is not None else scene.radtex  # type: ignore[attr-defined]  # ours, not Blender's


def settings_for(scene: bpy.types.Scene, name: str) -> BakeSettings:
    """The settings that the object `name` is baked by: its own, or the scene's."""
    own = own_settings(scene.objects.get(name))
    return own if own is not None else scene.radtex  # type: ignore[attr-defined]  # ours, not Blender's


def by_settings(scene: bpy.types.Scene, names: Iterable[str]) -> list[tuple[BakeSettings, tuple[str, ...]]]:
    """The names grouped by the settings they are baked by, each group's in the order given.

    Objects without settings of their own are one group. Without names there is one group, of the scene's.
    """
    groups: dict[int, tuple[BakeSettings, list[str]]] = {}
    for name in names:
        found = settings_for(scene, name)
        groups.setdefault(found.as_pointer(), (found, []))[1].append(name)
    return [(found, tuple(group)) for found, group in groups.values()] or [(scene.radtex, ())]  # type: ignore[attr-defined]  # ours
