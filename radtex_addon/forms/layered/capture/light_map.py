# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where diffuse light is noisy or has edges, trace more paths along the normal, and denoise it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from math import isqrt
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.kdtree import KDTree

from ....bake.denoising import Denoiser
from ....bake.light_samples import LightSamples
from ....bake.piece_store import Arrays, PieceStore, in_shares
from ....bake.plan import CapturePlan, Tile, plan_of_picked
from ....bake.pooling import Neighbours
from ....bake.progress import Progress, Stage, Steps
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints
from ....core.gutter import nearest_covered
from ....cycles.denoiser import image_denoiser
from ....cycles.passes import colour_of, light_of
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import DIFFUSE, straight_shifts, tiles_of
from ....scene.mesh.render_contents import read_render
from ....scene.scratch import scene_copied
from ....settings.kinds import Kind
from ..fit.diffuse import DARK
from ..fit.light_map import PLACES, LightMap, RoughLight, filled, nearer
from .room import things_of

MORE_LIGHT = "more-light"  # pieces begin with it and a hyphen
_SEEDS = (101, 103)  # beyond the bake's: of the two halves of the paths
_INWARDS = 0.98  # of the way to points within a texel, so that none lies on its triangle's edge
_LIFTED = 0.1  # of the way to a point within a texel, by which a ray to it starts off the surface
_WINDOW = 1024  # texels along a side of what is denoised at once, without the margin
_MARGIN = 32  # texels around it
_BEYOND = 8  # texels of the gutter that show what lies beyond a seam
_SMOOTH = 0.9  # least cosine between normals on both sides of a seam
_ONE_ISLAND = 4.0  # times the usual distance between texels: those farther apart are not of one island


def capture_light_map(
    scratch: bpy.types.Scene,
    light: LightSamples,
    within: Iterable[CapturePlan],
    colour: Floats,
    material: Ints,
    seed: int,
    folder: Path,
    store: PieceStore,
) -> Steps[LightMap | None]:
    """The diffuse light of noisy texels and of edges, by more paths than `light` has, denoised.

    `within` are plans of points in each of its texels, of one cell each; `colour` (K, 3) is the texels'
    diffuse colour, `material` (K,) the numbers of their materials. Yields progress in paths. None where
    nothing is noisy or an edge, or this Blender cannot denoise. Raises BakeError where Cycles fails.
    """
    plan = light.plan
    neighbours = Neighbours(plan)
    rough = RoughLight.of(light, colour, material, neighbours)
    if rough is None:
        return None
    more = yield from _traced(scratch, plan, within, rough.wanted, seed, folder, store)
    known, falloff = rough.with_more(more, material)
    halves = np.stack([filled(half, colour, neighbours) for half in known])
    with image_denoiser(folder) as denoiser:
        if denoiser is None:
            return None
        shown = texels_shown(plan)
        smooth = [denoise_texels(values, plan, shown, denoiser) for values in (*halves, halves.mean(axis=0))]
    found = nearer(halves, np.stack(smooth[:2]), smooth[2], rough.edge, neighbours)
    found[colour <= DARK] = 0
    found[rough.wanted == 0] = np.nan
    return LightMap(found, falloff, rough.edge, int(rough.wanted.sum()))


