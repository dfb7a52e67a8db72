# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepare objects for a bake, up to the surface points that it captures: the same for every layout."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from ..bake.hidden_cells import HiddenCells
from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress, Stage, Steps, finished
from ..core.arrays import Bools, Floats, Ints
from ..core.inset import inset
from ..core.islands import areas_on_surface
from ..core.near_digest import DIGEST, NearHash
from ..core.seams import Seams, beyond_seams
from ..core.surface import SurfaceMesh, ray_offset
from ..core.texel_map import TexelMap, rasterise
from ..core.uv_map import UvMap
from ..cycles.find_hidden import find_hidden
from ..formats import sidecar
from ..formats.fingerprint import Fingerprint
from ..scene.camera_place import camera_points
from ..scene.digests import scene_digests
from ..scene.geometry_digests import matrix_digest, mesh_digest
from ..scene.mesh.backs import with_fronts_alone
from ..scene.mesh.copy import baked_mesh_steps, surface_mesh
from ..scene.mesh.evaluated import EvaluatedMesh, evaluate
from ..scene.mesh.joined import joined_surface
from ..scene.mesh.materials import material_numbers_of, write_material_numbers
from ..scene.mesh.mesh_parts import number_parts
from ..scene.mesh.named_regions import chosen_triangles
from ..scene.mesh.painted_weights import painted_triangles, unpainted_warning
from ..scene.mesh.panes import Panes, find_panes
from ..scene.mesh.source_hits import SourceHits
from ..scene.units import metres_per_unit
from ..settings.choices import Backs
from ..settings.rays import PROBE_CELLS, side_in
from ..settings.spec import BakeSpec
from ..settings.texel_density import capped_warning
from .detailed import Detailed, read_detailed
from .faces import (
    all_once,
    all_with_twins,
    chosen_once,
    chosen_with_twins,
    faults_told,
    find_once,
    find_two_sided,
    single_copy,
)
from .facts import facts_of
from .kept_meshes import as_begun
from .map_checks import why_wasteful
from .unwrapping import AtlasPart, Unwrapped, Unwraps, shapes_at, unwrap_surfaces

log = logging.getLogger(__name__)

_RIM = 0.2  # least distance of a ray's start from its triangle's edges, relative to the ray offset
_PAIRED = 1_000_000  # triangles: of more, texels beside seams keep the points of their own islands


@dataclass(frozen=True, eq=False)
class BakedCopy:
    """One object's baked copy: its `mesh`, and its object's `matrix_world` (4, 4).

    If the object is split, `part` (F,) is the number of each triangle's part. If faces that are seen from
    behind have twins, `single` is the mesh without these.
    """

    original: bpy.types.Object
    mesh: bpy.types.Mesh
    matrix_world: Floats
    part: Ints | None = None
    single: bpy.types.Mesh | None = None

    @property
    def rendered(self) -> bpy.types.Mesh:
        """The mesh that Cycles renders for the object: without twins."""
        return self.mesh if self.single is None else self.single


