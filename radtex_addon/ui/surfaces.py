# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which surfaces go into which atlas: settings for it, and the bakes that come of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from .choices import SPLITS
from .update_callbacks import NOTICED

if TYPE_CHECKING:
    from ..bake.spec import BakeSpec

NAMES = ("together", "atlas_name", "split", "part")  # of the mixin below


class SurfaceSettings:
    """Not registered itself: the other settings take its properties."""

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotations below
        together: bool
        atlas_name: str
        split: str
        part: str
    else:
        together: BoolProperty(
            name="One Atlas",
            description="Bake all selected objects into one atlas, so that they need but one texture",
            default=False,
            **NOTICED,
        )
        atlas_name: StringProperty(
            name="Name",
            description="What the atlas that objects share is called, and its files",
            default="Atlas",
            **NOTICED,
        )
        split: EnumProperty(
            name="Split",
            description="What has an atlas of its own",
            items=SPLITS,
            default="none",
            **NOTICED,
        )
        part: StringProperty(
            name="Only",
            description="The one material, or the tile's number, to bake. Left empty, all are baked",
            **NOTICED,
        )


def draw_surfaces(column: Any, settings: Any, several: bool, plain: bool) -> None:
    """The settings, where they make a difference: for `several` objects, in the plain layout."""
    if several and plain and settings.kind != "proxy":
        column.prop(settings, "together")
        if settings.together:
            column.prop(settings, "atlas_name")
    column.prop(settings, "split")
    if settings.split == "material":
        column.prop_search(settings, "part", bpy.data, "materials")
    elif settings.split != "none":
        column.prop(settings, "part")


def bakes_of(
    scene: bpy.types.Scene, names: Sequence[str], spec: BakeSpec, shared: str | None, guess: bool
) -> tuple[tuple[str, BakeSpec], ...]:
    """What is baked of the objects, by the names of the atlases: one each, one for all, one for each part.

    Several share the atlas called `shared`, if that is not None. Parts are found by evaluating the objects;
    to `guess` them is quick. Raises InputError for a shared atlas without a name, and what cannot be split.
    """
    from ..core.errors import InputError
    from ..job import part_specs

    wanted = [(name, spec) for name in names]
    if shared is not None and len(names) > 1:
        if not shared.strip():
            raise InputError("the atlas that objects share has no name: give it one")
        wanted = [(shared, replace(spec, objects=tuple(names)))]
    if spec.split is None or spec.part is not None:
        return tuple(wanted)
    if guess:
        return tuple((name, each) for name, one in wanted for each in _guessed(scene, name, one))
    return tuple((name, each) for name, one in wanted for each in part_specs(scene, name, one))


def shared_name(values: Mapping[str, Any], spec: BakeSpec) -> str | None:
    """What the atlas is called that all objects share; None where each has its own."""
    from ..bake.spec import Kind, Layout

    fits = spec.layout is Layout.BUCKETS and spec.kind is not Kind.PROXY
    name: str = values["atlas_name"]
    return name if values["together"] and fits else None


def have_own_atlases(values: Mapping[str, Any], spec: BakeSpec, count: int) -> bool:
    """Whether each of `count` objects has one atlas, all its own."""
    return spec.split is None and (count < 2 or shared_name(values, spec) is None)


def may_lack_parts(scene: bpy.types.Scene, names: Sequence[str], spec: BakeSpec) -> bool:
    """Whether there may be parts that a guess does not know: tiles, what nodes make, and empty slots."""
    from ..bake.spec import Split
    from ..scene.objects import find_object

    if spec.split is None or spec.part is not None:
        return False
    return spec.split is Split.UDIM or any(_may_lack(find_object(scene, name)) for name in names)


def _may_lack(item: bpy.types.Object) -> bool:
    slots = [slot.material for slot in item.material_slots]
    return not slots or None in slots or any(modifier.type == "NODES" for modifier in item.modifiers)


def _guessed(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> Iterable[BakeSpec]:
    """The parts as the objects' slots have it, or the first tile, without evaluating anything."""
    from ..bake.parts import FIRST_TILE
    from ..bake.spec import Split
    from ..scene.objects import find_object
    from ..scene.parts import NO_MATERIAL

    if spec.split is not Split.MATERIAL:
        return (replace(spec, part=str(FIRST_TILE)),)
    items = [find_object(scene, each) for each in spec.objects or (name,)]
    slots = [slot.material for item in items for slot in item.material_slots]
    found = dict.fromkeys(material.name for material in slots if material is not None)
    return tuple(replace(spec, part=part) for part in found or (NO_MATERIAL,))
