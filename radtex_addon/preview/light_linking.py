# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Link a copy of an object as the object is, for light linking too: each lamp lights and shadows both alike.

The collections of a lamp's receivers and blockers are among an object's collections, and include or exclude
each of their members. An object that is linked into one is included until told otherwise.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import bpy


def link_alike(
    copy: bpy.types.Object, original: bpy.types.Object, homes: Iterable[bpy.types.Collection]
) -> None:
    """Link a copy, which is in no collection, to the `homes`, some of the original's or all it could be in.

    Light linking then includes and excludes it as it does the original, as far as its collections are not
    those of a library.
    """
    for home in homes:
        home.objects.link(copy)
        if (state := _own_state(home, original)) is not None:
            _set_state(home, copy, state)
    for linking in _linking_collections():
        state = _state(linking, original)
        if state is None or state == _state(linking, copy):
            continue
        if linking.library is not None or linking.override_library is not None:
            continue
        if _own_state(linking, copy) is None:
            linking.objects.link(copy)
        _set_state(linking, copy, state)


def _linking_collections() -> Iterator[bpy.types.Collection]:
    """The collections of all objects' receivers and blockers, each once."""
    settings = [item.light_linking for item in bpy.data.objects]
    found = [one for each in settings for one in (each.receiver_collection, each.blocker_collection)]
    yield from dict.fromkeys(one for one in found if one is not None)


def _state(linking: bpy.types.Collection, item: bpy.types.Object) -> str | None:
    """Whether light linking includes or excludes an object of a collection; None if that does not have it.

    As Blender has it: an object's own entry counts, else that of the last child collection with the object.
    """
    own = _own_state(linking, item)
    if own is not None:
        return own
    found = None
    entries: Any = linking.collection_children
    for child, entry in zip(linking.children, entries, strict=True):
        if any(one == item for one in child.all_objects):
            found = str(entry.light_linking.link_state)
    return found


def _own_state(home: bpy.types.Collection, item: bpy.types.Object) -> str | None:
    entry = _entry(home, item)
    return None if entry is None else str(entry.light_linking.link_state)


def _set_state(home: bpy.types.Collection, item: bpy.types.Object, state: str) -> None:
    entry = _entry(home, item)
    if entry is not None and entry.light_linking.link_state != state:
        entry.light_linking.link_state = state


def _entry(home: bpy.types.Collection, item: bpy.types.Object) -> Any:
    """The entry of a direct member in a collection, which has its state in light linking."""
    entries: Any = home.collection_objects
    return next((entry for one, entry in zip(home.objects, entries, strict=True) if one == item), None)