def _traced(
    scratch: bpy.types.Scene,
    plan: CapturePlan,
    within: Iterable[CapturePlan],
    wanted: Ints,
    seed: int,
    folder: Path,
    store: PieceStore,
) -> Steps[Floats]:
    """Irradiance of a plan's texels by `wanted` (K,) paths along the normal, in two halves: (2, K, 3).

    The mean of points `within` each texel; NaN where no path is wanted, or the colour is too dark.
    """
    points: Floats = large_arrays.stacked(
        plan.points + _INWARDS * (each.points - plan.points) for each in within
    )
    points = _on_this_side(scratch, plan, points, wanted > 0)
    found = np.full((2, len(wanted), 3), np.nan, dtype=np.float32)
    done, total = 0, int(wanted.sum())
    sheet = max(1, plan.sheet // isqrt(points.shape[1]))  # its image of starts is as large as other sheets
    single = replace(plan, layout=replace(plan.layout, bucket=1), sheet=sheet)
    renders = _renders(single, wanted)
    names = [render.name for render in renders]
    shares = (renders[index] for index in in_shares(store, names))
    for number, some in groupby(shares, key=lambda render: render.number):
        texels = np.flatnonzero(wanted == number)
        plan_of_them, samples = plan_of_picked(single, texels), number // 2
        with scene_copied(scratch) as copy:
            aim = Aim(straight_shifts(len(texels)), DIFFUSE, points[texels])
            capture = PortalCapture(copy, plan_of_them, Kind.RADIANCE, samples, seed, folder, aim)
            for render in some:
                capture.reseed(seed + _SEEDS[render.half])
                yield Progress(Stage.CAPTURE, done, total)
                light = store.get_or_make(render.name, partial(_trace, capture, render.tile))["light"]
                first = render.tile.first_row * plan_of_them.columns
                found[render.half, texels[first : first + len(light)]] = light
                done += len(light) * samples
    yield Progress(Stage.CAPTURE, total, total)
    return found


@dataclass(frozen=True)
class _Render:
    """A tile of the texels of which so large a `number` of paths is wanted, in one of their halves."""

    number: int
    half: int
    tile: Tile

    @property
    def name(self) -> str:
        """The name of its piece."""
        return f"{MORE_LIGHT}-{self.number}-{self.half}-{self.tile.first_row:06d}"


def _renders(plan: CapturePlan, wanted: Ints) -> list[_Render]:
    """All renders of those of a plan's texels of which paths are `wanted` (K,)."""
    found = []
    for number in np.unique(wanted[wanted > 0]).tolist():
        tiles = tiles_of(plan_of_picked(plan, np.flatnonzero(wanted == number)), number // 2)
        found += [_Render(number, half, tile) for half in range(len(_SEEDS)) for tile in tiles]
    return found


def _on_this_side(scratch: bpy.types.Scene, plan: CapturePlan, points: Floats, some: Bools) -> Floats:
    """The points (K, P, 3) of `some` (K,) texels; one that something parts from its texel's own is that one.

    So light from behind a wall that a texel reaches under, or from outdoors, is none of its. Raises BakeError
    where Blender does not render.
    """
    things = read_render(scratch, things_of)
    if things is None:
        return points
    cast: Any = things.tree(np.ones(len(things.corners), dtype=bool)).ray_cast
    own, normals = plan.points.astype(np.float64), plan.normals
    found, corners = large_arrays.copied(points), _corners(points.shape[1])

    def is_parted(texel: int, number: int) -> bool:
        way = points[texel, number] - own[texel]
        length = float(np.linalg.norm(way))
        start = own[texel] + _LIFTED * length * normals[texel]
        return length > 0 and cast(Vector(start), Vector(way / length), length)[0] is not None

    for texel in np.flatnonzero(some).tolist():
        if any(is_parted(texel, number) for number in corners):
            for number in range(points.shape[1]):
                if is_parted(texel, number):
                    found[texel, number] = own[texel]
    return found


def _corners(count: int) -> list[int]:
    """Those of so many PLACES that lie nearest to a texel's corners."""
    places = np.array(PLACES[:count])
    return [int(np.argmax(places @ corner)) for corner in ((1, 1), (1, -1), (-1, 1), (-1, -1))]


def _trace(capture: PortalCapture, tile: Tile) -> Arrays:
    passes = capture.render_passes(tile)
    light, colour = (look(passes, "diffuse").reshape(-1, 3) for look in (light_of, colour_of))
    told = np.where(colour > DARK, light / np.maximum(colour, DARK), np.nan)
    return {"light": told.astype(np.float32)}


def denoise_texels(values: Floats, plan: CapturePlan, shown: Ints, denoiser: Denoiser) -> Floats:
    """Denoise the light (K, 3) of a plan's texels, of which a picture has `shown` (H, W): (K, 3) float32."""
    light, normals = np.maximum(values, 0).astype(np.float32), plan.normals.astype(np.float32)
    whole = np.empty((*shown.shape, 3), dtype=np.float32)
    for inner, outer in _windows(*shown.shape):
        part = shown[outer]
        picture = light[part]
        done = denoiser(picture, np.ones_like(picture), normals[part])
        own = tuple(slice(i.start - o.start, i.stop - o.start) for i, o in zip(inner, outer, strict=True))
        whole[inner] = done[own]
    found: Floats = np.maximum(whole.reshape(-1, 3)[plan.texel], 0)
    return found


def _windows(height: int, width: int) -> Iterator[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """Windows that cover a picture, each without and with a margin."""
    for top in range(0, height, _WINDOW):
        for left in range(0, width, _WINDOW):
            sides = (top, height), (left, width)
            inner = tuple(slice(first, min(first + _WINDOW, size)) for first, size in sides)
            outer = tuple(
                slice(max(first - _MARGIN, 0), min(first + _WINDOW + _MARGIN, size)) for first, size in sides
            )
            yield (inner[0], inner[1]), (outer[0], outer[1])


def texels_shown(plan: CapturePlan) -> Ints:
    """Which of the plan's texels each texel of the atlas shows to a denoiser: (H, W).

    A gutter shows its island mirrored at the rim: the rim's texel over and over would be a streak of one
    noise, which denoisers keep. But beside a seam, across which the surface goes on smoothly, it shows those
    that lie beyond it.
    """
    height, width = plan.layout.height, plan.layout.width
    number = np.full((height, width), -1, dtype=np.int64)
    number.ravel()[plan.texel] = np.arange(len(plan.texel))
    rows, columns = nearest_covered(number >= 0)
    nearest: Ints = number[rows, columns]
    place, normal = plan.points.astype(np.float64), plan.normals
    steps = [_step(number, plan, place, down) for down in (True, False)]
    lengths = np.linalg.norm(steps, axis=2)
    if not lengths.any():
        return nearest
    usual = float(np.median(lengths[lengths > 0]))
    shown = _mirrored(number, rows, columns, place, _ONE_ISLAND * usual)
    j, i = np.nonzero(number < 0)
    away = np.stack([j - rows[j, i], i - columns[j, i]])
    near = (np.abs(away) <= _BEYOND).all(axis=0)
    j, i, away = j[near], i[near], away[:, near]
    own = nearest[j, i]
    beyond = place[own] + sum(
        part[:, None] * np.where(lengths[axis][own, None] <= _ONE_ISLAND * usual, steps[axis][own], 0)
        for axis, part in enumerate(away)
    )
    tree: Any = KDTree(len(place))
    for index, point in enumerate(place):
        tree.insert(point, index)
    tree.balance()
    for row, column, of, point in zip(j.tolist(), i.tolist(), own.tolist(), beyond, strict=True):
        _, met, apart = tree.find(point)
        if apart <= usual and normal[met] @ normal[of] > _SMOOTH:
            shown[row, column] = met
    return shown


def _mirrored(number: Ints, rows: Ints, columns: Ints, place: Floats, apart: float) -> Ints:
    """The numbers (H, W) of texels with islands mirrored at their rims, whose texels are `rows`, `columns`.

    Where the mirrored texel is another island's, or none, the rim's. Neighbours are at most so far `apart`.
    """
    height, width = number.shape
    j, i = np.indices(number.shape)
    away = np.stack([j - rows, i - columns])
    steps = np.abs(away).max(axis=0)
    inwards = np.rint(away * (np.maximum(steps - 1, 0) / np.maximum(steps, 1))).astype(np.int64)
    row, column = np.clip(rows - inwards[0], 0, height - 1), np.clip(columns - inwards[1], 0, width - 1)
    rim, found = number[rows, columns], number[row, column]
    far = np.linalg.norm(place[np.maximum(found, 0)] - place[rim], axis=2)
    kept: Ints = np.where((found >= 0) & (far <= apart * np.maximum(steps, 1)), found, rim)
    return kept


def _step(number: Ints, plan: CapturePlan, place: Floats, down: bool) -> Floats:
    """How far the surface's point moves from each texel to the next one below or right of it, (K, 3).

    The mean of both sides; 0 without a neighbour.
    """
    padded = np.pad(number, 1, constant_values=-1)
    j, i = np.divmod(plan.texel, plan.layout.width)
    moved, sides = np.zeros_like(place), np.zeros((len(place), 1))
    for way in (1, -1):
        other = padded[j + 1 + way * down, i + 1 + way * (not down)]
        there = (other >= 0)[:, None]
        moved += np.where(there, way * (place[np.maximum(other, 0)] - place), 0)
        sides += there
    found: Floats = moved / np.maximum(sides, 1)
    return found
