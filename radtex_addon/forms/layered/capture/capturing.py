# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All captures of the layered layout, one after another, each in a scratch scene of its own."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.light_samples import EndSamples
from ....bake.piece_store import NO_STORE, PieceStore
from ....bake.pieces import Arrays
from ....bake.plan import CapturePlan, plan_capture
from ....bake.progress import Progress, Stage, relayed
from ....bake.rays import PROBE_CELLS, PROBES, LayeredRays, coarser, finer
from ....bake.spec import BakeSpec
from ....bake.thumbnail import Thumbnail
from ....core.arrays import Bools, Floats, Ints
from ....core.texel_map import TexelMap
from ....cycles.find_hidden import find_hidden
from ....cycles.path_ends import path_ends
from ....cycles.sampling import capture_ends, capture_samples
from ....prepare.prepared import Prepared
from ....scene.mesh.surrounding_shapes import Beside, read_beside
from ....scene.scratch import scene_copied
from ..cells import EXIT_CELLS, OWN_RAYS, OWN_SIDE
from ..fit.through import lets_through
from ..lookup.environment import Around
from ..samples import Capture, ExitSamples, OwnRays
from .exits import capture_exits
from .lamps import find_lamps
from .material_maps import capture_maps, depends_on_angle
from .opacity import find_opacity
from .own_rays import capture_own_rays, corner_uvs, own_aim, own_samples
from .panoramas import look_around
from .stored_surroundings import around_of, arrays_of
from .surface_alone import Clear, surface_alone

_OUTSIDE = 1.05  # times the object's radius: a sphere around it
_LEAST_OWN_SIDE = 6


@dataclass(frozen=True, eq=False)
class Captured:
    """What was captured, and its faces' materials (F,).

    `paths` count all that meet light or materials; `rays` those that only ask where the object itself is.
    """

    capture: Capture
    faces: Ints
    paths: int
    rays: int


def capture_layered(
    scratch: bpy.types.Scene,
    prepared: Prepared,
    spec: BakeSpec,
    folder: Path,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
    around: Around | None = None,
) -> Generator[Progress, None, Captured]:
    """Capture the scratch scene's prepared object.

    With what is `around` a bake that is there, only what more samples of its light need. `folder` is for
    temporary files; the `store` stores what is finished; the light is shown in the `thumbnail`. Yields
    progress in texels, then in paths. Raises InputError where no texel is covered or the object is clear
    everywhere, BakeError where Cycles fails.
    """
    meshes = {piece.rendered.name: piece.rendered for piece in prepared.pieces}
    with surface_alone(prepared.original, *meshes.values()) as clear:
        return (yield from _Captures(scratch, prepared, spec, folder, store, thumbnail, clear, around).all())


