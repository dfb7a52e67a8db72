# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage's single paths: the light that baselines are fed, of the object and of its surroundings."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from math import ceil, sqrt
from pathlib import Path

import bpy
import numpy as np

from radtex_addon.bake.light_samples import EndSamples, LightSamples, mirrored, spread_shifts
from radtex_addon.bake.piece_store import Arrays
from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.bake.progress import Progress, Stage, relayed
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import fallback_tangent, orthonormal_frame
from radtex_addon.core.gutter import dilate, nearest_covered
from radtex_addon.core.octahedron import direction_to_octahedron, octahedron_cell, octahedron_to_direction
from radtex_addon.core.texel_map import TexelMap
from radtex_addon.cycles.capture_settings import first_hit_only
from radtex_addon.cycles.find_hidden import find_hidden
from radtex_addon.cycles.passes import colour_of
from radtex_addon.cycles.path_ends import Body, PathEnds, path_ends
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.cycles.sampling import (
    DIFFUSE,
    capture_ends,
    capture_samples,
    straight_shifts,
    tiles_of,
)
from radtex_addon.forms.layered.capture.capturing import reach_of
from radtex_addon.scene.mesh.render_contents import read_beside
from radtex_addon.scene.scratch import scene_copied
from radtex_addon.settings.kinds import Kind
from radtex_addon.settings.rays import PROBE_CELLS, PROBES

NEARNESS_SIZE = 64  # cells along a side of a `nearness_map`
_NEAR_SIZE = 64  # cells along a side of the map of near things
_BEFORE = 0.95  # rays to a near thing start at this share of its distance from the middle
_ITSELF = 0.1  # less than the sum of any encoded direction's components: the ray met the black object
_SAMPLES = 16  # samples of a plain bake with 8 x 8 cells that costs as much as the default `Rays`
_FEWEST = {"light": 4, "ends": 2, "around": 2, "panorama": 1}  # with fewer there is nothing to fit
_LARGEST_PANORAMA = 64  # paths per cell, a render of 2048 x 2048: beyond that the texels' own noise is larger


@dataclass(frozen=True)
class Rays:
    """Numbers of paths: `light`² per texel, `ends`² and `around`² per texel twice, `panorama` per cell twice.

    The panorama has `size` x `size` cells, for all texels together.
    """

    light: int = 23
    ends: int = 10
    around: int = 5
    panorama: int = 9
    size: int = 256

    @classmethod
    def of(cls, samples: int) -> Rays:
        """About as many paths as a plain bake with 8 x 8 cells takes: 64 times `samples` per texel."""
        most = cls()
        share = samples / _SAMPLES
        return cls(
            light=max(_FEWEST["light"], round(most.light * sqrt(share))),
            ends=max(_FEWEST["ends"], round(most.ends * sqrt(share))),
            around=max(_FEWEST["around"], round(most.around * sqrt(share))),
            panorama=min(_LARGEST_PANORAMA, max(_FEWEST["panorama"], round(most.panorama * share))),
        )

    @property
    def of_texel(self) -> int:
        """Paths of one texel, without its share of the panorama."""
        return self.light**2 + 2 * self.ends**2 + 2 * self.around**2

    @property
    def of_panorama(self) -> int:
        """Paths of both panoramas; the number per cell is rounded up to a square."""
        return 2 * self.size**2 * ceil(sqrt(self.panorama)) ** 2


@dataclass(frozen=True, eq=False)
class SurroundingsSamples:
    """The light that arrives at the object: P samples of where it comes from, in world space.

    `direction` (P, 3), unit, from the object's `middle` (3,) to the source, its `radiance` (P, 3), and
    `nearness` (P,), one over its distance from the middle.
    """

    middle: Floats
    direction: Floats
    radiance: Floats
    nearness: Floats


@dataclass(frozen=True, eq=False)
class SinglePaths:
    """What baselines are made of, and the number of camera `paths` that it took."""

    light: LightSamples
    ends: EndSamples
    surroundings: SurroundingsSamples
    colour: Floats
    paths: int

    @property
    def plan(self) -> CapturePlan:
        return self.light.plan


