# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Islands of the meshes' own UV layers: they are kept where they are clean, and packed anew.

An artist's islands are few, and lie along the edges of what is shown. Where they lie in their layer, and how
large they are, is of no use to light: there they overlap, or have no room between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ...core.islands import signed_areas, split_corners, surface_areas, uv_islands
from ...core.surface import stretches
from ..mesh.evaluated import EvaluatedMesh
from ..mesh.flatten import smooth_corners
from ..mesh.merge_islands import apart_from_itself
from .unwrap_options import UnwrapOptions

_SQUEEZED = 0.5  # times as long as on the surface, an island to scale: a texel is twice as long there
_WORST = 0.1  # share of an island's area that may be squeezed more
_OVERLAP = 0.01  # share of an island's covered area that may be covered twice
_FLIPPED = 0.01  # share of an island's area that may lie upside down
_NO_AREA = 1e-12  # of the layer's unit square


@dataclass(frozen=True, eq=False)
class ArtistIslands:
    """Islands to scale: `uv` (F, 3, 2) in scene units, `island` (F,) numbers, -1 for what is not kept."""

    uv: Floats
    island: Ints

    @property
    def kept(self) -> Bools:
        """Which triangles are in islands, (F,)."""
        found: Bools = self.island >= 0
        return found

    @classmethod
    def of_meshes(cls, meshes: Sequence[EvaluatedMesh], options: UnwrapOptions) -> ArtistIslands:
        """The clean islands of each mesh's active UV layer, the meshes one after another.

        An island is clean if it overlaps itself nowhere, lies one way up, and has no part that is squeezed
        much. It ends at sharp edges, and where materials meet, also where the artist's goes on.
        """
        found = [_of_mesh(mesh, options) for mesh in meshes]
        first = np.cumsum([0, *(int(island.max(initial=-1)) + 1 for _, island in found)])
        numbered = [
            np.where(island >= 0, island + start, -1)
            for (_, island), start in zip(found, first, strict=False)
        ]
        return cls(np.concatenate([uv for uv, _ in found]), np.concatenate(numbered))


def _of_mesh(mesh: EvaluatedMesh, options: UnwrapOptions) -> tuple[Floats, Ints]:
    none = np.zeros((len(mesh.triangles), 3, 2)), np.full(len(mesh.triangles), -1)
    if mesh.active_uv is None:
        return none
    uv = mesh.uv(mesh.active_uv).astype(np.float64)
    finite = np.isfinite(uv).all(axis=(1, 2)) & (np.abs(np.nan_to_num(signed_areas(uv))) > _NO_AREA)
    if not finite.any():
        return none
    uv[~finite] = 0
    corner = smooth_corners(mesh, options).reshape(-1, 3)
    island = uv_islands(split_corners(corner, np.where(finite, mesh.material_index, -1)), uv)
    corners = mesh.world_position[mesh.triangles]
    area = surface_areas(corners)
    space = np.bincount(island, area)
    texture = np.bincount(island, np.abs(signed_areas(uv)))
    scale = np.sqrt(np.divide(space, texture, out=np.zeros_like(space), where=texture > 0))
    flat = uv * scale[island][:, None, None]
    clean = _clean(corners, area, flat, island) & (scale > 0)
    clean[np.unique(island[~finite])] = False
    return flat, np.where(clean[island], island, -1)


def _clean(corners: Floats, area: Floats, flat: Floats, island: Ints) -> Bools:
    """Which islands (I,) of triangles `flat` (F, 3, 2) may be kept."""
    count = int(island.max()) + 1
    whole = np.maximum(np.bincount(island, area, minlength=count), 1e-30)
    squeezed = stretches(corners, flat)[:, 1] < _SQUEEZED
    fine: Bools = np.bincount(island, area * squeezed, minlength=count) <= _WORST * whole
    up = np.bincount(island, area * (signed_areas(flat) > 0), minlength=count)
    fine &= np.minimum(up, whole - up) <= _FLIPPED * whole
    fine[fine] = apart_from_itself(flat, island, fine, _OVERLAP)
    return fine
