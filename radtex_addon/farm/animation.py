# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read animated properties at one frame, and fix them at these values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import bpy

_EMBEDDED = ("node_tree", "shape_keys")  # parts of data-blocks, with animation of their own


@dataclass(frozen=True, eq=False)
class Values:
    """Values of a data-block's animated properties, by path."""

    owner: Any
    by_path: dict[str, Any]


def animated_values(depsgraph: bpy.types.Depsgraph) -> list[Values]:
    """All animated and driven properties of the data that a dependency graph has evaluated."""
    found = []
    for evaluated in depsgraph.ids:
        original: Any = evaluated.original
        animation = getattr(original, "animation_data", None)
        if animation is None:
            continue
        values = {}
        for path in _paths(animation):
            try:
                value = evaluated.path_resolve(path)
            except ValueError:  # an action tells of what other data-blocks have, too
                continue
            values[path] = value[:] if hasattr(value, "__getitem__") and not isinstance(value, str) else value
        found.append(Values(original, values))
    return found


def hold(values: Iterable[Values]) -> None:
    """Fix properties at these values, and remove all animation from the open file."""
    for block in _blocks():
        block.animation_data_clear()
    for some in values:
        for path, value in some.by_path.items():
            _assign(some.owner, path, value)


def curves_of(animated: Any) -> list[Any]:
    """The curves of a data-block's action."""
    data = animated.animation_data
    return [] if data is None or data.action is None else list(_curves(data.action))


def _assign(owner: Any, path: str, value: Any) -> None:
    if path.endswith('"]'):
        place, _, key = path[:-2].rpartition('["')
        (owner.path_resolve(place) if place else owner)[key] = value
        return
    place, _, name = path.rpartition(".")
    of = owner.path_resolve(place) if place else owner
    if not of.is_property_readonly(name):
        setattr(of, name, value)


def _paths(animation: Any) -> set[str]:
    actions = [animation.action, *(strip.action for strip in _strips(animation.nla_tracks))]
    paths = {curve.data_path for action in actions if action is not None for curve in _curves(action)}
    return paths | {driver.data_path for driver in animation.drivers}


def _strips(tracks: Iterable[Any]) -> Iterator[Any]:
    for track in tracks:
        for strip in track.strips:
            yield strip
            yield from strip.strips  # of a meta strip


def _curves(action: Any) -> Iterator[Any]:
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield from bag.fcurves


def _blocks() -> Iterator[Any]:
    for kind in bpy.data.bl_rna.properties:
        if kind.type != "COLLECTION" or kind.identifier in {"all_ids", "libraries"}:
            continue
        for block in getattr(bpy.data, kind.identifier):
            parts = [getattr(block, name, None) for name in _EMBEDDED]
            yield from (each for each in (block, *parts) if hasattr(each, "animation_data_clear"))
