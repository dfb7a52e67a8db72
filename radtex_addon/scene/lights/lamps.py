# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scratch scene in which some lamps alone are lit: light adds up, so that each can be baked by itself.

The lamps are copies in a light group of their own, whose pass leaves out what materials and the world emit;
the other lamps are not there. The user's lamps stay what they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ..objects import rendered_homes
from .light import dark_world, may_glow
from .unlit import take_lamps_away

GROUP = "RadTexLamps"
WORLD = "world"  # the light of no lamp: the world's, and what glows
ALL, EACH = "all", "each"  # words that the batch knows, beside names
_WORDS = (WORLD, ALL, EACH)


def each_light(layer: bpy.types.ViewLayer) -> tuple[tuple[str, ...], ...]:
    """The lights whose atlases add up to the whole: every lamp that a view layer renders, then WORLD.

    Raises InputError where there is no lamp, or one bears a word that means something else.
    """
    names = [item.name for item in _lamps(layer)]
    if not names:
        raise InputError("the scene renders no lamp: add some, or bake without --lights")
    for name in names:
        if name in _WORDS:
            raise InputError(f"lamp '{name}' bears a word that RadTex knows otherwise: rename it")
    return (*((name,) for name in names), (WORLD,))


def find_lamps(layer: bpy.types.ViewLayer, names: Sequence[str]) -> tuple[bpy.types.Object, ...]:
    """The lamps that `names` call, sorted: each that of a lamp, of a collection with some, or WORLD.

    Raises InputError for a name of nothing that lights a render of the view layer.
    """
    lamps = {item.name: item for item in _lamps(layer)}
    found: dict[str, bpy.types.Object] = {}
    for name in names:
        if name == WORLD:
            continue
        chosen = [name] if name in lamps else sorted(_members(name) & lamps.keys())
        if not chosen:
            raise InputError(_unlit(name, sorted(lamps)))
        found |= {lamp: lamps[lamp] for lamp in chosen}
    return tuple(found[name] for name in sorted(found))


def light_only(scratch: bpy.types.Scene, names: Sequence[str], *, denoised: bool = False) -> None:
    """Leave in a scratch scene the lamps that `names` call, and, unless WORLD is among them, no other light.

    What materials emit, and lamps that something instances, are of WORLD; where it is not called they still
    render, and only the pass of the light group GROUP is without them. Where pictures are to be `denoised`,
    which Cycles does to the whole light alone, there is no such group unless something glows. Raises
    InputError as `find_lamps`.
    """
    layer = next(layer for layer in scratch.view_layers if layer.use)
    lit = find_lamps(layer, names)
    take_lamps_away(scratch)
    with_world = WORLD in names
    apart = not with_world and (not denoised or may_glow(layer))
    if not with_world:
        scratch.world = dark_world(scratch.world)
    if apart:
        cast(Any, layer).lightgroups.add(name=GROUP)
    for lamp in lit:
        copy = cast(bpy.types.Object, lamp.copy())
        cast(Any, copy).lightgroup = GROUP if apart else ""
        scratch.collection.objects.link(copy)
    layer.update()


def _lamps(layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    layer.update()  # or it does not know what was linked to it since
    found = (item for item in layer.objects if item.type == "LIGHT" and not item.hide_render)
    return sorted((item for item in found if _renders(item, layer)), key=lambda item: item.name)


def _renders(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> bool:
    return any(True for _ in rendered_homes(item, layer))


def _members(collection: str) -> set[str]:
    found = cast("bpy.types.Collection | None", bpy.data.collections.get(collection))
    return set() if found is None else {item.name for item in found.all_objects}


def _unlit(name: str, lamps: Sequence[str]) -> str:
    there = ", ".join(f"'{lamp}'" for lamp in lamps[:8]) or "none"
    if bpy.data.collections.get(name) is not None:
        return f"collection '{name}' has no lamp that renders: name another, or a lamp ({there})"
    item = bpy.data.objects.get(name)
    if item is not None and item.type == "LIGHT":
        return f"lamp '{name}' does not render: enable it, or name another ({there})"
    return f"there is no lamp or collection '{name}': the lamps that render are {there}; {WORLD} is the rest"
