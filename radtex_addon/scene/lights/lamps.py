# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light a scratch scene by some of its lamps only: light adds up, so each lamp can be baked by itself.

The lamps are replaced by copies in a light group of their own, whose pass leaves out the light of materials
and the world; other lamps are removed. The user's lamps are not changed.

Cycles splits only the combined pass by light groups. Where the passes of diffuse or glossy light are needed,
all other light has to be taken away: that of materials and of instanced lamps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ...core.messages import Setting, do, leave_out
from ..objects import is_rendered
from .light import dark_world, may_glow, without_emission

_FLAGS = ("exclude", "holdout", "indirect_only")
GROUP = "RadTexLamps"
WORLD = "world"  # all light that is of no lamp: the world's, and that of materials
ALL, EACH = "all", "each"  # words for the command line, besides names
_WORDS = (WORLD, ALL, EACH)


def take_lamps_away(scene: bpy.types.Scene) -> None:
    """Remove lamps from a scratch scene.

    Its collections are replaced by copies without lamps, with the same flags in view layers: the user's
    collections are not changed. The copies are removed with the scratch scene's other data. Instanced lamps
    stay, and so does the light of materials.
    """
    flags = {layer.name: list(_flags(layer.layer_collection)) for layer in scene.view_layers}
    root, copies = scene.collection, dict[bpy.types.Collection, bpy.types.Collection]()
    children = list(root.children)
    for child in children:
        root.children.unlink(child)
    for child in children:
        root.children.link(_copied(child, copies))
    _drop_lamps(root)
    for layer in scene.view_layers:
        for shown, before in zip(_tree(layer.layer_collection), flags[layer.name], strict=True):
            for name, value in before.items():
                setattr(shown, name, value)


def _copied(
    collection: bpy.types.Collection, copies: dict[bpy.types.Collection, bpy.types.Collection]
) -> bpy.types.Collection:
    """The copy of a collection, made once, with copies of its children; Blender copies its own flags."""
    if collection not in copies:
        copy = copies[collection] = cast(bpy.types.Collection, collection.copy())
        children = list(copy.children)
        for child in children:
            copy.children.unlink(child)
        for child in children:
            copy.children.link(_copied(child, copies))
        _drop_lamps(copy)
    return copies[collection]


def _drop_lamps(collection: bpy.types.Collection) -> None:
    for item in list(collection.objects):
        if item.type == "LIGHT":
            collection.objects.unlink(item)


def _tree(layer_collection: bpy.types.LayerCollection) -> Iterator[Any]:
    """All layer collections below this one, in order; a view layer's root itself has no flags."""
    for child in layer_collection.children:
        yield child
        yield from _tree(child)


def _flags(layer_collection: bpy.types.LayerCollection) -> Iterator[dict[str, bool]]:
    for child in _tree(layer_collection):
        yield {name: getattr(child, name) for name in _FLAGS}


def each_light(layer: bpy.types.ViewLayer) -> tuple[tuple[str, ...], ...]:
    """The lights whose atlases add up to the whole: every lamp that a view layer renders, then WORLD.

    Raises InputError if there is no lamp, or if a lamp is called WORLD, ALL or EACH.
    """
    names = [item.name for item in _lamps(layer)]
    if not names:
        raise InputError("the scene renders no lamp", do("add some"), leave_out(Setting.LIGHTS))
    for name in names:
        if name in _WORDS:
            raise InputError(f"lamp '{name}' has a name that means something else here: rename it")
    return (*((name,) for name in names), (WORLD,))


