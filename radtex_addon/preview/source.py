# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The detailed object that a bake onto a simple one shows: hidden while the preview stands in its place.

The simple object and its preview both hold a pointer to it, and how it was hidden before.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import bpy

from ..formats.sidecar import read_facts

_RECORD = "radtex_source"
_FLAGS = ("hide_render", "hide_viewport")


def find_shown_source(sidecar: Path, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The object of the scene that the bake with this sidecar is from; None where there is none to hide.

    Raises FormatError for a sidecar that cannot be read.
    """
    facts = read_facts(sidecar)
    if "source" not in facts.values:
        return None
    found: Any = scene.objects.get(facts.inner("source").text("object"))
    return None if found is None or found.library is not None else found


def hide_source(pair: Iterable[Any], source: Any, others: Iterable[Any]) -> None:
    """Hide `source` for the object and the preview in `pair`; `others` are previews that are on."""
    known = next((other[_RECORD] for other in others if _source_in(other) == source), None)
    flags = {flag: bool(known[flag] if known else getattr(source, flag)) for flag in _FLAGS}
    for item in pair:
        item[_RECORD] = {"object": source, **flags}
    for flag in _FLAGS:
        setattr(source, flag, True)


def hidden_source(pair: Iterable[Any]) -> tuple[bpy.types.Object, dict[str, bool]] | None:
    """What an object and its preview, of which one may be None, hide, and how it was hidden before."""
    for item in pair:
        source = None if item is None else _source_in(item)
        if source is not None:
            return source, {flag: bool(item[_RECORD][flag]) for flag in _FLAGS}
    return None


def show_source(pair: Iterable[Any], others: Iterable[Any]) -> None:
    """Show what the pair hides as it was, unless `others`, previews that are on, hide it too; forget it."""
    items = [item for item in pair if item is not None]
    found = hidden_source(items)
    for item in items:
        if _RECORD in item:
            del item[_RECORD]
    if found is None or any(_source_in(other) == found[0] for other in others):
        return
    for flag, value in found[1].items():
        setattr(found[0], flag, value)


def _source_in(item: Any) -> Any:
    """What an item's record names; None for one that has none, or names what was deleted."""
    source = item[_RECORD].get("object") if _RECORD in item else None
    return source if source is not None and source.users_collection else None
