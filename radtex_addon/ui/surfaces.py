# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that assign surfaces to atlases (shared or split), and the bakes that result."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..bake.kinds import Kind
from .choices import SPLITS
from .update_callbacks import NOTICED

if TYPE_CHECKING:
    from ..bake.spec import BakeSpec

NAMES = ("together", "atlas_name", "split", "part")  # property names of the mixin below


class SurfaceSettings:
    """Mixin with the properties of atlases; not registered itself."""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
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
    """Draw the settings that apply; a shared atlas needs `several` objects and layout buckets (`plain`)."""
    if several and plain and Kind(settings.kind).traits.shared_atlas:
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
    """Atlas name and specification of each bake: one for each object, for each part, or one for all.

    If `shared` is not None, several objects share the atlas of that name. Parts are found by evaluating the
    objects; with `guess` they are taken from the material slots, which is quick. Raises InputError for a
    shared atlas without a name, and for objects that cannot be split.
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
    """Name of the atlas that all objects share; None if each object has its own."""
    fits = spec.form.shared_atlas and spec.kind.traits.shared_atlas
    name: str = values["atlas_name"]
    return name if values["together"] and fits else None


def have_own_atlases(values: Mapping[str, Any], spec: BakeSpec, count: int) -> bool:
    """Whether each of `count` objects has exactly one atlas, not shared."""
    return spec.split is None and (count < 2 or shared_name(values, spec) is None)


def may_lack_parts(scene: bpy.types.Scene, names: Sequence[str], spec: BakeSpec) -> bool:
    """Whether a guess may miss parts: UDIM tiles, materials set by geometry nodes, and empty slots."""
    from ..bake.spec import Split
    from ..scene.objects import find_object

    if spec.split is None or spec.part is not None:
        return False
    return spec.split is Split.UDIM or any(_may_lack(find_object(scene, name)) for name in names)


def _may_lack(item: bpy.types.Object) -> bool:
    slots = [slot.material for slot in item.material_slots]
    return not slots or None in slots or any(modifier.type == "NODES" for modifier in item.modifiers)


def _guessed(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> Iterable[BakeSpec]:
    """One specification for each material in the objects' slots, or for the first tile; evaluates nothing."""
    from ..bake.parts import FIRST_TILE
    from ..bake.spec import Split
    from ..scene.mesh.parts import NO_MATERIAL
    from ..scene.objects import find_object

    if spec.split is not Split.MATERIAL:
        return (replace(spec, part=str(FIRST_TILE)),)
    items = [find_object(scene, each) for each in spec.objects or (name,)]
    slots = [slot.material for item in items for slot in item.material_slots]
    found = dict.fromkeys(material.name for material in slots if material is not None)
    return tuple(replace(spec, part=part) for part in found or (NO_MATERIAL,))