def find_lamps(layer: bpy.types.ViewLayer, names: Sequence[str]) -> tuple[bpy.types.Object, ...]:
    """The lamps called by `names`, sorted; a name is that of a lamp or of a collection with lamps, or WORLD.

    Raises InputError for a name without a lamp that renders in the view layer.
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


def refuse_negative(lamps: Iterable[tuple[str, Any]]) -> None:
    """Raise InputError for the first of lamps, by name and data, that takes light away.

    Mirrored light is never negative, so that the dark that such a lamp makes could not be shown.
    """
    for name, data in lamps:
        if is_negative(data):
            raise InputError(
                f"lamp '{name}' takes light away (its power is {data.energy:g}), which this layout cannot do",
                do("give it a power above 0"),
                do("hide it from render"),
                do("choose layout buckets", Setting.LAYOUT, value="buckets"),
            )


def is_negative(data: Any) -> bool:
    """Whether a lamp's data take light away in a colour."""
    return any(data.energy * part < 0 for part in data.color)


def rendered_lamps(layer: bpy.types.ViewLayer) -> list[tuple[str, Any]]:
    """The names and data of lamps that a view layer renders, instances aside."""
    return [(item.name, item.data) for item in _lamps(layer)]


def light_only(
    scratch: bpy.types.Scene, names: Sequence[str], *, denoised: bool = False, group: bool = True
) -> None:
    """Light a scratch scene by the lamps called by `names` only; WORLD among them adds all other light.

    Light of materials and of instanced lamps belongs to WORLD. Without WORLD it still renders, but the pass
    of the light `group` GROUP leaves it out. Cycles denoises only the combined pass: if pictures are to be
    `denoised`, the light group is made only if `may_glow`. Raises InputError as `find_lamps`.
    """
    layer = next(layer for layer in scratch.view_layers if layer.use)
    lit = find_lamps(layer, names)
    take_lamps_away(scratch)
    with_world = WORLD in names
    apart = group and not with_world and (not denoised or may_glow(layer))
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
    layer.update()  # or it lacks objects that were linked since
    found = (item for item in layer.objects if item.type == "LIGHT" and is_rendered(item, layer))
    return sorted(found, key=lambda item: item.name)


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


@contextmanager
def lit_by_lamps_alone(scratch: bpy.types.Scene, names: Sequence[str]) -> Iterator[None]:
    """Light a scratch scene as `lamps.light_only` does, but so that no pass has any other light.

    Meanwhile, materials that glow and the data of lamps are exchanged for dark copies wherever they are used;
    at the end all users have their own again. Raises InputError as `light_only` does, and if what glows is
    linked from another file, whose users cannot be changed.
    """
    light_only(scratch, names, group=False)
    if WORLD in names:
        yield
        return
    for item in scratch.collection.objects:  # the lamps that are lit are copies: they keep their own data
        if item.type == "LIGHT":
            cast(Any, item).data = cast(bpy.types.ID, item.data).copy()
    kept = {item.data for item in scratch.collection.objects if item.type == "LIGHT"}
    dark = [*_materials(), *_users_of_lamps(kept)]
    _check_users([block for block, _ in dark], names)
    try:
        for block, copy in dark:
            block.user_remap(copy)
        yield
    finally:
        for block, copy in dark:
            copy.user_remap(block)


def _check_users(blocks: Sequence[bpy.types.ID], names: Sequence[str]) -> None:
    """Raises InputError if something that is linked from another file uses one of the blocks."""
    for block, users in bpy.data.user_map(subset=list(blocks)).items():
        linked = next((cast(Any, user).library for user in users if cast(Any, user).library), None)
        if linked is not None:
            raise InputError(
                f"'{block.name}' of {linked.filepath} gives light, which cannot be left out of a bake of "
                f"{', '.join(names)} alone",
                do("make what uses it local"),
                do("choose layout buckets", Setting.LAYOUT, value="buckets"),
            )


def _materials() -> Iterator[tuple[Any, Any]]:
    for material in list(bpy.data.materials):
        if material.users and (dark := without_emission(material)) != material:
            yield material, dark


def _users_of_lamps(kept: set[Any]) -> Iterator[tuple[Any, Any]]:
    for lamp in list(bpy.data.lights):
        if lamp.users and lamp not in kept:
            dark: Any = bpy.data.lights.new("RadTex dark", lamp.type)
            dark.energy = 0
            yield lamp, dark