@dataclass(frozen=True, eq=False)
class Prepared:
    """The baked copies, `pieces`, and their `surface` that an atlas called `name` covers.

    The atlas has `width` x `height` texels on the meshes' `uv_layer`, whose `islands`, so many, cover a share
    of it, the `coverage`; their number is None where it was not counted. `wasteful` says why the map wastes
    its atlas, "" if it does not. The `digest` is of shapes and UVs, whatever the objects' matrices. The
    `density` is given if the size follows from one. If an object is split, the surface is only one `part` of
    its `parts`. `counts` is the number of each piece's triangles in the surface, in which the pieces follow
    each other. With a `source`, the points to capture lie on that, the `detailed` object; its mesh `shown`,
    which renders as it does, is made for forms by paths alone. `chosen` (F,) marks the surface's triangles
    that the specification selects, None if it selects none. The `fingerprint` tells what is baked, None if
    that was not read. `scene` is a digest of all that is rendered around it, empty where that is not known.
    `blend` is the name of the .blend that is baked, empty if it was never saved. `panes`: which materials of
    each piece make flat panes; empty where none can be.
    """

    name: str
    pieces: tuple[BakedCopy, ...]
    surface: SurfaceMesh
    uv_layer: str
    width: int
    height: int
    islands: int | None
    coverage: float
    wasteful: str
    digest: str
    density: sidecar.TexelDensity | None = None
    part: sidecar.Part | None = None
    parts: tuple[str, ...] = ()
    counts: tuple[int, ...] = ()
    source: SourceHits | None = None
    chosen: Bools | None = None
    detailed: Detailed | None = None
    shown: bpy.types.Mesh | None = None
    fingerprint: Fingerprint | None = None
    scene: str = ""
    blend: str = ""
    panes: tuple[Panes, ...] = ()

    @property
    def original(self) -> bpy.types.Object:
        """The object that is baked, the first of several."""
        return self.pieces[0].original

    @property
    def mesh(self) -> bpy.types.Mesh:
        """The mesh of the baked copy, the first of several."""
        return self.pieces[0].mesh

    @property
    def matrix_world(self) -> Floats:
        """The object's matrix, (4, 4), the first of several."""
        return self.pieces[0].matrix_world

    @property
    def uv_map(self) -> UvMap:
        """The surface's map on the atlas."""
        return UvMap.of_surface(self.surface, self.width, self.height)

    @property
    def rendered(self) -> tuple[tuple[bpy.types.Object, bpy.types.Mesh], ...]:
        """The objects whose light is baked, and meshes that render as they do."""
        if self.detailed is not None and self.shown is not None:
            return ((self.detailed.original, self.shown),)
        return tuple((piece.original, piece.rendered) for piece in self.pieces)

    @property
    def seen(self) -> tuple[tuple[bpy.types.Mesh, Floats], ...]:
        """The meshes that texels' points lie on, and their objects' matrices (4, 4)."""
        if self.source is not None:
            return (self.source.seen,)
        return tuple((piece.rendered, piece.matrix_world) for piece in self.pieces)

    @property
    def source_facts(self) -> sidecar.Source | None:
        """The sidecar's facts about the source, None if there is none."""
        if self.source is None:
            return None
        return sidecar.Source(self.source.name, self.source.extrusion, self.source.missed, self.source.cage)

    def facts(self, spec: BakeSpec) -> sidecar.Sidecar:
        """The sidecar's facts about the bake."""
        return facts_of(
            self.name,
            spec,
            self.width,
            self.height,
            self.uv_layer,
            mesh=self.digest,
            source=self.source_facts,
            part=self.part,
            islands=self.islands,
            coverage=self.coverage,
            texel_density=self.density,
            wasteful=self.wasteful,
            fingerprint=self.fingerprint,
            blend=self.blend,
        )

    def sized(self, spec: BakeSpec) -> BakeSpec:
        """The specification with the atlas's own number of texels, if these follow from a density."""
        return spec if spec.density is None else replace(spec, texels=max(self.width, self.height))

    def plan_of_seen(
        self, bucket: int, folder: Path, store: PieceStore = NO_STORE
    ) -> Generator[Progress, None, CapturePlan]:
        """Plan the capture without hidden texels, which lie where one part of the mesh is stuck into another.

        Blended, they would darken their neighbours; instead they are filled by dilation, as gutters are.
        Yields progress.
        """
        texels = self.texels()
        probe = plan_capture(texels, PROBE_CELLS)
        hidden = yield from self.hidden(probe, texels, folder, store)
        return plan_capture(texels, bucket, without=probe.texel[hidden.buried])

    def hidden(
        self, plan: CapturePlan, texels: TexelMap, folder: Path, store: PieceStore = NO_STORE
    ) -> Generator[Progress, None, HiddenCells]:
        """Find the hidden cells of a plan of the `texels`: see `find_hidden`."""
        owner = self.owners(plan, texels) if len(self.pieces) > 1 else None
        return (yield from find_hidden(self.seen, plan, folder, store, owner))

    def owners(self, plan: CapturePlan, texels: TexelMap) -> Ints:
        """The number of the piece that each of a plan's `texels` lies on, (K,)."""
        if len(self.pieces) == 1:
            return np.zeros(len(plan.texel), dtype=np.int64)
        owner: Ints = np.repeat(np.arange(len(self.pieces)), self.counts)[texels.triangle.ravel()[plan.texel]]
        return owner

    def texels(self, finer: float = 1) -> TexelMap:
        """The points to capture, `finer` times as many along each side; the source's own if there is one."""
        if self.source is not None and finer == 1:
            return self.source.texels
        found = self._own_texels(finer)
        return found if self.detailed is None else finished(self.detailed.project(self.surface, found)).texels

    @cached_property
    def _seams(self) -> Seams:
        return Seams.of(self.surface)

    def _own_texels(self, finer: float = 1) -> TexelMap:
        """The points on the meshes themselves."""
        found = rasterise(self.surface, side_in(self.width, 1 / finer), side_in(self.height, 1 / finer))
        if len(self.surface.triangles) <= _PAIRED:
            found = beyond_seams(found, self.surface, self._seams)
        if len(self.pieces) == 1:
            return inset(found, self.surface, _RIM * ray_offset(self.surface.position))
        offset = np.repeat([_own_offset(piece) for piece in self.pieces], self.counts)
        own = np.where(found.covered, offset[found.triangle], 0).astype(np.float32)
        return replace(inset(found, self.surface, _RIM * offset), offset=own)