def trace_paths(
    scratch: bpy.types.Scene,
    baked: bpy.types.Object,
    mesh: bpy.types.Mesh,
    matrix_world: Floats,
    texels: TexelMap,
    finer: TexelMap,
    rays: Rays,
    seed: int,
    folder: Path,
) -> Generator[Progress, None, SinglePaths]:
    """Capture the scratch scene's object `baked` for baselines.

    `mesh` is the baked copy's mesh, `matrix_world` (4, 4) its object's matrix; `texels` is the atlas's texel
    map, `finer` the diffuse colour's. `folder` is for temporary files. Yields progress in texels,
    then in paths. Raises InputError where no texel is covered, BakeError where Cycles fails.
    """
    probe = plan_capture(texels, PROBE_CELLS)
    hidden = yield from find_hidden([(mesh, matrix_world)], probe, folder)
    buried = hidden.buried
    without = probe.texel[buried]

    def plan(cells: int) -> CapturePlan:
        return plan_capture(texels, cells, without=without)

    lit, fine = plan(rays.light), plan_capture(finer, 1)
    count, all_around = len(lit.texel), rays.of_panorama
    total = count * rays.of_texel + all_around + len(fine.texel)
    middle, radius = reach_of(lit)
    yield Progress(Stage.CAPTURE, 0, total)
    beside = read_beside(scratch, baked)
    bodies = [Body(baked, mesh, beside.matrix)]
    with scene_copied(scratch) as scene, path_ends(scene, bodies, beside.others, middle) as ends:
        found = capture_ends(ends, plan(rays.ends), seed, folder)
        done = 2 * count * rays.ends**2
        yield Progress(Stage.CAPTURE, done, total)
        near = capture_surroundings(scene, ends, plan(rays.around), middle, seed, folder)
    done += 2 * count * rays.around**2
    yield Progress(Stage.CAPTURE, done, total)
    around = panorama_plan(near, middle, radius, rays.size, rays.panorama)
    with scene_copied(scratch) as scene, path_ends(scene, bodies, beside.others, middle) as ends:
        far = capture_surroundings(scene, ends, around, middle, seed, folder)
    done += all_around

    def in_paths(step: Progress) -> Progress:
        return Progress(step.stage, done + step.done * rays.light**2, total)

    with scene_copied(scratch) as scene:
        steps = capture_samples(scene, lit, hidden.of_texels(~buried).cells, seed, folder)
        light = yield from relayed(steps, in_paths)
    with scene_copied(scratch) as scene:
        colour = capture_colour(scene, fine, seed, folder)
    yield Progress(Stage.CAPTURE, total, total)
    probes = len(probe.texel) * PROBES * PROBE_CELLS**2
    return SinglePaths(light, found, joined(near, far), colour, total + probes)


def capture_colour(scene: bpy.types.Scene, plan: CapturePlan, seed: int, folder: Path) -> Floats:
    """Capture the diffuse colour along the normal: (H, W, 3), gutter filled; buckets have one cell."""
    aim = Aim(straight_shifts(len(plan.texel)), DIFFUSE)
    capture = PortalCapture(scene, plan, Kind.RADIANCE, 1, seed, folder, aim)
    first_hit_only(scene)
    tiles = [_trace_colour(capture, tile)["colour"] for tile in tiles_of(plan)]
    return plan.placed(np.concatenate(tiles), gutter=True)


def _trace_colour(capture: PortalCapture, tile: Tile) -> Arrays:
    return {"colour": colour_of(capture.render_passes(tile), "diffuse").reshape(-1, 3)}


def joined(first: SurroundingsSamples, second: SurroundingsSamples) -> SurroundingsSamples:
    """Join two sets of samples that have the same middle."""
    return SurroundingsSamples(
        first.middle,
        np.concatenate([first.direction, second.direction]),
        np.concatenate([first.radiance, second.radiance]),
        np.concatenate([first.nearness, second.nearness]),
    )


def distance_along(direction: Floats, offset: Floats, away: Floats) -> Floats:
    """The distance along `direction` from the origin at which a ray from `offset` along `away` is nearest.

    Returns (P,); all others are (P, 3). Infinite where the two are parallel, or meet behind the origin.
    """
    across = np.cross(direction, away)
    squared = np.sum(across * across, axis=-1)
    along = np.sum(np.cross(offset, away) * across, axis=-1)
    found: Floats = np.where((squared > 1e-8) & (along > 0), along / np.maximum(squared, 1e-8), np.inf)
    return found


