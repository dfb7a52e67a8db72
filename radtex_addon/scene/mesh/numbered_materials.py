# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers by which an atlas tells materials apart, on the faces of its baked copies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Ints
from .copy import MATERIAL, write_face_numbers
from .evaluated import EvaluatedMesh


def material_numbers_of(meshes: Sequence[EvaluatedMesh], parts: Sequence[Ints] | None = None) -> list[Ints]:
    """The number of each triangle's material in its atlas, (F,) int32 for each mesh.

    Of one mesh it is the material's slot. Several meshes that share an atlas have one number for each
    material, whichever slots it is in. If surfaces are split, `parts` (F,) are the triangles' parts, and the
    materials of each part, whose atlas it has alone, are counted from 0.
    """
    if len(meshes) == 1 and parts is None:
        return [meshes[0].material_index.astype(np.int32)]
    known: dict[tuple[int, int], int] = {}  # by part and material
    found = []
    for number, mesh in enumerate(meshes):
        part = np.zeros(len(mesh.triangles), dtype=np.int32) if parts is None else parts[number]
        slots = [0 if material is None else material.session_uid for material in mesh.materials] or [0]
        slot = np.clip(mesh.material_index, 0, len(slots) - 1)
        pairs, inverse = np.unique(np.stack([part, slot], axis=1), axis=0, return_inverse=True)
        numbers = []
        for of_part, place in pairs.tolist():
            key = of_part, slots[place]
            if key not in known:
                known[key] = sum(other == of_part for other, _ in known)
            numbers.append(known[key])
        found.append(np.array(numbers, dtype=np.int32)[inverse.reshape(-1)])
    return found


def write_material_numbers(copies: Sequence[bpy.types.Mesh], numbers: Sequence[Ints]) -> None:
    """Give baked copies the attribute MATERIAL, where their materials have more than one number."""
    several = any(each.any() for each in numbers)
    for copy, each in zip(copies, numbers, strict=True):
        attributes = cast(Any, copy).attributes
        if several:
            write_face_numbers(copy, MATERIAL, each)
        elif (attribute := attributes.get(MATERIAL)) is not None:
            attributes.remove(attribute)
