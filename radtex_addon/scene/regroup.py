# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sort a scratch scene's objects into collections of its own, whose settings can be changed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import cast

import bpy

from .scratch import find_view_layer


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
