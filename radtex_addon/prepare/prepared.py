# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From objects to the points on them that a bake captures: the same for every layout."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ..bake.hidden import HiddenCells
from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress, Stage
from ..bake.rays import PROBE_CELLS
from ..bake.spec import BakeSpec
from ..core.arrays import Bools, Floats, Ints
from ..core.inset import inset
from ..core.ray_offset import ray_offset
from ..core.surface import SurfaceMesh
from ..core.texel_map import TexelMap, rasterise
from ..cycles.hidden import find_hidden
from ..formats import sidecar
from ..scene.digests import array_digest, matrix_digest, mesh_digest, scene_digests
from ..scene.mesh.cage import find_cage, rays_from_cage, read_cage
from ..scene.mesh.copy import baked_mesh, surface_mesh
from ..scene.mesh.evaluated import EvaluatedMesh, evaluate
from ..scene.mesh.named_regions import chosen_triangles
from ..scene.mesh.parts import number_parts
from ..scene.mesh.source import Landing, default_extrusion, find_source, land
from ..scene.mesh.together import joined_surface
from .facts import facts_of
from .twins import all_with_twins, chosen_with_twins, find_doubled, single_copy
from .unwrapping import AtlasPart, Unwrapped, Unwraps, shapes_at, unwrap_surfaces

log = logging.getLogger(__name__)

_RIM = 0.2  # of a ray's offset: how far from its triangle's edges a ray starts


@dataclass(frozen=True, eq=False)
class Piece:
    """One object's baked copy: its `mesh`, and its object's `matrix_world` (4, 4).

    `part` (F,) numbers the parts that its triangles belong to, where it is split. `single` is the mesh
    without its twins of faces that are seen from behind, where it has such.
    """

    original: bpy.types.Object
    mesh: bpy.types.Mesh
    matrix_world: Floats
    part: Ints | None = None
    single: bpy.types.Mesh | None = None

    @property
    def rendered(self) -> bpy.types.Mesh:
        """What stands for the object where Cycles renders it: the mesh with each face once."""
        return self.mesh if self.single is None else self.single


@dataclass(frozen=True, eq=False)
class Prepared:
    """The baked copies, `pieces`, of which the atlas shows the `surface`, called `name`.

    The atlas has `width` x `height` texels on the meshes' `uv_layer`, and `islands` if it was unwrapped anew.
    The `digest` tells shapes and UVs from others, wherever they stand. Of an object that is split the surface
    is a `part` alone, of the `parts` that there are. Each piece has so many of the surface's triangles as
    `counts` says, one piece's after another's. What is baked lies on the `source`, if there is one. Of
    the surface's triangles those are `chosen` (F,) that the specification names, if it does.
    """

    name: str
    pieces: tuple[Piece, ...]
    surface: SurfaceMesh
    uv_layer: str
    width: int
    height: int
    islands: int | None
    digest: str
    part: sidecar.Part | None = None
    parts: tuple[str, ...] = ()
    counts: tuple[int, ...] = ()
    source: Landing | None = None
    chosen: Bools | None = None

    @property
    def original(self) -> bpy.types.Object:
        """The object that is baked; the first of several."""
        return self.pieces[0].original

    @property
    def mesh(self) -> bpy.types.Mesh:
        """Its baked copy's."""
        return self.pieces[0].mesh

    @property
    def matrix_world(self) -> Floats:
        """Its matrix, (4, 4)."""
        return self.pieces[0].matrix_world

    @property
    def seen(self) -> tuple[tuple[bpy.types.Mesh, Floats], ...]:
        """The meshes that texels' points lie on, and their objects' matrices (4, 4)."""
        if self.source is not None:
            return (self.source.seen,)
        return tuple((piece.rendered, piece.matrix_world) for piece in self.pieces)

    @property
    def source_facts(self) -> sidecar.Source | None:
        """What the sidecar says of the source."""
        if self.source is None:
            return None
        return sidecar.Source(self.source.name, self.source.extrusion, self.source.missed, self.source.cage)

    def facts(self, spec: BakeSpec) -> sidecar.Sidecar:
        """What the sidecar says."""
        return facts_of(
            self.name,
            spec,
            self.width,
            self.height,
            self.uv_layer,
            mesh=self.digest,
            source=self.source_facts,
            part=self.part,
        )

    def plan_of_seen(
        self, bucket: int, folder: Path, store: PieceStore = NO_STORE
    ) -> Generator[Progress, None, CapturePlan]:
        """Where rays start, but for texels that nobody sees, where a part of the mesh is stuck into another.

        These would blend their dark into their neighbours; now what fills gutters fills them.
        """
        texels = self.texels()
        probe = plan_capture(texels, PROBE_CELLS)
        hidden = yield from self.hidden(probe, texels, folder, store)
        return plan_capture(texels, bucket, without=probe.texel[hidden.buried])

    def hidden(
        self, plan: CapturePlan, texels: TexelMap, folder: Path, store: PieceStore = NO_STORE
    ) -> Generator[Progress, None, HiddenCells]:
        """Which cells of a plan of the `texels` nobody sees: see `find_hidden`."""
        owner = None
        if len(self.pieces) > 1:
            triangle = texels.triangle.ravel()[plan.texel]
            owner = np.repeat(np.arange(len(self.pieces)), self.counts)[triangle]
        return (yield from find_hidden(self.seen, plan, folder, store, owner))

    def texels(self, finer: float = 1) -> TexelMap:
        """Points to capture, `finer` times as many along each side; with a source those on it."""
        if self.source is not None:
            return self.source.texels
        found = rasterise(self.surface, round(self.width * finer), round(self.height * finer))
        if len(self.pieces) == 1:
            return inset(found, self.surface, _RIM * ray_offset(self.surface.position))
        offset = np.repeat([_own_offset(piece) for piece in self.pieces], self.counts)
        own = np.where(found.covered, offset[found.triangle], 0).astype(np.float32)
        return replace(inset(found, self.surface, _RIM * offset), offset=own)


