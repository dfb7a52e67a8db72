# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror rays that the layers of surroundings would show wrongly, and what they meet.

One more render asks where the mirror rays end among all that is not baked. A ray is misled where the layers
show another place, nothing where there is something, or something where there is nothing, unless that has the
same colour. Single paths tell what the pictures do not know of the places where misled rays end, such as the
side of a thing that its eye does not see. Where those that end near each other bring on average what the
layers show a ray that ends there, it is not misled.

Where something without faces is mirrored, such as hair, points or a volume object, no ray counts as misled,
since none tells where that is. Rays that meet the object itself in this render count as shown right: through
a cut-out or a clear part of it they see what no fit knows.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.blocks import in_blocks
from ....bake.light_samples import mirrored
from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Bools, Floats
from ....cycles.path_ends import Body, path_ends
from ....cycles.portal import PortalCapture
from ....cycles.sampling import tiles_of
from ....scene.mesh.mesh_checks import FARTHEST
from ....scene.mesh.render_contents import Placed, Shown, read_render
from ....scene.nodes import open_material
from ....scene.scratch import scene_copied
from ....settings.kinds import Kind
from ..lookup.environment import Around, Shell
from ..lookup.ray_ends import SAME, SHARP, light_of, shown_ends
from .own_rays import dark_world, light_along, own_aim
from .panoramas import NO_SURFACE
from .source_rays import shows_place

_FEW = 1e-3  # share of rays: where fewer end elsewhere than the layers show, none counts
_ALIKE = 0.15  # of the brighter one: colours that differ by less are the same …
_DARK = 0.02  # … and of the mean brightness
_JUDGED = 2e-3  # width², radians², of what colours are compared of
_BODY = 0.25  # what the baked objects emit; places emit 1 or more, the world nothing
_CUBES = 64  # along the longest side of all places that no picture knows, but for …
_FAR = 0.02  # of them at either end: they may be far off
_ENOUGH = 8  # paths that end in a cube, from which on their mean counts
_NEAREST = 1e-2  # of the largest distance of the object's points from their middle, and …
_EXACT = 1e-6  # … of the scene's size: places that are closer to each other are one
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True, eq=False)
class Misled:
    """Which `rays` (K, S) are misled, and where each of these M ends: its `place` (M, 3), in world space.

    It is NaN where that is the world. `light` (M, 3): that of a path along it, NaN where none was traced.
    `shown` (K, S): rays that meet the baked objects where the layers show them, as of a room's walls.
    `asked` (K,): the texels along whose rays paths were traced.
    """

    rays: Bools
    place: Floats
    light: Floats
    shown: Bools
    asked: Bools


def find_misled(
    scratch: bpy.types.Scene,
    unseen: Sequence[Body],
    around: Around,
    hit: Bools,
    plan: CapturePlan,
    most: int,
    seed: int,
    folder: Path,
) -> Misled | None:
    """The misled ones of the rays that `capture_own_rays` takes, of which `hit` (K, S) meet the object.

    None where few end elsewhere than the layers show. The `unseen` are baked, or lie inside what is, and are
    in no picture. At most so many paths a texel as `most` are traced, on average. Raises BakeError where
    Cycles fails.
    """
    originals = frozenset(body.original for body in unseen)
    others, faceless = read_render(scratch, lambda shown: _others(shown, originals))
    if faceless and not any(isinstance(layer.shape, Shell) for layer in around.layers):
        return None
    judge = _Judge(around, plan, own_aim(plan, seed).squares(plan.layout.bucket), hit)
    found = []
    with scene_copied(scratch) as copy:
        for some, ends in _ends(copy, unseen, others, plan, seed, folder):
            found += judge.judged(some, ends)
    rays, place, known, told, shown = (large_arrays.concatenated(parts) for parts in zip(*found, strict=True))
    del found
    if faceless:
        rays, place, known, told = np.zeros_like(rays), place[:0], known[:0], told[:0]
    if rays.mean() < _FEW and not shown.any():
        return None
    light = large_arrays.empty(place.shape)
    light[:] = np.nan
    traced = _traced(rays, ~known, most)
    asked = np.zeros(len(rays), dtype=bool)
    asked[np.nonzero(rays)[0][traced]] = True
    if traced.any():
        with scene_copied(scratch) as copy:
            along = light_along(copy, plan, own_aim(plan, seed), rays, traced, seed, folder)
        light[traced] = along[traced]
        nearby = _mean_nearby(place[~known], light[~known], traced[~known])
        misled = known.copy()
        misled[~known] = ~judge.alike(told[~known].T, nearby.T)
        rays[rays] = misled
        place, light = place[misled], light[misled]
    return Misled(rays, place, light, shown, asked)


