# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The detailed object that a simple one is baked from: evaluated, and met by texels' rays."""

from __future__ import annotations

import logging
from collections.abc import Generator
from dataclasses import dataclass

import bpy

from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.progress import Progress
from ..core.arrays import Floats, Ints
from ..core.surface import SurfaceMesh
from ..core.texel_map import TexelMap
from ..scene.geometry_digests import array_digest, matrix_digest, mesh_digest
from ..scene.mesh.cage import find_cage, rays_from_cage, read_cage
from ..scene.mesh.evaluated import EvaluatedMesh, evaluate
from ..scene.mesh.materials import mixed_materials, rendered_source, source_materials
from ..scene.mesh.source_hits import SourceHits, default_extrusion, find_source, project_to_source
from ..settings.spec import BakeSpec

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Detailed:
    """The detailed object `original`, evaluated, of the object called `simple`.

    Its surface is searched for within the `extrusion`, a default if None, or up to the cage called
    `cage_name`, whose vertices are at `cage` (V, 3) in world space.
    """

    original: bpy.types.Object
    mesh: EvaluatedMesh
    simple: str
    extrusion: float | None
    cage_name: str | None
    cage: Floats | None

    def project(self, surface: SurfaceMesh, texels: TexelMap) -> Generator[Progress, None, SourceHits]:
        """Move texels of the simple object's `surface` onto the detailed one: see `project_to_source`."""
        above: float | Floats = self.extrusion or default_extrusion(surface.position)
        if self.cage is not None:
            above = rays_from_cage(self.cage, surface, texels)
        return project_to_source(texels, self.mesh, self.simple, above, self.cage_name)

    def materials(self, surface: SurfaceMesh, extrusion: float) -> Ints:
        """The slots of the detailed object's materials on the simple one's triangles, (F,) int32.

        A warning is logged if many triangles show several of them.
        """
        slots, mixed = source_materials(surface, self.mesh, extrusion)
        warning = mixed_materials(self.simple, self.mesh.name, mixed)
        if warning is not None:
            log.warning(warning)
        return slots

    def rendered(self) -> bpy.types.Mesh:
        """A new mesh that renders as the detailed object does."""
        return rendered_source(self.mesh)


def read_detailed(
    scratch: bpy.types.Scene, original: bpy.types.Object, spec: BakeSpec, store: PieceStore
) -> Detailed | None:
    """The source that the specification names, and its cage, as renders show them; None if it names none.

    The store gets their digests. Raises InputError for a source or a cage that is missing or does not fit.
    """
    if spec.source is None:
        return None
    item = find_source(scratch, original, spec.source)
    source = evaluate(scratch, item)
    if store is not NO_STORE:
        store.set_facts({"source's mesh": str(mesh_digest(source)), "source's place": matrix_digest(source)})
    places = None
    if spec.cage is not None:
        places = read_cage(scratch, original, find_cage(scratch, original, spec.source, spec.cage))
        store.set_facts({"cage's mesh": array_digest(places)})
    return Detailed(item, source, original.name, spec.extrusion, spec.cage, places)
