# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All captures of the layered layout, one after another, each in a scratch scene of its own."""

from __future__ import annotations

import logging
from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.light_samples import EndSamples, LightSamples
from ....bake.piece_store import NO_STORE, Arrays, PieceStore
from ....bake.plan import CapturePlan, plan_capture
from ....bake.progress import Progress, Stage, StageParts, Steps, relayed
from ....bake.thumbnail import Thumbnail
from ....core.arrays import Bools, Floats, Ints
from ....core.texel_map import TexelMap
from ....cycles.path_ends import Body, path_ends
from ....cycles.sampling import capture_ends, capture_samples
from ....prepare.covered_texels import covered_texels
from ....prepare.prepared import BakedCopy, Prepared
from ....scene.checks.finite_light import black_bake
from ....scene.lights.light import is_dark
from ....scene.mesh.joined import values_in
from ....scene.mesh.render_contents import matrices_in_renders, top_of_render
from ....scene.scratch import find_view_layer, scene_copied
from ....settings.choices import Backs
from ....settings.layered_times import LayeredTimes
from ....settings.rays import PROBE_CELLS, PROBES, LayeredRays, coarser, finer, own_side
from ....settings.spec import BakeSpec
from ..cells import EXIT_CELLS
from ..fit.light_map import PLACES, LightMap
from ..fit.through import lets_through
from ..lookup.environment import Around, Shell
from ..samples import ExitSamples, LayeredSamples, OwnRays
from .enclosed import enclosed
from .exits import capture_exits
from .gloss_maps import capture_gloss, sharpest_width, within_texels
from .lamps import find_lamps, refuse_negative_lamps
from .light_map import capture_light_map
from .material_maps import capture_maps, depends_on_angle
from .misled_rays import find_misled
from .opacity import find_opacity
from .own_rays import SurfaceUV, capture_own_rays, own_aim, own_samples, sides_of
from .panoramas import look_around, share_for
from .room import Room, find_room
from .source_rays import capture_source_rays
from .stored_surroundings import around_of, arrays_of
from .surface_alone import Clear, surface_alone

log = logging.getLogger(__name__)

_OUTSIDE = 1.05  # times the object's radius: a sphere around it
_COVERED = "covered"  # a piece's name


@dataclass(frozen=True, eq=False)
class Captured:
    """What was captured, and the numbers of its faces' materials (F,); the texels' `triangle` (K,).

    `paths` count all that meet light or materials; `rays` those that only ask where the object itself is.
    """

    capture: LayeredSamples
    faces: Ints
    triangle: Ints
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
    surroundings: float = 1.0,
) -> Generator[Progress, None, Captured]:
    """Capture the scratch scene's prepared objects.

    With what is `around` a bake that is there, only what more samples of its light need. `surroundings` is
    as in `BakeJob`. `folder` is for temporary files; the `store` stores what is finished; the light is shown
    in the `thumbnail`. Yields progress, in milliseconds of what is typical. Raises InputError where no texel
    is covered or the objects are clear everywhere, BakeError where Cycles fails.
    """
    originals = [item for item, _ in prepared.rendered]
    meshes = [mesh for _, mesh in prepared.rendered]
    refuse_negative_lamps(scratch)
    top_of_render(scratch)  # before it is copied: each copy would ask anew
    matrices = matrices_in_renders(scratch, originals)
    bodies = tuple(map(Body, originals, meshes, matrices))
    with surface_alone(originals, meshes, prepared.panes) as clear:
        captures = _Captures(
            scratch, prepared, bodies, spec, folder, store, thumbnail, clear, around, surroundings
        )
        return (yield from captures.all())


