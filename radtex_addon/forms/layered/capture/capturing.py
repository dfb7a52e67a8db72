# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All captures of the layered layout, one after another, each in a scratch scene of its own."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
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
from ....core.large_arrays import stowed
from ....core.texel_map import TexelMap
from ....cycles.path_ends import Body, PathEnds, path_ends
from ....cycles.sampling import Sheets, capture_ends, capture_samples, ends_aim, light_aim, show_sheets
from ....prepare.covered_texels import covered_texels
from ....prepare.prepared import BakedCopy, Prepared
from ....scene.checks.finite_light import black_bake
from ....scene.lights.light import glows, is_dark
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
from .clear_shape import find_distance_field
from .enclosed import enclosed
from .exits import capture_exits
from .gloss_maps import (
    capture_gloss,
    capture_tangents,
    may_be_brushed,
    sharpest_width,
    widest_blur,
    within_texels,
)
from .lamps import find_lamps, refuse_negative_lamps
from .light_map import capture_light_map
from .material_maps import capture_maps, depends_on_angle
from .misled_rays import find_misled
from .opacity import Opacity, find_opacity
from .own_rays import SurfaceUV, capture_own_rays, own_aim, own_samples, sides_of
from .panoramas import look_around, share_for
from .parts import Part
from .room import Room, find_room
from .source_rays import capture_source_rays
from .stored_surroundings import around_of, arrays_of, arrays_of_field, field_of
from .surface_alone import Clear, surface_alone
from .world_lights import with_world_lights

log = logging.getLogger(__name__)

_OUTSIDE = 1.05  # times the object's radius: a sphere around it
_COVERED = "covered"  # a piece's name
_TRACED = ("weight", "direction", "place", "colour")  # of ExitSamples


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
    with _captures(scratch, prepared, spec, folder, store, thumbnail, around, surroundings) as captures:
        return (yield from captures.all())


def capture_part(
    scratch: bpy.types.Scene,
    prepared: Prepared,
    spec: BakeSpec,
    folder: Path,
    store: PieceStore,
    part: Part,
    clear: bool,
    sheets: Sheets | None = None,
) -> Generator[Progress, None, None]:
    """Make the pieces of one part of what `capture_layered` captures, or this process's share of them.

    The store has all that the part needs; of objects that may be `clear`, that is more. `sheets` of the part
    that were rendered elsewhere take the place of renders. Yields progress. Raises as `capture_layered`, and
    ShareDoneError where these are only a share.
    """
    with _captures(scratch, prepared, spec, folder, store) as captures:
        yield from replace(captures, sheets=sheets).only(part, clear)


def show_parts(
    scratch: bpy.types.Scene,
    prepared: Prepared,
    spec: BakeSpec,
    folder: Path,
    store: PieceStore,
    save: Callable[[Part, bpy.types.Scene, CapturePlan], None],
) -> Generator[Progress, None, None]:
    """Call `save` with scenes that render all sheets of LIGHT and of ENDS, each set up as for its capture.

    The store has all MAPS. Yields progress. Raises as `capture_layered`.
    """
    with _captures(scratch, prepared, spec, folder, store) as captures:
        yield from captures.show(save)


@contextmanager
def _captures(
    scratch: bpy.types.Scene,
    prepared: Prepared,
    spec: BakeSpec,
    folder: Path,
    store: PieceStore,
    thumbnail: Thumbnail | None = None,
    around: Around | None = None,
    surroundings: float = 1.0,
) -> Iterator[_Captures]:
    originals = [item for item, _ in prepared.rendered]
    meshes = [mesh for _, mesh in prepared.rendered]
    refuse_negative_lamps(scratch)
    top_of_render(scratch)  # before it is copied: each copy would ask anew
    matrices = matrices_in_renders(scratch, originals)
    bodies = tuple(map(Body, originals, meshes, matrices))
    with surface_alone(originals, meshes, prepared.panes) as clear:
        yield _Captures(
            scratch, prepared, bodies, spec, folder, store, thumbnail, clear, around, surroundings
        )