def _own_offset(piece: BakedCopy) -> float:
    """The ray offset for one of several objects: from its own extent, not from that of all together."""
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
    """Evaluate and unwrap the scratch scene's objects; the copies' meshes are appended to `kept`.

    Faults of the meshes are logged as warnings, and triangles that are there twice are taken once.
    The `store` gets the digests of the scene and the unwrap; `unwraps` is a cache of unwraps, for several
    calls. The atlas is called `name`, by default like the first object. With `backs`, faces that are seen
    from behind get twins (`scene.mesh.backs`), except with a UV layer of the user's own or with a source.
    Yields progress; the last stage, RASTER, goes on in `texels`. Raises InputError for objects that cannot be
    baked, or if the store has pieces of another bake.
    """
    yield Progress(Stage.EVALUATE, 0, 1)
    evaluated = _evaluated(scratch, originals, spec)
    if store is not NO_STORE:
        for mesh in evaluated:
            of = f" of '{mesh.name}'" if len(evaluated) > 1 else ""
            store.set_facts({f"mesh{of}": str(mesh_digest(mesh)), f"object's place{of}": matrix_digest(mesh)})
    chosen = None if spec.where is None else chosen_triangles(scratch, originals, spec.where)
    detailed = read_detailed(scratch, originals[0], spec, store)
    if store is not NO_STORE:
        store.set_facts(scene_digests(scratch))
    metres = metres_per_unit(scratch)
    if store is not NO_STORE and spec.density is not None:
        store.set_facts({"scene's unit in metres": str(metres)})
    evaluated = [as_begun(mesh, store, f"mesh-{number}") for number, mesh in enumerate(evaluated)]
    if detailed is not None:
        detailed = replace(detailed, mesh=as_begun(detailed.mesh, store, "mesh-source"))
    shapes = evaluated
    if spec.unwrap_at is not None and spec.unwrap_at != spec.frame:
        shapes = shapes_at(scratch, originals, spec.unwrap_at, evaluated, spec.texel_weights)
    told = faults_told(  # of the meshes as they are
        evaluated, None if detailed is None else detailed.mesh
    )
    distinct = [find_once(mesh) for mesh in evaluated]
    shapes, evaluated = all_once(shapes, distinct), all_once(evaluated, distinct)
    chosen = chosen_once(chosen, distinct)
    panes = _panes_of(scratch, originals, evaluated, spec)
    if backs:
        doubled = yield from find_two_sided(scratch, originals, evaluated, spec)
        shapes, evaluated = all_with_twins(shapes, doubled), all_with_twins(evaluated, doubled)
        chosen = chosen_with_twins(chosen, doubled)
    evaluated = with_fronts_alone(evaluated, panes)
    yield Progress(Stage.UNWRAP, 0, 1)
    cameras = None if spec.backs is Backs.ALL else camera_points(scratch)
    with told:
        unwrapped = yield from unwrap_surfaces(
            shapes, spec, metres, store, {} if unwraps is None else unwraps, cameras
        )
    yield Progress(Stage.RASTER, 0, 1)
    prepared = yield from _joined(
        name or originals[0].name, originals, evaluated, unwrapped, spec, chosen, metres
    )
    prepared = replace(prepared, panes=panes)
    kept.extend(piece.mesh for piece in prepared.pieces)
    kept.extend(piece.single for piece in prepared.pieces if piece.single is not None)
    if detailed is None:
        return prepared
    landing = yield from detailed.project(prepared.surface, prepared.texels())
    if landing.missed:
        log.warning(landing.complaint)
    prepared = replace(prepared, source=landing, detailed=detailed)
    return _with_materials_of(detailed, prepared, evaluated[0]) if spec.form.by_paths else prepared


def _evaluated(
    scratch: bpy.types.Scene, originals: Sequence[bpy.types.Object], spec: BakeSpec
) -> list[EvaluatedMesh]:
    """The objects' meshes, with their texel weights if the specification names some."""
    found = [evaluate(scratch, original, spec.texel_weights) for original in originals]
    if spec.texel_weights is not None and painted_triangles(found) is None:
        log.warning(unpainted_warning(originals, spec.texel_weights))
    return found


def _panes_of(
    scratch: bpy.types.Scene,
    originals: Sequence[bpy.types.Object],
    meshes: Sequence[EvaluatedMesh],
    spec: BakeSpec,
) -> tuple[Panes, ...]:
    """The materials of each mesh that make flat panes, for forms that show them as clear; else empty."""
    able = spec.form.by_paths and spec.source is None
    return tuple(find_panes(scratch, originals, meshes)) if able else ()


