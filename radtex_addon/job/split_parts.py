# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the parts of a surface that is split, and make a specification for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy

from ..core.arrays import Bools
from ..core.errors import InputError
from ..prepare.unwrapping import split_surfaces
from ..scene.mesh.evaluated import evaluate
from ..scene.mesh.mesh_parts import NO_MATERIAL
from ..scene.mesh.named_regions import chosen_triangles
from ..scene.objects import find_object
from ..scene.scratch import at_frame, scratch_scene
from ..settings.parts import FIRST_TILE
from ..settings.spec import BakeSpec, Split


def part_specs(
    scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None = None
) -> tuple[BakeSpec, ...]:
    """A specification for each part into which `spec` splits the object `name`, or its `objects`.

    Without a split, or if `spec` has a part already, it is returned unchanged. Parts without any of the faces
    that `spec.where` names are left out. The scene is unchanged afterwards. Raises InputError for what cannot
    be baked or split, and if `spec.where` names no face at all.
    """
    if spec.split is None or spec.part is not None:
        return (spec,)
    with at_frame(scene, spec.frame), scratch_scene(scene, view_layer) as scratch:
        items = [find_object(scratch, each) for each in spec.objects or (name,)]
        found = split_surfaces([evaluate(scratch, item) for item in items], spec)
        if spec.where is not None:
            chosen = chosen_triangles(scratch, items, spec.where)
            found = {part: faces for part, faces in found.items() if _overlap(faces, chosen)}
    return tuple(replace(spec, part=part) for part in found)


def guessed_parts(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> tuple[BakeSpec, ...]:
    """A quick guess of `part_specs`: by material slots, or only the first tile; evaluates nothing."""
    if spec.split is None or spec.part is not None:
        return (spec,)
    if spec.split is not Split.MATERIAL:
        return (replace(spec, part=str(FIRST_TILE)),)
    items = [find_object(scene, each) for each in spec.objects or (name,)]
    slots = [slot.material for item in items for slot in item.material_slots]
    found = dict.fromkeys(material.name for material in slots if material is not None)
    return tuple(replace(spec, part=part) for part in found or (NO_MATERIAL,))


def may_lack_parts(scene: bpy.types.Scene, names: Sequence[str], spec: BakeSpec) -> bool:
    """Whether `guessed_parts` may miss parts: UDIM tiles, materials set by geometry nodes, empty slots."""
    if spec.split is None or spec.part is not None:
        return False
    return spec.split is Split.UDIM or any(_may_lack(find_object(scene, name)) for name in names)


def _may_lack(item: bpy.types.Object) -> bool:
    slots = [slot.material for slot in item.material_slots]
    return not slots or None in slots or any(modifier.type == "NODES" for modifier in item.modifiers)


def _overlap(faces: Sequence[Bools], chosen: Sequence[Bools]) -> bool:
    """Whether any object has a triangle in both; `faces` and `chosen` have marks (F,) for each object."""
    return any(bool((some & wanted).any()) for some, wanted in zip(faces, chosen, strict=True))


def check_part(name: str, spec: BakeSpec) -> None:
    """Raises InputError for a split without a part, which would be several bakes."""
    if spec.split is not None and spec.part is None:
        raise InputError(
            f"'{name}' has an atlas for each {spec.split}: bake them one by one, each with its part "
            "(job.part_specs tells them)"
        )
