# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials on meshes: their numbers on baked copies, and a detailed object's on a simple one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Floats, Ints
from ...core.frame import normalised
from ...core.messages import Message, do
from ...core.surface import SurfaceMesh
from .copy import MATERIAL, baked_mesh, write_face_numbers
from .evaluated import EvaluatedMesh
from .source_hits import Caster

_SPOTS = ((1, 1, 1), (4, 1, 1), (1, 4, 1), (1, 1, 4), (2, 2, 1), (2, 1, 2), (1, 2, 2))  # barycentric
_MIXED = 0.05  # of the simple object's area: from there on, a warning tells of triangles of several materials


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


def rendered_source(source: EvaluatedMesh) -> bpy.types.Mesh:
    """A mesh that renders as the source does, with its materials and attributes, in object space."""
    layer, names = "RadTex source", {attribute.name for attribute in source.attributes}
    while layer in names:
        layer += "_"
    return baked_mesh(source, np.zeros((len(source.triangles), 3, 2), dtype=np.float32), layer)


def source_materials(surface: SurfaceMesh, source: EvaluatedMesh, extrusion: float) -> tuple[Ints, float]:
    """The slot of the source's material on each triangle of the simple object's surface, (F,) int32.

    It is the one that most rays through a few points of the triangle meet, along its normal and within the
    `extrusion`, as texels' rays do. Also the share of the area that shows another one.
    """
    slots = np.clip(source.material_index, 0, max(len(source.materials) - 1, 0)).astype(np.int32)
    if len(np.unique(slots)) == 1:
        return np.full(len(surface.triangles), slots[0], dtype=np.int32), 0.0
    corner = surface.corner_position.astype(np.float64)
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    weight = np.array(_SPOTS, dtype=np.float64)
    weight /= weight.sum(axis=1, keepdims=True)

    def at_spots(values: Floats) -> Floats:
        found: Floats = np.einsum("sc,fcx->fsx", weight, values).reshape(-1, 3)
        return found

    out = normalised(at_spots(surface.normal.astype(np.float64)))
    start = at_spots(corner) + extrusion * out
    met, _ = Caster(source).cast(start, -out, np.full(len(out), 2 * extrusion))
    seen = np.where(met >= 0, slots[met], -1).reshape(len(corner), -1)
    votes = np.stack([(seen == slot).sum(axis=1) for slot in range(int(slots.max()) + 1)])
    votes[np.bincount(slots).argmax()] += votes.sum(axis=0) == 0  # where no ray meets it, the usual one
    other = 1 - votes.max(axis=0) / votes.sum(axis=0)
    return votes.argmax(axis=0).astype(np.int32), float((other * area).sum() / max(area.sum(), 1e-30))


def mixed_materials(simple: str, source: str, share: float) -> Message | None:
    """The warning that triangles show several of the source's materials; None if few do."""
    if share < _MIXED:
        return None
    return Message(
        f"{100 * share:.2g} % of '{simple}' show another material of '{source}' than the rest of their "
        "triangles, and mirror as that one does",
        (do(f"cut the triangles of '{simple}' where the materials of '{source}' meet"),),
    )