@dataclass(frozen=True, eq=False)
class _Captures:
    scratch: bpy.types.Scene
    prepared: Prepared
    bodies: tuple[Body, ...]
    spec: BakeSpec
    folder: Path
    store: PieceStore
    thumbnail: Thumbnail | None
    clear: Clear
    known: Around | None = None
    surroundings: float = 1.0

    def all(self) -> Generator[Progress, None, Captured]:
        scratch, prepared, spec, folder = self.scratch, self.prepared, self.spec, self.folder
        bodies, rays = self.bodies, LayeredRays.of(spec.samples)
        texels, side = prepared.texels(), max(prepared.width, prepared.height)
        probe = plan_capture(texels, PROBE_CELLS)
        hidden = yield from prepared.hidden(probe, texels, folder, self.store)
        covered = yield from self._covered(probe, texels)
        without = probe.texel[hidden.buried | (covered & ~(hidden.buried | covered).all())]
        fine, triangle = _plan_and_triangles(prepared.texels(finer(side)))
        coarse = plan_capture(texels, 1, without=without)
        opacity = find_opacity(scratch, bodies, self.clear, coarse, fine, spec.seed, folder, self.store)
        without = np.concatenate([without, opacity.cut_out])

        def plan(cells: int) -> CapturePlan:
            return plan_capture(texels, cells, without=without)

        lit = plan(rays.light)
        count = len(lit.texel)
        middle, radius = reach_of(lit)
        if prepared.part is not None or prepared.source is not None:
            radius = max(radius, *(_radius_around(body.places, middle) for body in bodies))
        of_ends = 0 if self.known is not None else rays.ends
        paths = count * (rays.light**2 + 2 * of_ends**2 + 1) + len(fine.texel)
        times = LayeredTimes(count, replace(rays, ends=of_ends), self.surroundings)
        bar = StageParts(Stage.CAPTURE, times.capture)
        yield bar.at("maps")
        room, passing = self._room(lit)
        faces = prepared.surface.material_numbers
        fine_maps = self._fine_maps(fine, triangle)
        coarse_maps = self._maps("coarse", plan(1))
        del fine, triangle  # they are as large as what is captured
        yield bar.at("ends")
        lone = None if self.known is not None else self._ends(plan(rays.ends), middle, passing)

        unseen = hidden.of_texels(np.isin(probe.texel, lit.texel)).cells
        material = texels.triangle.ravel()[lit.texel]
        within = self._within(plan(1), material, PLACES) if opacity.fine is None else None
        light, light_map = yield from self._light(lit, within, unseen, coarse_maps, faces[material], bar)
        yield bar.at("own")
        if prepared.source is None:
            own = self._own_rays(plan(own_side(count)), texels.own_triangle.ravel()[lit.texel], opacity.fine)
        else:
            own = self._source_rays(plan(own_side(count)), coarse, opacity.coarse)
        own = replace(own, rays=replace(own.rays, plan=lit))
        yield bar.end()
        through = lone is not None and lets_through(lone, light)
        if lone is not None:
            lone = replace(lone, plan=lit)  # all plans have the same texels, and each takes memory
        found = yield from self._surrounded(
            own, lit, plan(own_side(count)), (middle, radius), through, times, room, coarse_maps
        )
        own, around, exits, looked = found
        capture = opacity.bare(
            LayeredSamples(
                light,
                lone,
                own,
                around,
                fine_maps,
                coarse_maps,
                faces[material],
                exits,
                light_map,
                passing=passing,
            )
        )
        paths += len(probe.texel) * PROBES * PROBE_CELLS**2 + looked + opacity.rays + own.traced
        paths += 0 if exits is None else 3 * exits.weight.size
        paths += 0 if light_map is None else light_map.paths
        return Captured(capture, faces, material, paths, own.hit.size)

    def _covered(self, plan: CapturePlan, texels: TexelMap) -> Steps[Bools]:
        """Which texels of a plan are under, behind or inside a neighbour, (K,); see `covered_texels`."""
        kept = self.store.found(_COVERED)
        if kept is None:
            every = self.spec.backs is Backs.ALL
            covered = yield from covered_texels(self.scratch, self.bodies, self.prepared, plan, texels, every)
            kept = {"texels": covered}
            self.store.keep(_COVERED, kept)
        return cast(Bools, kept["texels"])

    def _surrounded(
        self,
        own: OwnRays,
        lit: CapturePlan,
        own_plan: CapturePlan,
        reach: tuple[Floats, float],
        through: bool,
        times: LayeredTimes,
        room: Room | None,
        maps: dict[str, Floats],
    ) -> Steps[tuple[OwnRays, Around, ExitSamples | None, int]]:
        """Own rays with the misled ones, what surrounds the objects, what leaves them, and its paths.

        `reach`: their middle and radius; `through`: they let light through; the `room` that they stand in;
        `maps` are those of the texels' materials.
        """
        share = self.surroundings
        if room is not None and not through:  # of rough things, which take most of their time there
            share *= share_for(sharpest_width(self.bodies, maps.get("width")))
        bar = StageParts(Stage.SURROUNDINGS, times.around_clear if through else times.around)
        yield bar.at("pictures")
        with enclosed(self.scratch, self.bodies if through else ()) as inside:
            around, looked = self._around(lit, *reach, inside, room, share)
            exits = None
            if through:
                yield bar.at("exits")
                exits = self._exits((*self.bodies, *inside), *reach, times.rays.exits)
            yield bar.at("misled")
            own = self._with_misled(own, own_plan, around, inside, times.rays.light**2 // 4, room)
        yield bar.end()
        return own, around, exits, looked

    def _lit(self, light: LightSamples) -> LightSamples:
        """The light itself; a warning says if there is none in a scene that should have some."""
        lit = light.diffuse.any() or light.mirrored.any() or light.through.any()
        if not lit and not is_dark(self.scratch, find_view_layer(self.scratch, None)):
            log.warning(black_bake(self.prepared.name))
        return light

    def _room(self, plan: CapturePlan) -> tuple[Room | None, bool]:
        """The room around the objects, if there is one, and whether they are part of it."""
        known = self.known is None or any(isinstance(layer.shape, Shell) for layer in self.known.layers)
        if not known or self.prepared.source is not None:
            return None, False
        baked = [body.original for body in self.bodies]
        facet = plan.facet.reshape(-1, 3)[: len(plan.texel)]
        found = find_room(self.scratch, baked, plan.points, facet, self.spec.seed)
        return found, found is not None and bool(found.shown)

    def _light(
        self,
        lit: CapturePlan,
        within: Iterable[CapturePlan] | None,
        unseen: Bools,
        maps: dict[str, Floats],
        material: Ints,
        bar: StageParts,
    ) -> Steps[tuple[LightSamples, LightMap | None]]:
        """The light, as `capture_samples`, and its light map; `within` as there, None for no map."""
        seed, folder, store = self.spec.seed, self.folder, self.store
        with scene_copied(self.scratch) as copy:
            steps = capture_samples(copy, lit, unseen, seed, folder, store, self.thumbnail)
            light = yield from relayed(steps, lambda step: bar.at("light", step.done / step.total))
        light = self._lit(replace(light, through=without_zeros(light.through)))
        yield bar.at("more light")
        if within is None:  # where an object is clear, paths along the normal tell too little
            return light, None
        colour = maps["diffuse"].reshape(-1, 3)[lit.texel].astype(np.float32)
        more = capture_light_map(self.scratch, light, within, colour, material, seed, folder, store)
        found = yield from relayed(more, lambda step: bar.at("more light", step.done / step.total))
        return light, found

    def _ends(self, plan: CapturePlan, middle: Floats, passing: bool) -> EndSamples:
        """Paths through the object; `passing` it if they would meet it after it has mirrored them."""
        with scene_copied(self.scratch) as copy, path_ends(copy, self.bodies, (), middle) as ends:
            for item in ends.copies if passing else ():
                item.visible_glossy = False
            return _lean(capture_ends(ends, plan, self.spec.seed, self.folder, self.store))

    def _within(
        self, plan: CapturePlan, triangle: Ints, *places: Iterable[tuple[float, float]]
    ) -> Iterable[CapturePlan]:
        """As `within_texels`; of a detailed object the plan itself: its surface is another."""
        if self.prepared.source is not None:
            return [plan]
        return within_texels(self.prepared.surface, triangle, plan, *places)

    def _fine_maps(self, fine: CapturePlan, triangle: Ints) -> dict[str, Floats]:
        """Maps of the material, its number among them; `triangle` (K,) are those of the plan's texels."""
        number = self.prepared.surface.material_numbers[triangle][:, None].astype(np.float32)
        maps = self._maps("fine", fine, self._within(fine, triangle))
        return maps | {"material": fine.placed(number, gutter=True)}

    def _maps(
        self, name: str, plan: CapturePlan, within: Iterable[CapturePlan] | None = None
    ) -> dict[str, Floats]:
        """Maps of the material at a plan's points; roughness is the mean of those `within` its texels."""

        def capture() -> Arrays:
            with scene_copied(self.scratch) as copy:
                slanted = depends_on_angle(self.clear)
                found = capture_maps(copy, plan, self.spec.seed, self.folder, slanted)
            if self.known is None:
                plans = [plan] if within is None else within
                width = capture_gloss(self.scratch, self.bodies, plans, self.spec.seed, self.folder)
                if width is not None:
                    found["width"] = plan.placed(width, gutter=True)
            return cast(Arrays, found)

        return dict(self.store.get_or_make(f"maps-{name}", capture))

    def _own_rays(self, plan: CapturePlan, triangle: Ints, alpha: Floats | None) -> OwnRays:
        prepared = self.prepared

        def capture() -> Arrays:
            with scene_copied(self.scratch) as copy:
                found = capture_own_rays(
                    copy, self.bodies, [_uvs(piece, prepared) for piece in prepared.pieces], plan,
                    prepared.surface, triangle, self.spec.seed, self.folder, alpha, prepared.uv_layer,
                )  # fmt: skip
            return _own_arrays(found)

        return self._own_of(plan, self.store.get_or_make("own", capture))

    def _source_rays(self, plan: CapturePlan, everywhere: CapturePlan, alpha: Floats) -> OwnRays:
        def capture() -> Arrays:
            with scene_copied(self.scratch) as copy:
                found = capture_source_rays(
                    copy, self.bodies, plan, everywhere, alpha, self.spec.seed, self.folder
                )
            return _own_arrays(found)

        return self._own_of(plan, self.store.get_or_make("own", capture))

    def _own_of(self, plan: CapturePlan, kept: Mapping[str, Any]) -> OwnRays:
        hit = cast(Bools, kept["hit"])
        samples = own_samples(plan, own_aim(plan, self.spec.seed), hit)
        return OwnRays(samples, hit, cast(Ints, kept["met"]), kept["place"], kept.get("light"))

    def _around(
        self,
        plan: CapturePlan,
        middle: Floats,
        radius: float,
        inside: tuple[Body, ...],
        room: Room | None,
        share: float,
    ) -> tuple[Around, int]:
        """What surrounds the objects, and those `inside` them, and how many paths that took.

        In pictures whose size is a `share` of the usual.
        """
        if self.known is not None:
            return self.known, 0

        def capture() -> Arrays:
            baked = [body.original for body in self.bodies]
            known_as = "" if any(self.prepared.panes) else self.prepared.scene  # panes are clear to all rays
            unseen = [*baked, *(body.original for body in inside)]
            with scene_copied(self.scratch) as copy:
                lamps = find_lamps(copy, baked, plan, middle, self.folder, room)
            with scene_copied(self.scratch) as copy:
                seen = look_around(
                    copy, unseen, middle, radius, self.folder, self.spec.seed, share, room, known_as
                )
            around = Around(middle, seen.world, seen.layers, lamps)
            return arrays_of(around) | {"paths": np.array([seen.paths], dtype=np.int64)}

        kept = self.store.get_or_make("around", capture)
        return around_of(kept), int(kept["paths"][0])

    def _with_misled(
        self,
        own: OwnRays,
        plan: CapturePlan,
        around: Around,
        inside: tuple[Body, ...],
        most: int,
        room: Room | None,
    ) -> OwnRays:
        """The own rays, and those that the surroundings would show wrongly; see `find_misled`.

        Without those that meet the objects where the pictures of a room show them.
        """

        def capture() -> Arrays:
            seed, folder, unseen = self.spec.seed, self.folder, (*self.bodies, *inside)
            if room is not None:
                unseen = tuple(body for body in unseen if body.original not in room.shown)
            found = find_misled(self.scratch, unseen, around, own.hit, plan, most, seed, folder)
            return {} if found is None else vars(found)

        kept = self.store.get_or_make("misled", capture)
        if not kept:
            return own
        bare = own.without(cast(Bools, kept["shown"]))
        asked = cast("Bools | None", kept.get("asked"))  # bakes that were begun earlier lack it
        return bare.with_misled(cast(Bools, kept["rays"]), kept["place"], kept["light"], asked)

    def _exits(self, bodies: tuple[Body, ...], middle: Floats, radius: float, times: int) -> ExitSamples:
        side = max(self.prepared.width, self.prepared.height)
        plan = plan_capture(self.prepared.texels(1 / coarser(side)), EXIT_CELLS)

        def capture() -> Arrays:
            found = capture_exits(
                self.scratch, bodies, middle, radius, plan, times, self.spec.seed, self.folder
            )
            parts = ("weight", "direction", "place", "colour")
            return {name: getattr(found, name) for name in parts}

        return ExitSamples(plan, **self.store.get_or_make("exits", capture))


def _own_arrays(own: OwnRays) -> Arrays:
    light = {} if own.light is None else {"light": own.light}
    return {"hit": own.hit, "met": own.met, "place": own.place} | light


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
    """The number of materials that a prepared surface has, unused numbers before them included."""
    return int(prepared.surface.material_numbers.max()) + 1


def _uvs(piece: BakedCopy, prepared: Prepared) -> SurfaceUV:
    """The texture coordinates of a piece's triangles, of which the atlas may cover a part."""
    mesh: Any = piece.mesh
    uv = values_in(mesh.attributes[prepared.uv_layer].data, "vector", 2).reshape(-1, 3, 2)
    inside = np.ones(len(uv), dtype=bool)
    if piece.part is not None and prepared.part is not None:
        inside = piece.part == prepared.part.index
    return sides_of(uv, piece.mesh, inside)


def _radius_around(places: Floats, middle: Floats) -> float:
    """The radius of a sphere around the middle (3,) that all places (P, 3) are in."""
    return _OUTSIDE * float(np.linalg.norm(places - middle, axis=1).max())


def reach_of(plan: CapturePlan) -> tuple[Floats, float]:
    """The middle of the plan's points, (3,) float32, and the radius of a sphere around all of them."""
    places = plan.points
    middle: Floats = ((places.min(axis=0) + places.max(axis=0)) / 2).astype(np.float32)
    return middle, _OUTSIDE * max(float(np.linalg.norm(places - middle, axis=1).max()), 1e-6)