def _traced(rays: Bools, unknown: Bools, most: int) -> Bools:
    """Which of the M `rays` (K, S) are traced, (M,): those `unknown` (M,), of texels evenly spread.

    At most so many a texel as `most`, on average of all texels.
    """
    traced = np.zeros(len(unknown), dtype=bool)
    texels, number = np.unique(np.nonzero(rays)[0][unknown], return_inverse=True)
    share = most * len(rays) / max(rays.shape[1] * len(texels), 1)
    traced[unknown] = _spread(len(texels), min(1.0, share))[number]
    return traced


def _mean_nearby(place: Floats, light: Floats, traced: Bools) -> Floats:
    """The mean `light` of the `traced` paths (M,) that end in the same small cube as places (M, 3): (M, 3).

    NaN where there are few.
    """
    low, high = np.quantile(place, (_FAR, 1 - _FAR), axis=0)
    side = max(float((high - low).max()), 1e-9) / _CUBES
    cube = np.clip(np.floor((place - low) / side), -_CUBES, 2 * _CUBES - 1).astype(np.int64) + _CUBES
    _, number = np.unique(cube @ (3 * _CUBES) ** np.arange(3), return_inverse=True)
    count = np.bincount(number, traced)
    total = np.stack([np.bincount(number[traced], part, len(count)) for part in light[traced].T], axis=1)
    mean = total / np.maximum(count, 1)[:, None]
    mean[count < _ENOUGH] = np.nan
    return cast(Floats, mean[number].astype(np.float32))


def _others(shown: Iterator[Shown], unseen: Collection[bpy.types.Object]) -> tuple[list[Placed], bool]:
    """What mirrors may show besides those that are `unseen`, and whether some of that has no faces."""
    found, faceless = [], False
    for one in shown:
        if one.evaluated.type in NO_SURFACE or one.owner in unseen or "glossy" not in one.seen_by:
            continue
        faceless |= one.evaluated.type != "MESH" or _has_hair(one.evaluated)
        shape = one.shape  # None of a mere volume's boundary
        if shape is not None and (np.abs(one.bounds) < FARTHEST).all():
            found.append(Placed(shape, one.matrix, one.seen_by))
    return found, faceless


def _has_hair(item: Any) -> bool:
    return any(
        system.settings.type == "HAIR" and system.settings.render_type == "PATH"
        for system in item.particle_systems
    )


@dataclass(frozen=True, eq=False)
class _Ends:
    """Where rays end: at the baked `body`, at another `thing` (k, S), at a `place` (k, S, 3)."""

    body: Bools
    thing: Bools
    place: Floats
    exact: float

    def of(self, some: slice) -> _Ends:
        """Those of some texels' rays."""
        return _Ends(self.body[some], self.thing[some], self.place[some], self.exact)


def _ends(
    scene: bpy.types.Scene,
    bodies: Sequence[Body],
    others: Sequence[Placed],
    plan: CapturePlan,
    seed: int,
    folder: Path,
) -> Iterator[tuple[slice, _Ends]]:
    """Blocks of the plan's texels, and where their mirror rays end."""
    low, size = _box(others)
    rays = plan.layout.bucket**2
    with path_ends(scene, bodies, others, np.zeros(3, np.float32)) as ends:
        ends.emit(_flat(_BODY), shows_place(low, size, False)[0])
        ends.scene.world = dark_world()
        capture = PortalCapture(ends.scene, plan, Kind.REFLECTION, 1, seed, folder, own_aim(plan, seed))
        for tile in tiles_of(plan):
            coded = capture.render_passes(tile).raw_whole[..., :3].reshape(-1, rays, 3)
            first = tile.first_row * plan.columns
            thing, body = coded.min(axis=-1) > (1 + _BODY) / 2, coded.max(axis=-1) > _BODY / 2
            place = ((coded - 1) * size + low).astype(np.float32)
            yield slice(first, first + len(coded)), _Ends(body & ~thing, thing, place, _EXACT * size)


def _flat(value: float) -> bpy.types.Material:
    """A material that emits the same everywhere."""
    material, build = open_material("RadTex body")
    shader = build.node("ShaderNodeEmission", (value, value, value, 1.0), 1.0)
    build.node("ShaderNodeOutputMaterial", shader.outputs[0])
    cast(Any, material).cycles.emission_sampling = "NONE"
    return material


