# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sort a scratch scene's objects into collections of its own, and take all other surfaces out of it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import cast

import bpy

from .objects import rendered_homes
from .scratch import find_view_layer

_NO_SURFACE = frozenset(("LIGHT", "LIGHT_PROBE", "CAMERA", "SPEAKER", "ARMATURE", "LATTICE"))


def regroup(
    scratch: bpy.types.Scene, groups: Mapping[str, Iterable[bpy.types.Object]]
) -> dict[str, bpy.types.LayerCollection]:
    """Leave the objects of the groups alone in a scratch scene, each group in a new collection of that title.

    Returns the collections' settings in the enabled view layer. Objects that those of the groups need, such
    as parents and cutters, are evaluated all the same.
    """
    layer, master = find_view_layer(scratch, None), scratch.collection
    for child in list(master.children):
        master.children.unlink(child)
    for item in list(master.objects):
        master.objects.unlink(item)
    found = {}
    for title, items in groups.items():
        home = cast(bpy.types.Collection, bpy.data.collections.new(title))
        for item in sorted(items, key=lambda item: item.name):
            home.objects.link(item)
        master.children.link(home)
        found[title] = layer.layer_collection.children[home.name]
    layer.update()
    return found


def leave_alone(scratch: bpy.types.Scene, kept: Collection[str | None]) -> None:
    """Leave the objects called `kept`, lamps and cameras in a scratch scene, each as visible as it was.

    Objects that the kept ones need, such as parents and cutters, are evaluated all the same.
    """
    layer = find_view_layer(scratch, None)
    layer.update()  # or it lacks objects that were linked since
    stays = [item for item in scratch.objects if item.name in kept or item.type in _NO_SURFACE]
    here = set(layer.objects)
    renders = {item for item in stays if item in here and any(True for _ in rendered_homes(item, layer))}
    hidden = regroup(
        scratch,
        {
            "RadTex alone": [item for item in stays if item in renders],
            "RadTex alone, hidden": [item for item in stays if item not in renders],
        },
    )["RadTex alone, hidden"]
    hidden.collection.hide_render = True
    layer.update()
