# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: which objects a lamp lights, and which cast shadows of its light."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import bpy


def lights(lamp: bpy.types.Object, receiver: bpy.types.Object) -> bool:
    """Whether an object that gives light lights another one.

    As Blender decides it (blenkernel/intern/light_linking.cc and Cycles's light sets): where the lamp's
    receiver collection includes objects, only those, and never those that it excludes.
    """
    return _is_linked_to(cast(Any, lamp).light_linking.receiver_collection, receiver)


def shadows(lamp: bpy.types.Object, blocker: bpy.types.Object) -> bool:
    """Whether an object keeps a lamp's light from others, where it stands in its way."""
    if not cast(Any, lamp.data).use_shadow:
        return False
    return _is_linked_to(cast(Any, lamp).light_linking.blocker_collection, blocker)


def _is_linked_to(collection: Any, item: bpy.types.Object) -> bool:
    if collection is None:
        return True
    states: dict[str, set[bpy.types.Object]] = {"INCLUDE": set(), "EXCLUDE": set()}
    for member, state in _members(collection):
        states[state].add(member)
    included = not states["INCLUDE"] or item in states["INCLUDE"]
    return included and item not in states["EXCLUDE"]


def _members(collection: Any) -> Iterator[tuple[bpy.types.Object, str]]:
    """A linking collection's objects and their states; those of its collections have these' states."""
    for item, linked in zip(collection.objects, collection.collection_objects, strict=True):
        yield item, linked.light_linking.link_state
    for child, linked in zip(collection.children, collection.collection_children, strict=True):
        for item in child.all_objects:
            yield item, linked.light_linking.link_state