def _own_offset(piece: Piece) -> float:
    """How far from one of several objects rays start: by its own size, not by how far others are away."""
    place = np.empty(3 * len(piece.mesh.vertices), dtype=np.float32)
    piece.mesh.vertices.foreach_get("co", place)
    matrix = piece.matrix_world
    return ray_offset(place.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def prepare(
    scratch: bpy.types.Scene,
    originals: Sequence[bpy.types.Object],
    spec: BakeSpec,
    kept: list[bpy.types.ID],
    store: PieceStore = NO_STORE,
    unwraps: Unwraps | None = None,
    name: str = "",
    backs: bool = False,
) -> Generator[Progress, None, Prepared]:
    """Evaluate and unwrap the scratch scene's objects; the copies' meshes join what is `kept`.

    The `store` learns of the scene, and is given the unwrap; `unwraps` that may be this one are, too. The
    atlas is called `name`, or as the first object is. With `backs` faces that are seen from behind get a twin
    (`scene.backs`), but for a UV layer of the user's own, and on a source. Ends
    amid the stage RASTER, which `texels` goes on with. Raises InputError for what cannot be baked, or is not
    what the store's pieces are of.
    """
    yield Progress(Stage.EVALUATE, 0, 1)
    evaluated = [evaluate(scratch, original) for original in originals]
    if store is not NO_STORE:
        for mesh in evaluated:
            of = f" of '{mesh.name}'" if len(evaluated) > 1 else ""
            store.set_facts({f"mesh{of}": mesh_digest(mesh), f"object's place{of}": matrix_digest(mesh)})
    chosen = None if spec.where is None else chosen_triangles(scratch, originals, spec.where)
    source = None if spec.source is None else _evaluate_source(scratch, originals[0], spec.source, store)
    cage = None if spec.cage is None else _read_cage(scratch, originals[0], spec, store)
    if store is not NO_STORE:
        store.set_facts(scene_digests(scratch))
    yield Progress(Stage.UNWRAP, 0, 1)
    shapes = evaluated
    if spec.unwrap_at is not None and spec.unwrap_at != spec.frame:
        shapes = shapes_at(scratch, originals, spec.unwrap_at, evaluated)
    if backs:
        doubled = [find_doubled(mesh, spec) for mesh in evaluated]
        shapes, evaluated = all_with_twins(shapes, doubled), all_with_twins(evaluated, doubled)
        chosen = chosen_with_twins(chosen, doubled)
    unwrapped = yield from unwrap_surfaces(shapes, spec, store, {} if unwraps is None else unwraps)
    yield Progress(Stage.RASTER, 0, 1)
    prepared = _joined(name or originals[0].name, originals, evaluated, unwrapped, spec, chosen)
    kept.extend(piece.mesh for piece in prepared.pieces)
    kept.extend(piece.single for piece in prepared.pieces if piece.single is not None)
    if source is None:
        return prepared
    texels = prepared.texels()
    above: float | Floats = spec.extrusion or default_extrusion(prepared.surface.position)
    if cage is not None:
        above = rays_from_cage(cage, prepared.surface, texels)
    landing = yield from land(texels, source, originals[0].name, above, spec.cage)
    if landing.missed:
        log.warning(landing.complaint)
    return replace(prepared, source=landing)


def _joined(
    name: str,
    originals: Sequence[bpy.types.Object],
    evaluated: Sequence[EvaluatedMesh],
    unwrapped: Unwrapped,
    spec: BakeSpec,
    chosen: Sequence[Bools] | None,
) -> Prepared:
    index, part = unwrapped.chosen(spec, name)
    pieces, surfaces = [], []
    for number, (original, mesh) in enumerate(zip(originals, evaluated, strict=True)):
        copy = baked_mesh(mesh, unwrapped.uvs[number], unwrapped.layer)
        surfaces.append(surface_mesh(mesh, copy, unwrapped.layer))
        parts = None
        if spec.split is not None:
            parts = number_parts(copy, [each.faces[number] for each in unwrapped.parts])
        single = single_copy(mesh, unwrapped.uvs[number], unwrapped.layer)
        pieces.append(Piece(original, copy, mesh.matrix_world, parts, single))
    return Prepared(
        name=name,
        pieces=tuple(pieces),
        surface=joined_surface(surfaces, part.faces),
        uv_layer=unwrapped.layer,
        width=part.width,
        height=part.height,
        islands=part.islands,
        digest=_digest(evaluated, unwrapped),
        counts=tuple(int(np.count_nonzero(faces)) for faces in part.faces),
        part=None if spec.split is None else sidecar.Part(spec.split, part.name, index),
        parts=() if spec.split is None else tuple(each.name for each in unwrapped.parts),
        chosen=None if chosen is None else _joined_faces(chosen, part),
    )


def _joined_faces(chosen: Sequence[Bools], part: AtlasPart) -> Bools:
    return np.concatenate([some[faces] for some, faces in zip(chosen, part.faces, strict=True)])


def _evaluate_source(
    scratch: bpy.types.Scene, original: bpy.types.Object, name: str, store: PieceStore
) -> EvaluatedMesh:
    source = evaluate(scratch, find_source(scratch, original, name))
    if store is not NO_STORE:
        store.set_facts({"source's mesh": mesh_digest(source), "source's place": matrix_digest(source)})
    return source


def _read_cage(
    scratch: bpy.types.Scene, original: bpy.types.Object, spec: BakeSpec, store: PieceStore
) -> Floats:
    assert spec.cage is not None  # who calls this has looked
    places = read_cage(scratch, original, find_cage(scratch, original, spec.source, spec.cage))
    store.set_facts({"cage's mesh": array_digest(places)})
    return places


def _digest(evaluated: Sequence[EvaluatedMesh], unwrapped: Unwrapped) -> str:
    """Of all pieces whole, so that the parts of one bake have the same."""
    found = hashlib.sha256()
    for mesh, uv in zip(evaluated, unwrapped.uvs, strict=True):
        for values in (mesh.position, mesh.triangles, mesh.normal, uv):
            found.update(f"{values.shape}".encode() + np.ascontiguousarray(values).tobytes())
    return f"sha256:{found.hexdigest()}"
