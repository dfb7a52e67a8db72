# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Join the meshes of objects that share an atlas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...core.arrays import Bools
from ...core.surface import SurfaceMesh
from .evaluated import EvaluatedMesh

_APART = 0.1  # times a mesh's extent: the gap between it and the next mesh


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