def _with_materials_of(detailed: Detailed, prepared: Prepared, mesh: EvaluatedMesh) -> Prepared:
    """The same with a rendered mesh, and with the detailed object's slots as the numbers of materials."""
    (piece,) = prepared.pieces
    whole = surface_mesh(mesh, piece.mesh, prepared.uv_layer)
    numbers = detailed.materials(whole, cast(SourceHits, prepared.source).extrusion)
    write_material_numbers([piece.mesh], [numbers])
    if piece.part is not None and prepared.part is not None:
        numbers = numbers[piece.part == prepared.part.index]
    surface = replace(prepared.surface, material=numbers)
    return replace(prepared, surface=surface, shown=detailed.rendered())


def _joined(
    name: str,
    originals: Sequence[bpy.types.Object],
    evaluated: Sequence[EvaluatedMesh],
    unwrapped: Unwrapped,
    spec: BakeSpec,
    chosen: Sequence[Bools] | None,
    metres: float,
) -> Steps[Prepared]:
    index, part = unwrapped.chosen(spec, name)
    pieces, surfaces = [], []
    for number, (original, mesh) in enumerate(zip(originals, evaluated, strict=True)):
        copy = yield from baked_mesh_steps(mesh, unwrapped.uvs[number], unwrapped.layer)
        surfaces.append(surface_mesh(mesh, copy, unwrapped.layer))
        parts = None
        if spec.split is not None:
            parts = number_parts(copy, [each.faces[number] for each in unwrapped.parts])
        single = single_copy(mesh, unwrapped.uvs[number], unwrapped.layer)
        pieces.append(BakedCopy(original, copy, mesh.matrix_world, parts, single))
    if len(pieces) > 1 or spec.split is not None:
        of_parts = None if spec.split is None else [cast(Ints, piece.part) for piece in pieces]
        numbers = material_numbers_of(evaluated, of_parts)
        write_material_numbers([piece.mesh for piece in pieces], numbers)
        surfaces = [replace(one, material=each) for one, each in zip(surfaces, numbers, strict=True)]
    surface = joined_surface(surfaces, part.faces)
    uv_map = UvMap.of_surface(surface, part.width, part.height)
    return Prepared(
        name=name,
        pieces=tuple(pieces),
        surface=surface,
        uv_layer=unwrapped.layer,
        width=part.width,
        height=part.height,
        islands=part.islands,
        coverage=round(uv_map.coverage, 4),
        wasteful=why_wasteful(uv_map),
        digest=_digest(evaluated, unwrapped),
        density=_density(name, surface, part, uv_map.coverage, spec, metres),
        counts=tuple(int(np.count_nonzero(faces)) for faces in part.faces),
        part=None if spec.split is None else sidecar.Part(spec.split, part.name, index),
        parts=() if spec.split is None else tuple(each.name for each in unwrapped.parts),
        chosen=None if chosen is None else _joined_faces(chosen, part),
    )


def _density(
    name: str, surface: SurfaceMesh, part: AtlasPart, coverage: float, spec: BakeSpec, metres: float
) -> sidecar.TexelDensity | None:
    """The density that was asked for, and what the atlas has in the mean; a warning says if it was capped."""
    if spec.density is None:
        return None
    area = metres**2 * float(areas_on_surface(surface.position, surface.triangles).sum())
    reached = float(f"{sqrt(coverage * part.width * part.height / area):.4g}")
    if part.needed:
        whose = f"'{name}', part '{part.name}'," if part.name else f"'{name}'"
        most = max(part.width, part.height)
        log.warning(capped_warning(whose, spec.density, part.needed, most, reached))
    return sidecar.TexelDensity(spec.density, reached)


def _joined_faces(chosen: Sequence[Bools], part: AtlasPart) -> Bools:
    return np.concatenate([some[faces] for some, faces in zip(chosen, part.faces, strict=True)])


def _digest(evaluated: Sequence[EvaluatedMesh], unwrapped: Unwrapped) -> str:
    """A digest of all meshes, whole, so that all parts of a bake have the same digest."""
    exact, near = hashlib.sha256(), NearHash(" ".join(mesh.made_of for mesh in evaluated))
    for mesh, uv in zip(evaluated, unwrapped.uvs, strict=True):
        for values in (mesh.position, mesh.triangles, mesh.normal, uv):
            exact.update(f"{values.shape}".encode())
            exact.update(np.ascontiguousarray(values).reshape(-1).view(np.uint8).data)
            near.feed("", values, varies=mesh.drifts or values is uv)
    found = f"{DIGEST}{exact.hexdigest()}"
    return str(near.digest(found)) if any(mesh.made_of for mesh in evaluated) else found
