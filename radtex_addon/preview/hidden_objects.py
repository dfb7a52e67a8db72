# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hide the objects whose light a bake shows on another object, while its preview is on.

These are the detailed object of a bake onto a simple one, or the objects inside a proxy's hull. The object
with the preview and the preview both store pointers to them, and their visibility before.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import bpy

from ..core.errors import InputError
from ..formats.sidecar import content_in
from ..formats.sidecar_file import AnySidecar, read_facts

RECORD = "radtex_source"  # custom property of the object and the preview
_FLAGS = ("hide_render", "hide_viewport")

Flags = Mapping[str, bool]  # values of _FLAGS by name


def objects_to_hide(sidecar: AnySidecar, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects of the scene that are to be hidden while the preview of the bake with this sidecar is on.

    Objects that no longer exist are left out, and linked ones, which cannot be hidden. Raises FormatError for
    a sidecar that cannot be read.
    """
    return [item for item in _named(sidecar, scene) if item.library is None]


def _named(sidecar: AnySidecar, scene: bpy.types.Scene) -> list[Any]:
    facts = read_facts(sidecar)
    content = content_in(facts)
    names = () if content is None else content.objects
    if "source" in facts.values:
        names = (facts.inner("source").text("object"),)
    named: Iterator[Any] = (scene.objects.get(name) for name in names)
    return [item for item in named if item is not None]


def check_hideable(sidecar: AnySidecar, scene: bpy.types.Scene) -> None:
    """Raise InputError if an object to be hidden is linked: it would stay visible inside the preview."""
    for item in _named(sidecar, scene):
        if item.library is not None:
            raise InputError(
                f"object '{item.name}' is linked from {item.library.name}, where nothing can be hidden: "
                "make a library override of it (Object > Library Override > Make), or make it local"
            )


def hide_originals(pair: Iterable[Any], shown: Iterable[Any], others: Iterable[Any]) -> None:
    """Hide the objects `shown`, and record their visibility on the object and the preview in `pair`.

    `others` are the other previews that are on; if one of them hides an object already, the visibility that
    it recorded is taken over.
    """
    known = {item: flags for other in others for item, flags in _hidden_in(other)}
    record = {}
    for number, item in enumerate(shown):
        flags = known.get(item) or {flag: bool(getattr(item, flag)) for flag in _FLAGS}
        record[str(number)] = {"object": item, **flags}
    if not record:
        return
    for one in pair:
        one[RECORD] = record
    for entry in record.values():
        for flag in _FLAGS:
            setattr(entry["object"], flag, True)


def hidden_by(pair: Iterable[Any]) -> dict[bpy.types.Object, Flags]:
    """The objects that an object and its preview (one may be None) hide, and their visibility before."""
    return {item: flags for one in pair if one is not None for item, flags in _hidden_in(one)}


def restore_visibility(pair: Iterable[Any], others: Iterable[Any]) -> None:
    """Restore the objects that the pair hides, unless one of the `others`, previews that are on, hides them.

    Deletes the pair's records.
    """
    items = [item for item in pair if item is not None]
    found = hidden_by(items)
    still = hidden_by(others)
    for item in items:
        if RECORD in item:
            del item[RECORD]
    for shown, flags in found.items():
        for flag, value in flags.items() if shown not in still else ():
            setattr(shown, flag, value)


def _hidden_in(item: Any) -> Iterator[tuple[bpy.types.Object, Flags]]:
    """The objects in an item's record, and their visibility before; without deleted objects."""
    for entry in item[RECORD].values() if RECORD in item else ():
        shown = entry.get("object")
        if shown is not None and shown.users_collection:
            yield shown, {flag: bool(entry[flag]) for flag in _FLAGS}
