# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which faces of what is baked get a twin for their back, and what is asked for faces then."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import TypeAlias

import bpy
import numpy as np

from ..bake.spec import BakeSpec
from ..core.arrays import Bools, Floats
from ..scene.mesh.backs import fronts_of, seen_from_behind, with_twins, without_twins
from ..scene.mesh.copy import baked_mesh
from ..scene.mesh.evaluated import EvaluatedMesh

log = logging.getLogger(__name__)

Doubled: TypeAlias = Bools | None  # of a mesh, the triangles (F,) that get a twin


def find_doubled(mesh: EvaluatedMesh, spec: BakeSpec) -> Doubled:
    """The triangles that are seen from behind; None where there are none, or no texels can be made for them.

    That is with a UV layer of the user's own, and where a source is baked: the log says so.
    """
    faces = seen_from_behind(mesh)
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


def all_with_twins(meshes: Sequence[EvaluatedMesh], doubled: Sequence[Doubled]) -> list[EvaluatedMesh]:
    """The meshes, with twins of those triangles."""
    pairs = zip(meshes, doubled, strict=True)
    return [mesh if faces is None else with_twins(mesh, faces) for mesh, faces in pairs]


def chosen_with_twins(chosen: Sequence[Bools] | None, doubled: Sequence[Doubled]) -> list[Bools] | None:
    """Marks (F,) of the meshes' triangles, with those of their twins, which are marked alike."""
    if chosen is None:
        return None
    pairs = zip(chosen, doubled, strict=True)
    return [some if faces is None else np.concatenate([some, some[faces]]) for some, faces in pairs]


def single_copy(mesh: EvaluatedMesh, uv: Floats, layer: str) -> bpy.types.Mesh | None:
    """The baked copy of a mesh without its twins, on their part of `uv` (F, 3, 2); None if it has none."""
    own = fronts_of(mesh)
    return None if own.all() else baked_mesh(without_twins(mesh), uv[own], layer)
