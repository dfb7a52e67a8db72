# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake a detailed object to a simple one: find where rays along the simple object's normals meet it."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import Any, cast

import bpy
import numpy as np

from ...bake.progress import Progress, Stage
from ...core.arrays import Floats, Ints
from ...core.errors import InputError
from ...core.frame import normalised
from ...core.messages import Message, Setting, do, leave_out
from ...core.texel_map import TexelMap
from ..objects import find_object
from .evaluated import EvaluatedMesh
from .triangle_tree import bare_mesh, triangle_tree

_OF_SIZE = 0.03  # times the simple object's diagonal: the default extrusion
_TOUCHING = 1e-4  # times a cage's largest distance from the surface: the least distance of a ray's start
_CHUNK = 1 << 15  # rays between two reports of progress


@dataclass(frozen=True, eq=False)
class SourceHits:
    """The texels of the object `simple`, moved onto the surface of the source, the object `name`.

    `texels` has the simple object's frames, and the source's positions and facets. `missed` is the number of
    texels whose rays met nothing within the `extrusion`; they are not covered. `extrusion` is in scene units;
    with a `cage` it is the cage's largest distance from the surface. `seen` is a mesh with the source's
    triangles, and its object's matrix (4, 4).
    """

    name: str
    simple: str
    extrusion: float
    texels: TexelMap
    missed: int
    seen: tuple[bpy.types.Mesh, Floats]
    cage: str | None = None

    @property
    def complaint(self) -> Message:
        """The warning about missed texels, with the remedies."""
        share = self.missed / (self.missed + np.count_nonzero(self.texels.covered))
        lacking = f"{100 * share:.2g} % of the texels of '{self.simple}' do not reach '{self.name}' within"
        if self.cage is not None:
            return Message(
                f"{lacking} the cage '{self.cage}', and show their neighbours", (do("move that further out"),)
            )
        wider = do("enlarge the extrusion", Setting.EXTRUSION)
        return Message(f"{lacking} {self.extrusion:.3g}, and show their neighbours", (wider,))


def find_source(
    scene: bpy.types.Scene, simple: bpy.types.Object, name: str, view_layer: str | None = None
) -> bpy.types.Object:
    """The detailed object called `name`, which is baked to `simple`.

    Raises InputError if it is `simple` itself, and as `find_object` does.
    """
    if name == simple.name:
        raise InputError(
            f"object '{name}' is to be baked from itself",
            do("name the detailed one", Setting.FROM),
            leave_out(Setting.FROM),
        )
    return find_object(scene, name, view_layer)


def default_extrusion(position: Floats) -> float:
    """The default extrusion: a share of the diagonal of a surface's positions (V, 3), in their units."""
    return float(_OF_SIZE * np.linalg.norm(position.max(axis=0) - position.min(axis=0)))


def project_to_source(
    texels: TexelMap, source: EvaluatedMesh, simple: str, above: float | Floats, cage: str | None = None
) -> Generator[Progress, None, SourceHits]:
    """Move the texels of the object `simple` onto the source's surface.

    Each texel's ray starts at a distance `above` its point, along its normal; with a `cage`, `above` is
    (H, W, 3), the vectors from the points to the cage. The ray runs through the point and ends at the same
    distance behind it. The point moves to the first triangle that the ray meets, from either side. Yields
    progress in texels. Raises InputError if no ray meets a triangle.
    """
    covered = np.flatnonzero(texels.covered)
    place, normal = (
        field.reshape(-1, 3)[covered].astype(np.float64) for field in (texels.position, texels.normal)
    )
    out, reach = _ways(above, covered, normal)
    extrusion = float(reach.max())
    caster = Caster(source)
    triangle = np.empty(len(covered), dtype=np.int64)
    found = np.empty((len(covered), 3))
    for first in range(0, len(covered), _CHUNK):
        yield Progress(Stage.RASTER, first, len(covered))
        part = slice(first, first + _CHUNK)
        start = place[part] + reach[part, None] * out[part]
        triangle[part], found[part] = caster.cast(start, -out[part], 2 * reach[part])
    yield Progress(Stage.RASTER, len(covered), len(covered))
    hit = triangle >= 0
    if not hit.any():
        larger = do("enlarge the extrusion", Setting.EXTRUSION)
        raise InputError(
            f"object '{simple}' does not reach '{source.name}' within {extrusion:g} of its surface",
            larger if cage is None else do(f"move the cage '{cage}' out"),
            do("bring both to the same place"),
        )
    facet = caster.facet[triangle[hit]]
    facet *= np.where(np.sum(facet * normal[hit], axis=1, keepdims=True) < 0, -1, 1)
    moved = replace(
        texels,
        position=texels.position.copy(),
        facet=texels.facet.copy(),
        triangle=texels.triangle.copy(),
    )
    moved.position.reshape(-1, 3)[covered[hit]] = found[hit]
    moved.facet.reshape(-1, 3)[covered[hit]] = facet
    moved.triangle.reshape(-1)[covered[~hit]] = -1
    return SourceHits(
        name=source.name,
        simple=simple,
        extrusion=extrusion,
        texels=moved,
        missed=int(np.count_nonzero(~hit)),
        seen=(bare_mesh(source.position, source.triangles), source.matrix_world),
        cage=cage,
    )


def _ways(above: float | Floats, covered: Ints, normal: Floats) -> tuple[Floats, Floats]:
    """Unit vectors (K, 3) from texels' points to their rays' starts, and the distances of the starts: (K,).

    Where a cage touches the surface, rays start slightly above the surface, along the normal.
    """
    if not isinstance(above, np.ndarray):
        return normal, np.full(len(covered), float(above))
    offset = above.reshape(-1, 3)[covered]
    far = np.linalg.norm(offset, axis=1)
    least = max(_TOUCHING * float(far.max()), float(np.finfo(np.float32).tiny))
    out = np.where((far > least)[:, None], offset / np.maximum(far, least)[:, None], normal)
    return out, np.maximum(far, least)


class Caster:
    """Casts rays onto an evaluated mesh, in world space: `facet` (F, 3) are its triangles' unit normals."""

    def __init__(self, source: EvaluatedMesh) -> None:
        world = source.world_position
        self._middle = (world.min(axis=0) + world.max(axis=0)) / 2  # BVHTree computes in float32
        places = world - self._middle
        corner = places[source.triangles]
        self.facet = normalised(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
        self._cast = cast(Any, triangle_tree(places, source.triangles)).ray_cast

    def cast(self, start: Floats, way: Floats, reach: Floats) -> tuple[Ints, Floats]:
        """The first triangle that each ray meets, (K,), -1 for none, and the point where: (K, 3).

        Rays begin at `start` (K, 3), along unit vectors `way` (K, 3), and end after `reach` (K,).
        """
        begin = start - self._middle
        met = [
            self._cast(origin, towards, far)
            for origin, towards, far in zip(begin.tolist(), way.tolist(), reach.tolist(), strict=True)
        ]
        triangle = np.array([-1 if index is None else index for _, _, index, _ in met], dtype=np.int64)
        distance = np.array([0.0 if index is None else length for _, _, index, length in met])
        return triangle, start + distance[:, None] * way