@dataclass(frozen=True, eq=False)
class _Captures:
    scratch: bpy.types.Scene
    prepared: Prepared
    spec: BakeSpec
    folder: Path
    store: PieceStore
    thumbnail: Thumbnail | None
    clear: Clear
    known: Around | None = None

    def all(self) -> Generator[Progress, None, Captured]:
        scratch, prepared, spec, folder = self.scratch, self.prepared, self.spec, self.folder
        item, rays = prepared.original, LayeredRays.of(spec.samples)
        texels, side = prepared.texels(), max(prepared.width, prepared.height)
        mesh, matrix = prepared.pieces[0].rendered, prepared.matrix_world
        probe = plan_capture(texels, PROBE_CELLS)
        hidden = yield from find_hidden([(mesh, matrix)], probe, folder, self.store)
        without = probe.texel[hidden.buried]
        placed = read_beside(scratch, item).matrix
        fine, triangle = _plan_and_triangles(prepared.texels(finer(side)))
        coarse = plan_capture(texels, 1, without=without)
        opacity = find_opacity(
            scratch, item, mesh, placed, self.clear, coarse, fine, spec.seed, folder, self.store
        )
        without = np.concatenate([without, opacity.cut_out])

        def plan(cells: int) -> CapturePlan:
            return plan_capture(texels, cells, without=without)

        lit = plan(rays.light)
        count = len(lit.texel)
        middle, radius = reach_of(lit)
        of_ends = 0 if self.known is not None else rays.ends
        total = count * (rays.light**2 + 2 * of_ends**2 + 1) + len(fine.texel)
        yield Progress(Stage.CAPTURE, 0, total)
        faces = _materials(prepared.mesh)
        fine_maps, coarse_maps = self._maps("fine", fine), self._maps("coarse", plan(1))
        fine_maps["material"] = fine.placed(faces[triangle][:, None].astype(np.float32), gutter=True)
        del fine, triangle  # they are as large as what is captured
        lone: EndSamples | None = None
        if self.known is None:
            alone = Beside(placed, ())
            with scene_copied(scratch) as copy, path_ends(copy, item, mesh, alone, middle) as ends:
                lone = _lean(capture_ends(ends, plan(rays.ends), spec.seed, folder, self.store))
        done = 2 * count * of_ends**2
        yield Progress(Stage.CAPTURE, done, total)

        def in_paths(step: Progress) -> Progress:
            return Progress(step.stage, done + step.done * rays.light**2, total)

        with scene_copied(scratch) as copy:
            unseen = hidden.of_texels(np.isin(probe.texel, lit.texel)).cells
            steps = capture_samples(copy, lit, unseen, spec.seed, folder, self.store, self.thumbnail)
            light = yield from relayed(steps, in_paths)
        light = replace(light, through=without_zeros(light.through))
        material = texels.triangle.ravel()[lit.texel]
        own = self._own_rays(plan(own_side(count)), material, opacity.fine)
        own = replace(own, rays=replace(own.rays, plan=lit))
        around, looked = (self.known, 0) if self.known is not None else self._around(middle)
        yield Progress(Stage.CAPTURE, total, total)
        exits = None
        if lone is not None:
            lone = replace(lone, plan=lit)  # all plans have the same texels, and each takes memory
        if lone is not None and lets_through(lone, light):
            buckets = plan_capture(prepared.texels(1 / coarser(side)), EXIT_CELLS)
            exits = self._exits(buckets, middle, radius, rays)
        capture = opacity.bare(
            Capture(light, lone, own, around, fine_maps, coarse_maps, faces[material], exits)
        )
        paths = total + len(probe.texel) * PROBES * PROBE_CELLS**2 + looked + opacity.rays
        paths += 0 if exits is None else 3 * exits.weight.size
        return Captured(capture, faces, paths, own.hit.size)

    def _maps(self, name: str, plan: CapturePlan) -> dict[str, Floats]:
        def capture() -> Arrays:
            with scene_copied(self.scratch) as copy:
                slanted = depends_on_angle(self.clear)
                return cast(Arrays, capture_maps(copy, plan, self.spec.seed, self.folder, slanted))

        return dict(self.store.get_or_make(f"maps-{name}", capture))

    def _own_rays(self, plan: CapturePlan, triangle: Ints, alpha: Floats | None) -> OwnRays:
        prepared = self.prepared
        mesh, surface = prepared.pieces[0].rendered, prepared.surface
        uvs = corner_uvs(surface.uv, prepared.mesh)

        def capture() -> Arrays:
            with scene_copied(self.scratch) as copy:
                matrix = read_beside(self.scratch, prepared.original).matrix
                found = capture_own_rays(
                    copy, prepared.original, mesh, matrix, uvs, plan, surface, triangle,
                    self.spec.seed, self.folder, alpha, prepared.uv_layer,
                )  # fmt: skip
            return {"hit": found.hit, "met": found.met, "place": found.place}

        kept = self.store.get_or_make("own", capture)
        hit = cast(Bools, kept["hit"])
        samples = own_samples(plan, own_aim(plan, self.spec.seed), hit)
        return OwnRays(samples, hit, cast(Ints, kept["met"]), kept["place"])

    def _around(self, middle: Floats) -> tuple[Around, int]:
        """What surrounds the object, and how many paths that took."""

        def capture() -> Arrays:
            with scene_copied(self.scratch) as copy:
                lamps = find_lamps(copy, middle, self.folder)
            with scene_copied(self.scratch) as copy:
                seen = look_around(copy, self.prepared.original.name, middle, self.folder, self.spec.seed)
            around = Around(middle, seen.world, seen.layers, lamps)
            return arrays_of(around) | {"paths": np.array([seen.paths], dtype=np.int64)}

        kept = self.store.get_or_make("around", capture)
        return around_of(kept), int(kept["paths"][0])

    def _exits(self, plan: CapturePlan, middle: Floats, radius: float, rays: LayeredRays) -> ExitSamples:
        prepared = self.prepared

        def capture() -> Arrays:
            matrix = read_beside(self.scratch, prepared.original).matrix
            found = capture_exits(
                self.scratch, prepared.original, prepared.pieces[0].rendered, matrix, middle, radius, plan,
                rays.exits, self.spec.seed, self.folder,
            )  # fmt: skip
            parts = ("weight", "direction", "place", "colour")
            return {name: getattr(found, name) for name in parts}

        return ExitSamples(plan, **self.store.get_or_make("exits", capture))


def own_side(texels: int) -> int:
    """Rays along a side of a texel's hemisphere that tell what it sees of the object itself."""
    return min(OWN_SIDE, max(_LEAST_OWN_SIDE, math.isqrt(OWN_RAYS // texels)))


def _lean(ends: EndSamples) -> EndSamples:
    """The same, with what is 0 taking no memory."""
    return replace(
        ends,
        through_weight=without_zeros(ends.through_weight),
        through_end=without_zeros(ends.through_end),
    )


def without_zeros(values: Floats) -> Floats:
    """The values, or if all are 0 an array that takes no memory."""
    return values if values.any() else np.broadcast_to(values.dtype.type(0), values.shape)


def _plan_and_triangles(texels: TexelMap) -> tuple[CapturePlan, Ints]:
    """The plan of one cell for each texel of a map, and the texels' triangles, (K,)."""
    plan = plan_capture(texels, 1)
    return plan, texels.triangle.ravel()[plan.texel]


def material_count(prepared: Prepared) -> int:
    """The number of materials that the faces of a prepared object have, unused slots before them included."""
    return int(_materials(prepared.mesh).max()) + 1


def _materials(mesh: bpy.types.Mesh) -> Ints:
    """The material's number of each face, (F,)."""
    faces = np.empty(len(mesh.polygons), dtype=np.int32)
    cast(Any, mesh.polygons).foreach_get("material_index", faces)
    return faces


def reach_of(plan: CapturePlan) -> tuple[Floats, float]:
    """The middle of the plan's points, (3,) float32, and the radius of a sphere around all of them."""
    places = plan.points
    middle: Floats = ((places.min(axis=0) + places.max(axis=0)) / 2).astype(np.float32)
    return middle, _OUTSIDE * max(float(np.linalg.norm(places - middle, axis=1).max()), 1e-6)
