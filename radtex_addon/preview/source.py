# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake shows in the place of an object: hidden while the preview stands there.

That is the detailed object that a bake onto a simple one is from, or what a proxy's hull is around. The
object and its preview both hold pointers to all of it, and how each was hidden before.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import bpy

from ..core.errors import InputError
from ..formats.sidecar import content_in, read_facts

_RECORD = "radtex_source"
_FLAGS = ("hide_render", "hide_viewport")

Flags = Mapping[str, bool]  # by the names of an object's properties


def find_shown(sidecar: Path, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects of the scene that the bake with this sidecar shows in its object's place.

    What is no longer there, or linked from a library, where nothing can be hidden, is left out. Raises
    FormatError for a sidecar that cannot be read.
    """
    return [item for item in _named(sidecar, scene) if item.library is None]


def _named(sidecar: Path, scene: bpy.types.Scene) -> list[Any]:
    facts = read_facts(sidecar)
    content = content_in(facts)
    names = () if content is None else content.objects
    if "source" in facts.values:
        names = (facts.inner("source").text("object"),)
    named: Iterator[Any] = (scene.objects.get(name) for name in names)
    return [item for item in named if item is not None]


def check_hideable(sidecar: Path, scene: bpy.types.Scene) -> None:
    """Raises InputError where what a bake shows instead is linked: both would be seen, one in the other."""
    for item in _named(sidecar, scene):
        if item.library is not None:
            raise InputError(
                f"object '{item.name}' is linked from {item.library.name}, where nothing can be hidden: "
                "make a library override of it (Object > Library Override > Make), or make it local"
            )


def hide_shown(pair: Iterable[Any], shown: Iterable[Any], others: Iterable[Any]) -> None:
    """Hide what is `shown` by the object and the preview in `pair`; `others` are previews that are on."""
    known = {item: flags for other in others for item, flags in _hidden_in(other)}
    record = {}
    for number, item in enumerate(shown):
        flags = known.get(item) or {flag: bool(getattr(item, flag)) for flag in _FLAGS}
        record[str(number)] = {"object": item, **flags}
    if not record:
        return
    for one in pair:
        one[_RECORD] = record
    for entry in record.values():
        for flag in _FLAGS:
            setattr(entry["object"], flag, True)


def hidden_by(pair: Iterable[Any]) -> dict[bpy.types.Object, Flags]:
    """What an object and its preview, of which one may be None, hide, and how that was hidden before."""
    return {item: flags for one in pair if one is not None for item, flags in _hidden_in(one)}


def show_again(pair: Iterable[Any], others: Iterable[Any]) -> None:
    """Show what the pair hides as it was, unless `others`, previews that are on, hide it too; forget it."""
    items = [item for item in pair if item is not None]
    found = hidden_by(items)
    still = hidden_by(others)
    for item in items:
        if _RECORD in item:
            del item[_RECORD]
    for shown, flags in found.items():
        for flag, value in flags.items() if shown not in still else ():
            setattr(shown, flag, value)


def _hidden_in(item: Any) -> Iterator[tuple[bpy.types.Object, Flags]]:
    """What an item's record names, but for what was deleted."""
    for entry in item[_RECORD].values() if _RECORD in item else ():
        shown = entry.get("object")
        if shown is not None and shown.users_collection:
            yield shown, {flag: bool(entry[flag]) for flag in _FLAGS}
