# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a bake of a surface that is split to one bake for each of its parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy

from ..bake.spec import BakeSpec
from ..core.arrays import Bools
from ..core.errors import InputError
from ..prepare.unwrapping import split_surfaces
from ..scene.frames import at_frame
from ..scene.mesh.evaluated import evaluate
from ..scene.mesh.named_regions import chosen_triangles
from ..scene.objects import find_object
from ..scene.scratch import scratch_scene


def part_specs(
    scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None = None
) -> tuple[BakeSpec, ...]:
    """The specification once for every part that it splits the object `name`, or its `objects`, into.

    One that is not split, or has its part, is meant as it is. Parts without a face of the place that it names
    are left out. The scene is what it was afterwards. Raises InputError for what cannot be baked, or not
    split, and for a place that has no face at all.
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


def _overlap(faces: Sequence[Bools], chosen: Sequence[Bools]) -> bool:
    """Whether any object has a triangle in both; each has (F,) of each."""
    return any(bool((some & wanted).any()) for some, wanted in zip(faces, chosen, strict=True))


def check_part(name: str, spec: BakeSpec) -> None:
    """Raises InputError for a split without a part, which is no single bake."""
    if spec.split is not None and spec.part is None:
        raise InputError(
            f"'{name}' has an atlas for each {spec.split}: bake them one by one, each with its part "
            "(job.part_specs tells them)"
        )
