# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the faces that get a twin for their back, add the twins, and mark them like their faces."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import TypeAlias

import bpy
import numpy as np

from ..bake.progress import Steps
from ..bake.spec import BakeSpec
from ..core.arrays import Bools, Floats
from ..scene.mesh.backs import fronts_of, seen_from_behind_steps, with_twins, without_twins
from ..scene.mesh.copy import baked_mesh
from ..scene.mesh.evaluated import EvaluatedMesh

log = logging.getLogger(__name__)

TwoSided: TypeAlias = Bools | None  # of a mesh, the triangles (F,) that get a twin


def find_all_two_sided(meshes: Sequence[EvaluatedMesh], spec: BakeSpec) -> Steps[list[TwoSided]]:
    """Of each mesh, the triangles (F,) that get a twin: see `find_two_sided`. Yields progress."""
    found = []
    for mesh in meshes:
        faces = yield from find_two_sided(mesh, spec)
        found.append(faces)
    return found


def find_two_sided(mesh: EvaluatedMesh, spec: BakeSpec) -> Steps[TwoSided]:
    """The triangles (F,) that are seen from behind; None if there are none, or they cannot get texels.

    With a UV layer of the user's own or with a source they cannot: then a warning is logged. Yields progress.
    """
    faces = yield from seen_from_behind_steps(mesh)
    if not faces.any():
        return None
    if spec.uv_layer is not None or spec.source is not None:
        log.warning(
            "%d triangles of '%s' can be seen from behind, and look there as from the front: "
            "their backs have no texels in a UV layer of your own or with a source",
            np.count_nonzero(faces),
            mesh.name,
        )
        return None
    return faces


def all_with_twins(meshes: Sequence[EvaluatedMesh], doubled: Sequence[TwoSided]) -> list[EvaluatedMesh]:
    """The meshes, with twins of their `doubled` triangles."""
    pairs = zip(meshes, doubled, strict=True)
    return [mesh if faces is None else with_twins(mesh, faces) for mesh, faces in pairs]


def chosen_with_twins(chosen: Sequence[Bools] | None, doubled: Sequence[TwoSided]) -> list[Bools] | None:
    """Extend marks (F,) of the meshes' triangles to their twins, which are marked like the originals."""
    if chosen is None:
        return None
    pairs = zip(chosen, doubled, strict=True)
    return [some if faces is None else np.concatenate([some, some[faces]]) for some, faces in pairs]


def single_copy(mesh: EvaluatedMesh, uv: Floats, layer: str) -> bpy.types.Mesh | None:
    """The baked copy of a mesh without its twins and their `uv` (F, 3, 2); None if it has no twins."""
    own = fronts_of(mesh)
    return None if own.all() else baked_mesh(without_twins(mesh), uv[own], layer)
