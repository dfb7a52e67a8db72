# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Join meshes and baked copies of objects that share an atlas, or take the part that has its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ...core.surface import SurfaceMesh
from .backs import TWIN, fronts, twin_numbers
from .copy import MATERIAL, NORMAL, OBJECT, SIGN, TANGENT, material_numbers, write_face_numbers
from .evaluated import EvaluatedMesh
from .mesh_parts import PART

_APART = 0.1  # times a mesh's extent: the gap between it and the next mesh
_FIELDS = {NORMAL: ("FLOAT_VECTOR", "vector", 3), TANGENT: ("FLOAT_VECTOR", "vector", 3)}
_SIGN = ("FLOAT", "value", 1)
_UV = ("FLOAT2", "vector", 2)


def side_by_side(meshes: Sequence[EvaluatedMesh], name: str) -> EvaluatedMesh:
    """The meshes joined into one called `name`, in world space, but moved into a row so that none touch.

    Then the unwrap cannot connect two of them. Attributes and materials are left out; the materials' numbers
    are each mesh's own. A single mesh is returned unchanged.
    """
    if len(meshes) == 1:
        return meshes[0]
    positions, triangles, vertices, right = [], [], 0, 0.0
    for mesh in meshes:
        used = mesh.world_position[mesh.triangles].reshape(-1, 3)
        low, size = used.min(axis=0), float(np.ptp(used, axis=0).max())
        positions.append((mesh.world_position - low + [right, 0, 0]).astype(np.float32))
        triangles.append(mesh.triangles + vertices)
        vertices += len(mesh.position)
        right += (1 + _APART) * size
    return replace(
        meshes[0],
        name=name,
        position=np.concatenate(positions),
        triangles=np.concatenate(triangles).astype(np.int32),
        normal=np.concatenate([mesh.world_normal for mesh in meshes], dtype=np.float32),
        material_index=np.concatenate([mesh.material_index for mesh in meshes]),
        materials=(),
        attributes=(),
        matrix_world=np.eye(4),
    )


def joined_surface(surfaces: Sequence[SurfaceMesh], faces: Sequence[Bools]) -> SurfaceMesh:
    """Join surfaces in world space, with only the triangles where their `faces` (F,) are True."""
    if len(surfaces) == 1 and faces[0].all():
        return surfaces[0]
    first = np.cumsum([0, *(len(surface.position) for surface in surfaces)])
    pairs = list(zip(surfaces, faces, strict=True))
    return SurfaceMesh(
        position=np.concatenate([surface.position for surface in surfaces]),
        triangles=np.concatenate(
            [surface.triangles[some] + start for (surface, some), start in zip(pairs, first, strict=False)]
        ),
        normal=np.concatenate([surface.normal[some] for surface, some in pairs]),
        tangent=np.concatenate([surface.tangent[some] for surface, some in pairs]),
        sign=np.concatenate([surface.sign[some] for surface, some in pairs]),
        uv=np.concatenate([surface.uv[some] for surface, some in pairs]),
        material=np.concatenate([surface.material_numbers[some] for surface, some in pairs]),
    )


def joined_copy(
    copies: Sequence[bpy.types.Object],
    uv_layer: str,
    part: int | None,
    more_layers: Sequence[str] = (),
) -> bpy.types.Object:
    """An object whose mesh has all triangles of the copies' meshes, or only those of part number `part`.

    The meshes must be in world space. Only the frame's attributes, the `uv_layer`, the numbers of materials
    and twins are kept, and `more_layers`, 0 where a mesh lacks one; each face has the number of its copy.
    """
    meshes: list[Any] = [copy.data for copy in copies]
    chosen = [_faces_of(mesh, part) for mesh in meshes]
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    corners = np.concatenate(
        [
            values_in(mesh.loops, "vertex_index", 1, np.int32).reshape(-1, 3)[faces] + start
            for mesh, faces, start in zip(meshes, chosen, first, strict=False)
        ]
    )
    place = np.concatenate([values_in(mesh.vertices, "co", 3) for mesh in meshes])
    used, corners = np.unique(corners, return_inverse=True)
    made: Any = bpy.data.meshes.new(copies[0].name)
    made.from_pydata(place[used], [], corners.reshape(-1, 3))
    more = dict.fromkeys(more_layers, _UV)
    for name, (kind, field, width) in {**_FIELDS, SIGN: _SIGN, **more, uv_layer: _UV}.items():
        values = [
            _corners_of(mesh, name, field, width)[faces] for mesh, faces in zip(meshes, chosen, strict=True)
        ]
        made.attributes.new(name, kind, "CORNER").data.foreach_set(field, np.concatenate(values).ravel())
    numbers = [material_numbers(mesh)[faces] for mesh, faces in zip(meshes, chosen, strict=True)]
    write_face_numbers(made, MATERIAL, np.concatenate(numbers))
    owners = np.repeat(np.arange(len(copies)), [len(each) for each in numbers])
    write_face_numbers(made, OBJECT, owners.astype(np.int32))
    twins = _joined_twins(meshes, chosen)
    if twins is not None:
        write_face_numbers(made, TWIN, twins)
    return cast("bpy.types.Object", bpy.data.objects.new(copies[0].name, made))


def _corners_of(mesh: Any, name: str, field: str, width: int) -> Floats:
    """An attribute of the triangles' corners, (F, 3 * width); 0 if the mesh lacks it."""
    if name not in mesh.attributes:
        return np.zeros((len(mesh.polygons), 3 * width), dtype=np.float32)
    found: Floats = values_in(mesh.attributes[name].data, field, width).reshape(-1, 3 * width)
    return found


def _joined_twins(meshes: Sequence[Any], chosen: Sequence[Bools]) -> Ints | None:
    """The values of the attribute TWIN in the joined mesh, (F,); None if no face has a twin."""
    found, first = [], 0
    for mesh, faces in zip(meshes, chosen, strict=True):
        twin = twin_numbers(mesh)
        if twin is None:
            twin = np.full(len(faces), -1, dtype=np.int64)
        place = first - 1 + np.cumsum(faces)  # of each chosen triangle in the joined mesh
        own = fronts(twin)
        pair = np.where(own, np.maximum(twin, 0), -2 - twin)
        there = (twin != -1) & faces[pair]
        moved = np.where(own, place[pair], -2 - place[pair])
        found.append(np.where(there, moved, -1)[faces])
        first += int(np.count_nonzero(faces))
    joined: Ints = np.concatenate(found)
    return joined if (joined != -1).any() else None


def _faces_of(mesh: Any, part: int | None) -> Bools:
    if part is None:
        return np.ones(len(mesh.polygons), dtype=bool)
    found: Bools = values_in(mesh.attributes[PART].data, "value", 1, np.int32)[:, 0] == part
    return found


def values_in(items: Any, field: str, width: int, dtype: type = np.float32) -> Any:
    """A `field` of a mesh's vertices, loops or attribute values, (N, width)."""
    values: Any = np.empty(len(items) * width, dtype=dtype)
    items.foreach_get(field, values)
    return values.reshape(-1, width)
