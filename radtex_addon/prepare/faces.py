# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The faces that a bake takes: those that are there twice once, those seen from behind with a twin."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TypeAlias

import bpy
import numpy as np

from ..bake.progress import Steps
from ..core.arrays import Bools, Floats, Ints
from ..core.errors import InputError
from ..core.islands import areas_on_surface, weld
from ..core.mesh_faults import overlaid, repeated, turned_share
from ..core.messages import Message, Setting, do
from ..scene.mesh.backs import fronts_of, seen_from_behind_steps, with_twins, without_twins
from ..scene.mesh.copy import baked_mesh
from ..scene.mesh.evaluated import EvaluatedMesh
from ..scene.mesh.mesh_parts import taken
from ..scene.mesh.needless_backs import needless_backs
from ..scene.mesh.render_contents import Shape
from ..scene.mesh.scene_rays import Thing, read_things
from ..scene.units import metres_per_unit
from ..settings.choices import Backs
from ..settings.spec import BakeSpec

log = logging.getLogger(__name__)

Once: TypeAlias = Bools | None  # of a mesh, the triangles (F,) that repeat no other; None for all
TwoSided: TypeAlias = Bools | None  # of a mesh, the triangles (F,) that get a twin

_DOUBLED = 0.005  # of a mesh's area that lies on itself, from which on it is told
_TURNED = 0.02  # of its edges: a Möbius strip has a few, too


def mesh_faults(mesh: EvaluatedMesh, texels: bool = True) -> list[Message]:
    """What is wrong with the mesh, and how to mend it; of one that gets no `texels`, what shows."""
    found = []
    place, vertex = _welded(mesh)
    doubled = overlaid(place, vertex)
    area = areas_on_surface(place, vertex)
    if area[doubled].sum() > _DOUBLED * area.sum():
        found.append(
            Message(
                f"{np.count_nonzero(doubled)} of the {len(doubled)} triangles of object '{mesh.name}' lie on "
                "one another, which Cycles shows as dark blotches",
                (do("select all in Edit Mode and choose Mesh > Merge > By Distance"),),
            )
        )
    turned = turned_share(vertex) if texels else 0.0
    if turned > _TURNED:
        found.append(
            Message(
                f"faces of object '{mesh.name}' are turned inside out: along {turned:.0%} of its edges "
                "neighbours face opposite sides, and texels are spent on what nobody sees",
                (do("select all in Edit Mode and choose Mesh > Normals > Recalculate Outside"),),
            )
        )
    return found


@contextmanager
def faults_told(meshes: Sequence[EvaluatedMesh], source: EvaluatedMesh | None) -> Iterator[None]:
    """Log the faults of meshes, and of the source of their texels; inside, they explain InputErrors."""
    faults = [fault for mesh in meshes for fault in mesh_faults(mesh)]
    faults += [] if source is None else mesh_faults(source, texels=False)
    for fault in faults:
        log.warning(fault)
    try:
        yield
    except InputError as error:
        if not faults:
            raise
        problem = f"{error.message.problem}, since {faults[0].problem}"
        raise InputError(problem, *faults[0].remedies, *error.message.remedies) from error


def find_once(mesh: EvaluatedMesh) -> Once:
    """The triangles (F,) without those that repeat an earlier one, of the same material; None if none does.

    The copies need no texels of their own: Cycles, and whoever draws the mesh, shows one of them.
    """
    again = repeated(_welded(mesh)[1], mesh.material_index)
    return ~again if again.any() else None


def all_once(meshes: Sequence[EvaluatedMesh], found: Sequence[Once]) -> list[EvaluatedMesh]:
    """The meshes, of each the triangles that were `found`."""
    pairs = zip(meshes, found, strict=True)
    return [mesh if faces is None else taken(mesh, faces) for mesh, faces in pairs]


def chosen_once(chosen: Sequence[Bools] | None, found: Sequence[Once]) -> list[Bools] | None:
    """The marks (F,) of the meshes' triangles that were `found`."""
    if chosen is None:
        return None
    pairs = zip(chosen, found, strict=True)
    return [some if faces is None else some[faces] for some, faces in pairs]