def _box(others: Sequence[Placed]) -> tuple[Floats, float]:
    """The lowest corner (3,) of a box around all others in world space, and its longest side."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for other in others:
        place = other.shape.position @ other.matrix[:3, :3].T + other.matrix[:3, 3]
        low, high = np.minimum(low, place.min(axis=0)), np.maximum(high, place.max(axis=0))
    if not others:
        return np.zeros(3), 1.0
    return low, max(float((high - low).max()), 1e-9)


_Found = tuple[Bools, Floats, Bools, Floats, Bools]  # see `_Judge._judged`


@dataclass(frozen=True, eq=False)
class _Judge:
    """Finds the misled among the `plan`'s rays, at bucket coordinates `square` (K, S, 2)."""

    around: Around
    plan: CapturePlan
    square: Floats
    hit: Bools

    def judged(self, some: slice, ends: _Ends) -> list[_Found]:
        """What `_judged` finds of some texels, block by block."""

        def judge(part: slice) -> _Found:
            return self._judged(slice(some.start + part.start, some.start + part.stop), ends.of(part))

        return in_blocks(judge, *ends.thing.shape)

    def _judged(self, some: slice, ends: _Ends) -> _Found:
        """Which of some texels' rays are misled (k, S), their places (M, 3), and which of these are known.

        Then what the layers show the misled rays whose places are not known, (M, 3), NaN for the others; and
        which rays meet the object where the layers show it, (k, S).
        """
        hit = self.hit[some]
        asked = ~ends.body & (~hit | ends.thing)
        row, ray = np.nonzero(asked)
        axis = mirrored(self.plan, self.square[some], some)[row, ray]
        offset = (self.plan.points[some] - self.around.middle).astype(np.float32)[row]
        place = np.where(ends.thing[..., None], ends.place - self.around.middle, np.float32(np.nan))[row, ray]
        wrong, known = self._wrong(offset, axis, place.astype(np.float32), ends.exact)
        own = hit[row, ray]
        rays, shown = np.zeros_like(asked), np.zeros_like(asked)
        shown[row, ray] = own & ~wrong
        wrong &= ~own
        rays[row, ray] = wrong
        told = np.full((int(wrong.sum()), 3), np.nan, dtype=np.float32)
        unknown = np.flatnonzero(wrong & ~known)
        sharp = np.full(len(unknown), SHARP, dtype=np.float32)
        told[~known[wrong]] = replace(self.around, lamps=()).look(offset[unknown], axis[unknown], sharp).T
        return rays, (place + self.around.middle)[wrong].astype(np.float32), known[wrong], told, shown

    def _wrong(self, offset: Floats, axis: Floats, place: Floats, exact: float) -> tuple[Bools, Bools]:
        """Which of N rays are misled, and of which the pictures know where they end, (N,) both."""
        shown = shown_ends(self.around, offset, axis)
        there, said = np.isfinite(place[:, 0]), np.isfinite(shown[:, 0])
        least = exact + _NEAREST * float(np.abs(self.plan.points - self.around.middle).max())
        apart = np.linalg.norm(place - shown, axis=1)
        off = apart > np.maximum(SAME * np.linalg.norm(place - offset, axis=1), least)
        wrong: Bools = np.where(there & said, off, there != said)
        variance = np.full(int(wrong.sum()), _JUDGED, dtype=np.float32)
        told = replace(self.around, lamps=()).look(offset[wrong], axis[wrong], variance)
        true, sure = light_of(self.around, offset[wrong], axis[wrong], place[wrong], variance)
        known = np.zeros(len(wrong), dtype=bool)
        known[wrong] = sure
        wrong[wrong] = ~(sure & self.alike(told, true))
        return wrong, known

    def alike(self, told: Floats, true: Floats) -> Bools:
        """Which colours (3, N) are the same."""
        brighter = np.maximum(told, true).max(axis=0)
        alike: Bools = np.abs(told - true).max(axis=0) <= _ALIKE * brighter + _DARK * self._usual
        return alike

    @cached_property
    def _usual(self) -> float:
        """The mean brightness all around the middle."""
        pictures = [self.around.world, *(layer.pictures for layer in self.around.layers)]
        return float(sum(picture.levels[-1][..., :3].mean() for picture in pictures))


def _spread(count: int, share: float) -> Bools:
    """A share of so many, evenly spread: (count,)."""
    chosen: Bools = (np.arange(count) * _GOLDEN) % 1 < share
    return chosen