@dataclass(frozen=True, eq=False)
class _Ready:
    """What is known before the first path is traced.

    `lit` is the plan of the light's K texels, which are those of `texels` but those `without` samples, by
    their flat indices; of these the plan `coarse` has some more, the `unseen` (K, m, m) cells of `lit` show
    nothing. `reach` is the objects' middle (3,) and the radius of a sphere around them. They are `passing`
    if they are part of the `room`. `faces` (F,) are the numbers of the materials; `triangle` (K,) of the
    texels. The maps in `fine_maps` have `fine_texels`, the hidden cells were `probed` at so many.
    """

    texels: TexelMap
    without: Ints
    rays: LayeredRays
    lit: CapturePlan
    coarse: CapturePlan
    unseen: Bools
    opacity: Opacity
    reach: tuple[Floats, float]
    room: Room | None
    passing: bool
    fine_maps: dict[str, Floats]
    coarse_maps: dict[str, Floats]
    triangle: Ints
    faces: Ints
    fine_texels: int
    probed: int
    times: LayeredTimes
    bar: StageParts

    @property
    def material(self) -> Ints:
        """The numbers of the materials of the light's texels, (K,)."""
        found: Ints = self.faces[self.triangle]
        return found


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
    sheets: Sheets | None = None

    def all(self) -> Generator[Progress, None, Captured]:
        ready = yield from self._ready()
        bar, lit, rays = ready.bar, ready.lit, ready.rays
        yield bar.at("ends")
        lone = self._ends(ready)
        light = yield from self._light(ready)
        light_map = yield from self._light_map(ready, light)
        yield bar.at("own")
        own = self._own(ready)
        own = replace(own, rays=replace(own.rays, plan=lit))
        yield bar.end()
        through = lone is not None and lets_through(lone, light)
        if lone is not None:
            lone = replace(lone, plan=lit)  # all plans have the same texels, and each takes memory
        own, around, exits, looked = yield from self._surrounded(ready, own, through)
        capture = ready.opacity.bare(
            LayeredSamples(
                light,
                lone,
                own,
                around,
                ready.fine_maps,
                ready.coarse_maps,
                ready.material,
                exits,
                light_map,
                passing=ready.passing,
                materials=int(ready.faces.max()) + 1,
            )
        )
        of_ends = 0 if self.known is not None else rays.ends
        paths = len(lit.texel) * (rays.light**2 + 2 * of_ends**2 + 1) + ready.fine_texels
        paths += ready.probed * PROBES * PROBE_CELLS**2 + looked + ready.opacity.rays + own.traced
        paths += 0 if exits is None else 3 * exits.weight.size
        paths += 0 if light_map is None else light_map.paths
        return Captured(capture, ready.faces, ready.triangle, paths, own.hit.size)

    def only(self, part: Part, clear: bool) -> Generator[Progress, None, None]:
        """Make the pieces of one part, or this process's share of them; those that it needs are stored."""
        ready = yield from self._ready()
        if part is Part.ENDS:
            self._ends(ready)
        elif part is Part.LIGHT:
            yield from self._light(ready)
        elif part is Part.MORE_LIGHT:
            yield from self._light_map(ready, (yield from self._light(ready)))
        elif part is Part.OWN:
            self._own(ready)
        elif part is not Part.MAPS:
            through = clear
            if clear:
                lone, light = self._ends(ready), (yield from self._light(ready))
                through = lone is not None and lets_through(lone, light)
                del lone, light
            with enclosed(self.scratch, self.bodies if through else ()) as inside:
                if part is Part.AROUND:
                    self._around(ready, inside, through)
                elif part is Part.MISLED:
                    around, _ = self._around(ready, inside, through)
                    self._with_misled(ready, self._own(ready), around, inside, through)
                elif through:
                    self._exits(ready, inside)

    def show(
        self, save: Callable[[Part, bpy.types.Scene, CapturePlan], None]
    ) -> Generator[Progress, None, None]:
        """As `show_parts`."""
        ready = yield from self._ready()
        seed, plan = self.spec.seed, ready.lit
        with scene_copied(self.scratch) as copy:
            show_sheets(copy, plan, light_aim(plan, seed, self._glows), seed, self.folder)
            save(Part.LIGHT, copy, plan)
        plan = self._plan(ready, ready.rays.ends)
        with self._ends_scene(ready) as ends:
            show_sheets(ends.scene, plan, ends_aim(plan, seed), seed, self.folder)
            with ends.named_alike():
                save(Part.ENDS, ends.scene, plan)

    def _ready(self) -> Steps[_Ready]:
        """What is known before the first path is traced."""
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
        lit = plan_capture(texels, rays.light, without=without)
        middle, radius = reach_of(lit)
        if prepared.part is not None or prepared.source is not None:
            radius = max(radius, *(_radius_around(body.places, middle) for body in bodies))
        of_ends = 0 if self.known is not None else rays.ends
        times = LayeredTimes(len(lit.texel), replace(rays, ends=of_ends), self.surroundings)
        bar = StageParts(Stage.CAPTURE, times.capture)
        yield bar.at("maps")
        room, passing = self._room(lit)
        fine_maps = self._fine_maps(fine, triangle)
        coarse_maps = self._maps("coarse", plan_capture(texels, 1, without=without))
        coarse_maps |= self._tangents(plan_capture(texels, 1, without=without))
        return _Ready(
            texels=texels,
            without=without,
            rays=rays,
            lit=lit,
            coarse=coarse,
            unseen=hidden.of_texels(np.isin(probe.texel, lit.texel)).cells,
            opacity=opacity,
            reach=(middle, radius),
            room=room,
            passing=passing,
            fine_maps=fine_maps,
            coarse_maps=coarse_maps,
            triangle=texels.triangle.ravel()[lit.texel],
            faces=prepared.surface.material_numbers,
            fine_texels=len(fine.texel),
            probed=len(probe.texel),
            times=times,
            bar=bar,
        )

    @property
    def _glows(self) -> bool:
        """Whether the objects could emit light."""
        return any(glows(one) for body in self.bodies for one in body.mesh.materials if one is not None)

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
        self, ready: _Ready, own: OwnRays, through: bool
    ) -> Steps[tuple[OwnRays, Around, ExitSamples | None, int]]:
        """Own rays with the misled ones, what surrounds the objects, what leaves them, and its paths.

        `through`: the objects let light through.
        """
        times = ready.times
        bar = StageParts(Stage.SURROUNDINGS, times.around_clear if through else times.around)
        yield bar.at("pictures")
        with enclosed(self.scratch, self.bodies if through else ()) as inside:
            around, looked = self._around(ready, inside, through)
            exits = None
            if through:
                yield bar.at("exits")
                exits = self._exits(ready, inside)
            yield bar.at("misled")
            own = self._with_misled(ready, own, around, inside, through)
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

    def _light(self, ready: _Ready) -> Steps[LightSamples]:
        """The light, as `capture_samples`."""
        seed, folder, store, bar = self.spec.seed, self.folder, self.store, ready.bar
        with scene_copied(self.scratch) as copy:
            steps = capture_samples(
                copy, ready.lit, ready.unseen, seed, folder, store, self.thumbnail, self.sheets, self._glows
            )
            light = yield from relayed(steps, lambda step: bar.at("light", step.done / step.total))
        emitted = None if light.emitted is None else without_zeros(light.emitted)
        return self._lit(replace(light, through=without_zeros(light.through), emitted=emitted))

    def _light_map(self, ready: _Ready, light: LightSamples) -> Steps[LightMap | None]:
        """The map of the light; None where an object is clear: paths along the normal tell too little."""
        bar, lit = ready.bar, ready.lit
        yield bar.at("more light")
        if ready.opacity.fine is not None:
            return None
        within = self._within(self._plan(ready, 1), ready.triangle, PLACES)
        colour = ready.coarse_maps["diffuse"].reshape(-1, 3)[lit.texel].astype(np.float32)
        seed, folder, store = self.spec.seed, self.folder, self.store
        more = capture_light_map(self.scratch, light, within, colour, ready.material, seed, folder, store)
        return (yield from relayed(more, lambda step: bar.at("more light", step.done / step.total)))

    def _ends(self, ready: _Ready) -> EndSamples | None:
        """Paths through the objects, past them where they are part of a room; None for more samples."""
        if self.known is not None:
            return None
        plan = self._plan(ready, ready.rays.ends)
        with self._ends_scene(ready) as ends:
            return _lean(capture_ends(ends, plan, self.spec.seed, self.folder, self.store, self.sheets))

    @contextmanager
    def _ends_scene(self, ready: _Ready) -> Iterator[PathEnds]:
        middle, _ = ready.reach
        with scene_copied(self.scratch) as copy, path_ends(copy, self.bodies, (), middle) as ends:
            for item in ends.copies if ready.passing else ():
                item.visible_glossy = False
            yield ends

    def _plan(self, ready: _Ready, cells: int) -> CapturePlan:
        return plan_capture(ready.texels, cells, without=ready.without)

    def _own_plan(self, ready: _Ready) -> CapturePlan:
        return self._plan(ready, own_side(len(ready.lit.texel)))

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
                found = capture_maps(copy, plan, self.spec.seed, self.folder, slanted, self._glows)
            if self.known is None:
                plans = [plan] if within is None else within
                width = capture_gloss(self.scratch, self.bodies, plans, self.spec.seed, self.folder)
                if width is not None:
                    found["width"] = plan.placed(width, gutter=True)
            return cast(Arrays, found)

        kept = self.store.get_or_make(f"maps-{name}", capture)
        return {name: stowed(values) for name, values in kept.items()}

    def _tangents(self, plan: CapturePlan) -> dict[str, Floats]:
        """A map of the tangents along which the objects are brushed, if any is."""
        if self.known is not None or not may_be_brushed(self.bodies):
            return {}

        def capture() -> Arrays:
            found = capture_tangents(self.scratch, self.bodies, plan, self.spec.seed, self.folder)
            assert found is not None
            return {"tangent": plan.placed(found, gutter=True)}

        kept = self.store.get_or_make("maps-tangent", capture)
        return {name: stowed(values) for name, values in kept.items()}

    def _own(self, ready: _Ready) -> OwnRays:
        """What the objects show of themselves."""
        prepared, plan, opacity = self.prepared, self._own_plan(ready), ready.opacity
        triangle = ready.texels.own_triangle.ravel()[ready.lit.texel]

        def capture() -> Arrays:
            seed, folder = self.spec.seed, self.folder
            with scene_copied(self.scratch) as copy:
                if prepared.source is not None:
                    found = capture_source_rays(
                        copy, self.bodies, plan, ready.coarse, opacity.coarse, seed, folder
                    )
                else:
                    found = capture_own_rays(
                        copy, self.bodies, [_uvs(piece, prepared) for piece in prepared.pieces], plan,
                        prepared.surface, triangle, seed, folder, opacity.fine, prepared.uv_layer,
                    )  # fmt: skip
            return _own_arrays(found)

        return self._own_of(plan, self.store.get_or_make(Part.OWN, capture))

    def _own_of(self, plan: CapturePlan, kept: Mapping[str, Any]) -> OwnRays:
        kept = {name: stowed(values) for name, values in kept.items()}
        hit = cast(Bools, kept["hit"])
        samples = own_samples(plan, own_aim(plan, self.spec.seed), hit)
        return OwnRays(samples, hit, cast(Ints, kept["met"]), kept["place"], kept.get("light"))

    def _around(self, ready: _Ready, inside: tuple[Body, ...], through: bool) -> tuple[Around, int]:
        """What surrounds the objects, and those `inside` them, and how many paths that took.

        `through`: they let light through.
        """
        if self.known is not None:
            return self.known, 0
        (middle, radius), room, share = ready.reach, ready.room, self.surroundings
        if room is not None and not through:  # of rough things, which take most of their time there
            share *= share_for(sharpest_width(self.bodies, ready.coarse_maps.get("width")))

        def capture() -> Arrays:
            baked = [body.original for body in self.bodies]
            known_as = "" if any(self.prepared.panes) else self.prepared.scene  # panes are clear to all rays
            unseen = [*baked, *(body.original for body in inside)]
            with scene_copied(self.scratch) as copy:
                lamps = find_lamps(copy, baked, ready.lit, middle, self.folder, room)
            with scene_copied(self.scratch) as copy:
                seen = look_around(
                    copy, unseen, middle, radius, self.folder, self.spec.seed, share, room, known_as
                )
            around = Around(middle, seen.world, seen.layers, lamps)
            if may_be_brushed(self.bodies) and not through:
                widest = widest_blur(self.bodies, ready.coarse_maps.get("width"))
                around = with_world_lights(around, widest)
            return arrays_of(around) | {"paths": np.array([seen.paths], dtype=np.int64)}

        kept = self.store.get_or_make(_named(Part.AROUND, through), capture)
        return around_of(kept), int(kept["paths"][0])

    def _with_misled(
        self, ready: _Ready, own: OwnRays, around: Around, inside: tuple[Body, ...], through: bool
    ) -> OwnRays:
        """The own rays, and those that the surroundings would show wrongly; see `find_misled`.

        Without those that meet the objects where the pictures of a room show them.
        """
        room, most = ready.room, ready.rays.light**2 // 4

        def capture() -> Arrays:
            seed, folder, unseen = self.spec.seed, self.folder, (*self.bodies, *inside)
            if room is not None:
                unseen = tuple(body for body in unseen if body.original not in room.shown)
            plan = self._own_plan(ready)
            found = find_misled(self.scratch, unseen, around, own.hit, plan, most, seed, folder)
            return {} if found is None else vars(found)

        kept = self.store.get_or_make(_named(Part.MISLED, through), capture)
        if not kept:
            return own
        bare = own.without(cast(Bools, kept["shown"]))
        asked = cast("Bools | None", kept.get("asked"))  # bakes that were begun earlier lack it
        return bare.with_misled(cast(Bools, kept["rays"]), kept["place"], kept["light"], asked)

    def _exits(self, ready: _Ready, inside: tuple[Body, ...]) -> ExitSamples:
        side = max(self.prepared.width, self.prepared.height)
        plan = plan_capture(self.prepared.texels(1 / coarser(side)), EXIT_CELLS)
        bodies, times = (*self.bodies, *inside), ready.rays.exits

        def capture() -> Arrays:
            found = capture_exits(
                self.scratch, bodies, *ready.reach, plan, times, self.spec.seed, self.folder
            )
            kept = {name: getattr(found, name) for name in _TRACED}
            if self.prepared.source is None:
                field = find_distance_field(self.scratch, bodies, ready.reach[0])
                kept |= {} if field is None else arrays_of_field(field)
            return kept

        kept = self.store.get_or_make(Part.EXITS, capture)
        traced = {name: kept[name] for name in _TRACED}
        return ExitSamples(plan, **traced, field=field_of(kept))


def _named(part: Part, through: bool) -> str:
    """A piece's name: pictures and misled rays are others where the objects let light through."""
    return f"{part}-through" if through else part


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