def _welded(mesh: EvaluatedMesh) -> tuple[Floats, Ints]:
    """The places of the mesh's vertices, each once, and its triangles (F, 3) of these."""
    number = weld(mesh.position)
    place = np.empty((int(number.max(initial=-1)) + 1, 3), dtype=mesh.position.dtype)
    place[number] = mesh.position
    return place, number[mesh.triangles]


def find_two_sided(
    scratch: bpy.types.Scene,
    originals: Sequence[bpy.types.Object],
    meshes: Sequence[EvaluatedMesh],
    spec: BakeSpec,
) -> Steps[list[TwoSided]]:
    """Of each mesh, the triangles (F,) that are seen from behind and get a twin; None if there are none.

    The `meshes` are those of the scratch scene's `originals`. In a UV layer of the user's own, or with a
    source, they cannot have texels of their own: none gets one, and a warning is logged. Another one tells
    whose backs are left out since no camera can see them. Yields progress.
    """
    seen, left_out = yield from seen_backs(scratch, originals, meshes, spec.backs)
    if left_out:
        names = ", ".join(f"'{name}' ({count} triangles)" for name, count in left_out.items())
        log.warning(
            Message(
                f"no camera can see the backs of {names}, which face the outside of a room or lie on "
                "something: they get no texels",
                (do("bake them", Setting.BACKS, value=Backs.ALL),),
            )
        )
    if spec.uv_layer is None and spec.source is None:
        if spec.backs is Backs.NONE:
            yield from _tell_fronts_alone(meshes)
        return [faces if faces.any() else None for faces in seen]
    for mesh, faces in zip(meshes, seen, strict=True):
        if faces.any():
            log.warning(
                "%d triangles of '%s' can be seen from behind, and look there as from the front: "
                "their backs have no texels in a UV layer of your own or with a source",
                np.count_nonzero(faces),
                mesh.name,
            )
    return [None] * len(meshes)


def _tell_fronts_alone(meshes: Sequence[EvaluatedMesh]) -> Steps[None]:
    """Warn of triangles that can be seen from behind, where it was chosen that no back gets texels."""
    for mesh in meshes:
        faces = yield from seen_from_behind_steps(mesh)
        if faces.any():
            log.warning(
                Message(
                    f"{np.count_nonzero(faces)} of {len(faces)} triangles of '{mesh.name}' can be seen from "
                    "behind, and look there as from the front: only front sides are baked",
                    (do("bake their backs, too", Setting.BACKS, value=Backs.AUTO),),
                )
            )


def seen_backs(
    scratch: bpy.types.Scene,
    originals: Sequence[bpy.types.Object],
    meshes: Sequence[EvaluatedMesh],
    backs: Backs,
) -> Steps[tuple[list[Bools], dict[str, int]]]:
    """Of each mesh the triangles (F,) whose backs are to be baked; by name, how many some meshes lost.

    The `meshes` are those of the scratch scene's `originals`; `backs` chooses. Yields progress.
    """
    if backs is Backs.NONE:
        return [np.zeros(len(mesh.triangles), dtype=bool) for mesh in meshes], {}
    seen = []
    for mesh in meshes:
        faces = yield from seen_from_behind_steps(mesh)
        seen.append(faces)
    if backs is Backs.ALL or not any(faces.any() for faces in seen):
        return seen, {}
    around = read_things(scratch, originals)
    baked = [Thing.of(Shape(mesh.position, mesh.triangles), mesh.matrix_world, {}) for mesh in meshes]
    found: list[Bools] = []
    left_out: dict[str, int] = {}
    for number, (mesh, faces) in enumerate(zip(meshes, seen, strict=True)):
        others = [*around, *baked[:number], *baked[number + 1 :]]
        needless = yield from needless_backs(baked[number], faces, others, 1 / metres_per_unit(scratch))
        found.append(faces & ~needless)
        if needless.any():
            left_out[mesh.name] = int(np.count_nonzero(faces & needless))
    return found, left_out


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
