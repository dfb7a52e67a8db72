# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking: which objects a lamp lights."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import bpy


def lights(lamp: bpy.types.Object, receiver: bpy.types.Object) -> bool:
    """Whether an object that gives light lights another one.

    As Blender decides it (blenkernel/intern/light_linking.cc and Cycles's light sets): where the lamp's
    receiver collection includes objects, only those, and never those that it excludes.
    """
    collection = cast(Any, lamp).light_linking.receiver_collection
    if collection is None:
        return True
    states: dict[str, set[bpy.types.Object]] = {"INCLUDE": set(), "EXCLUDE": set()}
    for item, state in _members(collection):
        states[state].add(item)
    included = not states["INCLUDE"] or receiver in states["INCLUDE"]
    return included and receiver not in states["EXCLUDE"]


def _members(collection: Any) -> Iterator[tuple[bpy.types.Object, str]]:
    """A linking collection's objects and their states; those of its collections have these' states."""
    for item, linked in zip(collection.objects, collection.collection_objects, strict=True):
        yield item, linked.light_linking.link_state
    for child, linked in zip(collection.children, collection.collection_children, strict=True):
        for item in child.all_objects:
            yield item, linked.light_linking.link_state