def panorama_plan(
    near: SurroundingsSamples, middle: Floats, radius: float, size: int, rays: int
) -> CapturePlan:
    """Plan rays straight away from the object: `rays` per cell of a size x size octahedral map, stratified.

    They start `radius` from `middle` (3,), which is outside the object, or nearer where `near` has met
    something in their direction: then just before it.
    """
    side = int(np.ceil(np.sqrt(rays)))
    count = size * side
    place = (np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2) + 0.5) / count
    direction = octahedron_to_direction(place.astype(np.float32))
    cell = octahedron_cell(direction_to_octahedron(near.direction), _NEAR_SIZE)
    nearness = np.full(_NEAR_SIZE**2, 1 / radius)
    np.maximum.at(nearness, cell, near.nearness / _BEFORE)
    start = (1 / nearness)[octahedron_cell(place, _NEAR_SIZE)].astype(np.float32)
    tangent, bitangent, normal = orthonormal_frame(
        direction, fallback_tangent(direction), np.ones(len(place))
    )
    fields = (middle + start[:, None] * direction, tangent, bitangent, normal, normal)
    packed = [field.reshape(count, count, 3).astype(np.float32) for field in fields]
    return CapturePlan(AtlasLayout(count, count, 1), np.arange(count * count), *packed)


def capture_surroundings(
    scene: bpy.types.Scene,
    ends: PathEnds,
    plan: CapturePlan,
    middle: Floats,
    seed: int,
    folder: Path,
) -> SurroundingsSamples:
    """Look from the object in the mirror direction of each of the plan's cells.

    `middle` (3,) is the object's middle in world space. `scene` is a scratch scene and `ends` its path ends;
    both are unusable afterwards. Rays that meet the object itself give no sample. Raises
    BakeError where Cycles fails.
    """
    count = len(plan.texel)
    shift = straight_shifts(count) if plan.layout.bucket == 1 else spread_shifts(count, seed + 1)
    aim = Aim(shift)

    def trace(shown: bpy.types.Scene, coded: bool = False) -> Floats:
        capture = PortalCapture(shown, plan, Kind.REFLECTION, 1, seed, folder, aim)
        return np.concatenate([_trace_around(capture, tile, coded)["rgb"] for tile in tiles_of(plan)])

    light = trace(scene)
    ends.emit_directions(0)
    ends.blacken_objects()
    coded = trace(ends.scene, coded=True)
    met = coded.sum(axis=1) > _ITSELF
    direction = coded[met] * 2 - 1
    away = mirrored(plan, aim.square(plan.layout.bucket)).reshape(-1, 3)[met]
    start = np.repeat(plan.points, plan.layout.bucket**2, axis=0)[met]
    return SurroundingsSamples(
        middle, direction, light[met], 1 / distance_along(direction, start - middle, away)
    )


def _trace_around(capture: PortalCapture, tile: Tile, coded: bool) -> Arrays:
    passes = capture.render_passes(tile)
    seen = passes.raw_whole if coded else passes.whole
    return {"rgb": seen[..., :3].reshape(-1, 3)}


def nearness_map(samples: SurroundingsSamples, far: float) -> Floats:
    """For each direction from the middle, one over the samples' median distance: (D, D) float32.

    Distances are at most `far`; directions without samples take a neighbour's.
    """
    cell = octahedron_cell(direction_to_octahedron(samples.direction), NEARNESS_SIZE)
    near = np.maximum(samples.nearness, 1 / far)
    order = np.lexsort((near, cell))
    first, last = (
        np.searchsorted(cell[order], np.arange(NEARNESS_SIZE**2), side=side) for side in ("left", "right")
    )
    known = last > first
    if not known.any():  # all rays met the object itself
        return np.full((NEARNESS_SIZE, NEARNESS_SIZE), 1 / far, dtype=np.float32)
    nearness = np.zeros(NEARNESS_SIZE**2, dtype=np.float32)
    nearness[known] = near[order][(first + last - 1)[known] // 2]
    image = nearness.reshape(NEARNESS_SIZE, NEARNESS_SIZE)
    return dilate(image, nearest_covered(known.reshape(image.shape)))
