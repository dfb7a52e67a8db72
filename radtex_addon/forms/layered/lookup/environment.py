# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surroundings in layers: pictures from the object's middle, and where rays from elsewhere meet them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import cast

import numpy as np

from ....core.arrays import Floats, Ints
from ....core.colour_spaces import LUMINANCE
from ....core.gutter import dilate, nearest_covered
from ....core.octahedron import cell_directions, direction_to_octahedron, octahedron_cell
from ..cells import DISTANCES
from .blurred_levels import LevelMaps, blurred_levels, level_count, level_sizes, sharpest_variance
from .lamp_shapes import LampShape
from .lobes import Brushed, lobe

MOST_LAMPS = 8  # that shaders mirror
STEPS = 2  # by which a ray finds what it meets in such a map
_LEAST_RATIO, _MOST_RATIO = 1 / 16, 4.0  # of distances from the fragment and from the middle
_NARROWER = (-12.0, 2.5, 0.5)  # exponents of 2: by how much the Gaussians that make a lobe are narrower
_PARALLEL, _STEEPEST = 1e-4, 0.999  # sines of angles to a plane: along it, and straight at it
MOST_PLANES = 8  # of a shell
MOST_BOXES = 8  # around what stands in one
NEAR_LOBE = 4.0  # times a lobe's variance: the squared sine up to which it sees what its axis passes
SMALLEST = 1e-7  # part of a unit vector
BEYOND = 0.12  # of a thing's distance: what is further than its box by that is not met in it
SHADED = 0.1  # of a sun's light: what else a place in its shadow may have
LEAST_FACING = 0.1  # cosine between a normal and the way to a lamp
KNOWN = 50.0  # one over the diffuse colour from which on irradiance is known
BRIGHTER = 1e6  # than any sun
FARTHEST = 1e6  # how far away a ray meets a shell that it leaves
_LEAST_SHAPE = 2e-5  # width² of a lamp whose shape nothing sees: a disc of one degree
_LEAST_RADIUS = 1e-3  # radians
SOLID = 0.98  # of a thing's distance: what is further away is not before it

_Bounds = tuple[Floats, Floats, Floats]  # where rays enter and leave a box, and meet the shell: (N,) each


@dataclass(frozen=True, eq=False)
class Pictures:
    """A picture over the octahedron of directions and its blurred copies: `levels` (M, M, C), float32.

    Level l is blurred by a lobe (see lobes.py) of a width² of `sharpest` 4^l; the first is sharp.
    """

    levels: tuple[Floats, ...]
    sharpest: float

    @classmethod
    def of(cls, direction: Floats, values: Floats, size: int) -> Pictures:
        """The means of `values` (P, 3) or (P, 4), seen in unit directions (P, 3), in size x size cells."""
        direction = direction.reshape(-1, 3).astype(np.float32)
        values = values.reshape(len(direction), -1).astype(np.float32)
        if len(values) and (values == values[0]).all():  # a world of one colour: blurred it is the same
            sides = level_sizes(size, level_count(size))
            levels = tuple(np.tile(values[0], (side, side, 1)) for side in sides)
            return cls(levels, sharpest_variance(size))
        levels, sharpest = blurred_levels(direction, values, size)
        gaussian = cls(levels, sharpest)
        return cls((levels[0], *(gaussian._tailed(number) for number in range(1, len(levels)))), sharpest)

    def _tailed(self, number: int) -> Floats:
        """A level blurred by a lobe with tails, of levels blurred by Gaussians."""
        size = len(self.levels[number])
        direction = cell_directions(size).astype(np.float32)
        narrower = 2.0 ** np.arange(*_NARROWER)
        share = narrower * np.exp(-narrower)
        total = np.zeros((self.levels[0].shape[2], size * size), dtype=np.float32)
        for times, part in zip(narrower, share / share.sum(), strict=True):
            wide = np.full(size * size, self.sharpest * 4**number / times, dtype=np.float32)
            total += np.float32(part) * self.look(direction, wide)
        return np.ascontiguousarray(total.T.reshape(size, size, -1))

    def look(self, direction: Floats, variance: Floats) -> Floats:
        """The picture around directions (N, 3), blurred by variances (N,): (C, N) float32."""
        place, level = direction_to_octahedron(direction).T, self.level(variance)
        lower, above = self.between(level)
        last = len(self.levels) - 1
        found = self._maps.look(place, lower) * (1 - above)
        return cast(Floats, found + self._maps.look(place, np.minimum(lower + 1, last)) * above)

    def sharp(self, direction: Floats) -> Floats:
        """The picture in directions (N, 3), as sharp as it is: (C, N) float32."""
        return self._maps.look(direction_to_octahedron(direction).T, 0)

    def level(self, variance: Floats) -> Floats:
        """Which level is as blurred as these widths² (N,), float32, with fractions of its logarithm."""
        level = np.log2(np.maximum(variance, 1e-12) / self.sharpest) / 2
        return cast(Floats, np.clip(level, 0, len(self.levels) - 1).astype(np.float32))

    def between(self, level: Floats) -> tuple[Ints, Floats]:
        """The level below, and the share of the next: by widths, so that a lobe's tails are nearly right."""
        lower = np.minimum(level.astype(np.intp), max(len(self.levels) - 2, 0))
        return lower, (2.0 ** (level - lower) - 1).astype(np.float32)

    @cached_property
    def _maps(self) -> LevelMaps:
        return LevelMaps.of(self.levels)


@dataclass(frozen=True, eq=False)
class Plane:
    """Points p, from the object's middle, of `normal` . p = `height`; the object is on the normal's side.

    `eye` (3,), from the middle: where the plane is seen from in its picture, which above the horizon has what
    lies below it once more, mirrored, so that blurring it mixes in nothing else.
    """

    normal: Floats
    height: float
    eye: Floats = field(default_factory=lambda: np.zeros(3, dtype=np.float32))

    def meet(self, offset: Floats, axis: Floats, variance: Floats) -> tuple[Floats, Floats, Floats]:
        """Where lobes of variances (N,) about unit axes (N, 3), from offsets (N, 3), meet it.

        Directions from the eye (N, 3); what the lobes' variances are multiplied by, as seen from there (N,);
        and the shares of the lobes that point below the horizon (N,). The direction is the mean one of that
        share: of a profile like (2 + x²)^-3/2 across the horizon, its sine is -sqrt(sine² + 2 variance).
        """
        axis, offset, normal = axis.T, offset.T, self.normal[:, None]
        sine = self.normal @ axis
        root = np.sqrt(sine * sine + 2 * variance)
        deep = np.clip(root, _PARALLEL, _STEEPEST)
        level = axis - sine * normal
        level /= np.maximum(np.linalg.norm(level, axis=0), 1e-6)
        down = np.sqrt(1 - deep * deep) * level - deep * normal
        far = np.maximum(self.normal @ offset - self.height, 0) / deep
        met = offset + far * down - self.eye[:, None]
        distance = np.maximum(np.linalg.norm(met, axis=0), 1e-6)
        along = far / distance  # and across, as the eye sees the plane at another slant:
        slant = (float(self.eye @ self.normal) - self.height) / distance / deep
        wider = np.clip(along * along * slant, _LEAST_RATIO**2, _MOST_RATIO**2)
        return (met / distance).T, wider, (0.5 - 0.5 * sine / root).astype(np.float32)

    def seen_at(self, direction: Floats) -> Floats:
        """The places (N, 3), from the middle, that its picture shows in unit directions (N, 3).

        Directions above the horizon count as lying just below it.
        """
        deep = np.maximum(-(direction @ self.normal), _PARALLEL)
        far = (float(self.eye @ self.normal) - self.height) / deep
        return cast(Floats, self.eye + far[:, None] * direction)


@dataclass(frozen=True, eq=False)
class Shell:
    """The large flat things around, such as a room's floor, walls and ceiling, met from inside.

    Inside are the points p, from the middle, with `normals` (n, 3) . p > `heights` (n,), of at most
    MOST_PLANES planes. `eye` (3,), from the middle and inside: where its picture is seen from. It corrects
    parallax as games do with boxes: Lagarde and Zanuttini, "Local Image-based Lighting with
    Parallax-corrected Cubemaps" (2012).
    """

    normals: Floats
    heights: Floats
    eye: Floats

    def meet(self, offset: Floats, axis: Floats, variance: Floats) -> tuple[Floats, Floats, Floats]:
        """As `Plane.meet`: the nearest of the planes that the axes point at; they take all of each lobe.

        Where there is none, it is met FARTHEST away. Offsets behind a plane count as lying in it.
        """
        axis, offset = axis.T, offset.T
        far, nearest = self.far(offset, axis)
        met = offset + far * axis - self.eye[:, None]
        distance = np.maximum(np.linalg.norm(met, axis=0), 1e-6)
        met = met / distance
        normal = np.where(far < FARTHEST, self.normals.T[:, nearest], axis)
        deep, seen = (np.abs((normal * way).sum(axis=0)) for way in (axis, met))
        slant = seen / np.maximum(deep, _PARALLEL)  # as in `Plane.meet`
        wider = np.clip((far / distance) ** 2 * slant, _LEAST_RATIO**2, _MOST_RATIO**2)
        return met.T, wider, np.ones_like(variance)

    def seen_at(self, direction: Floats) -> Floats:
        """As `Plane.seen_at`."""
        far, _ = self.far(np.broadcast_to(self.eye[:, None], direction.T.shape), direction.T)
        return cast(Floats, self.eye + far[:, None] * direction)

    def far(self, offset: Floats, axis: Floats) -> tuple[Floats, Ints]:
        """How far along unit axes (3, N) from offsets (3, N) the shell is met, and in which plane, (N,)."""
        sine = self.normals @ axis
        above = np.maximum(self.normals @ offset - self.heights[:, None], 0)
        far = np.where(sine < -_PARALLEL, above / np.maximum(-sine, _PARALLEL), np.float32(FARTHEST))
        nearest = far.argmin(axis=0)
        return np.minimum(far.min(axis=0), np.float32(FARTHEST)), nearest


@dataclass(frozen=True, eq=False)
class Impostor:
    """One over the distance from its `eye` of what lies in each direction: `nearness` (D, D).

    The eye (3,) is given from the middle.
    Szirmay-Kalos et al., "Approximate Ray-Tracing on the GPU with Distance Impostors" (2005).
    In a room, things lie in `boxes` (n, 2, 3), their lowest and highest corners from the middle, at most
    MOST_BOXES: a ray begins where it comes to the nearest box. One that comes to none passes between them to
    the `shell`. A thing is solid behind what the eye sees of it: see `_behind`.
    """

    nearness: Floats
    eye: Floats = field(default_factory=lambda: np.zeros(3, dtype=np.float32))
    boxes: Floats = field(default_factory=lambda: np.zeros((0, 2, 3), dtype=np.float32))
    shell: Shell | None = None

    @classmethod
    def of(cls, direction: Floats, distance: Floats, eye: Floats | None = None) -> Impostor:
        """Of things at distances (P,) in unit directions (P, 3), of which there are some."""
        cell = octahedron_cell(direction_to_octahedron(direction.astype(np.float32)), DISTANCES)
        count = np.bincount(cell, minlength=DISTANCES**2)
        mean = np.bincount(cell, 1 / distance, minlength=DISTANCES**2) / np.maximum(count, 1)
        image = mean.astype(np.float32).reshape(DISTANCES, DISTANCES)
        filled = dilate(image, nearest_covered((count > 0).reshape(image.shape)))
        return cls(filled) if eye is None else cls(filled, eye)

    def meet(self, offset: Floats, axis: Floats, variance: Floats) -> tuple[Floats, Floats, Floats]:
        """As `Plane.meet`: the sphere is cut that is as large as what lies in the direction found last."""
        axis, offset = axis.T, offset.T
        begin, bounds = self._begin(offset, axis)
        offset = offset - self.eye[:, None]
        along = (offset * axis).sum(axis=0)
        squared = (offset * offset).sum(axis=0)
        met, cover = begin, np.ones_like(variance)
        far: Floats = np.ones_like(along)
        length = distance = far
        for _ in range(STEPS):
            distance = self._distance(met)
            far = np.sqrt(np.maximum(along * along - squared + distance * distance, 0)) - along
            if bounds is not None:
                enter, leave, wall = bounds
                far = np.where(far > leave + BEYOND * distance, wall, np.clip(far, enter, leave))
            met, length = _towards(offset + far * axis)
        if bounds is not None:
            far = self._behind(offset, axis, far, bounds)
            met, length = _towards(offset + far * axis)
            past = far >= bounds[2]
            cover[past] = _near_lobe(distance * met - offset, axis, variance)[past]
        ratio = np.clip(far / length, _LEAST_RATIO, _MOST_RATIO)
        return met.T, cast(Floats, ratio * ratio), cover.astype(np.float32)

    def _behind(self, offset: Floats, axis: Floats, far: Floats, bounds: _Bounds) -> Floats:
        """How far along rays are met, (N,), that pass behind the side of a thing that the eye sees.

        Of rays from offsets (3, N) from the eye along axes (3, N), which were found to be met `far` along.
        One that meets nothing between where it enters and leaves its box has met no side that is seen. Where
        the middle of its way through the box lies behind such a side, by no more than that way, it is met
        there.
        """
        enter, leave, _ = bounds
        at_bound = np.flatnonzero(((far <= enter) | (far >= leave)) & (enter < leave))
        way = (leave - enter)[at_bound]
        middle = enter[at_bound] + way / 2
        met, length = _towards(offset[:, at_bound] + middle * axis[:, at_bound])
        distance = self._distance(met)
        inside = (length >= SOLID * distance) & (length - distance <= way)
        far[at_bound[inside]] = middle[inside]
        return far

    def _distance(self, direction: Floats) -> Floats:
        """How far from the eye things lie in directions (3, N): (N,)."""
        near = self._maps.look(direction_to_octahedron(direction.T).T, 0)[0]
        return cast(Floats, 1 / np.maximum(near, 1e-9))

    def _begin(self, offset: Floats, axis: Floats) -> tuple[Floats, _Bounds | None]:
        """Where rays from offsets (3, N) along axes (3, N) begin, as unit directions from the eye (3, N).

        And where they enter and leave the nearest box, and meet the shell: what lies further than the box is
        not met there. One that comes to no box enters and leaves at the shell; from within a box it begins
        where it leaves it.
        """
        if self.shell is None:
            return axis, None
        wall, _ = self.shell.far(offset, axis)
        begin, enter, leave = wall.copy(), wall.copy(), wall.copy()
        turned = np.where(np.abs(axis) < SMALLEST, SMALLEST, axis)
        for low, high in self.boxes:
            one, other = (low[:, None] - offset) / turned, (high[:, None] - offset) / turned
            first, last = np.minimum(one, other).max(axis=0), np.maximum(one, other).min(axis=0)
            start = np.where(first > 0, first, last)
            nearer = (first <= last) & (last > 0) & (start < begin)
            begin = np.where(nearer, start, begin)
            enter, leave = np.where(nearer, np.maximum(first, 0), enter), np.where(nearer, last, leave)
        return _towards(offset + begin * axis - self.eye[:, None])[0], (enter, leave, wall)

    def seen_at(self, direction: Floats) -> Floats:
        """As `Plane.seen_at`."""
        return cast(Floats, self.eye + direction * self._distance(direction.T)[:, None])

    @cached_property
    def _maps(self) -> LevelMaps:
        return LevelMaps.of([self.nearness[..., None]])


def _towards(place: Floats) -> tuple[Floats, Floats]:
    """The unit directions (3, N) to places (3, N), and how far these are: (N,)."""
    length = np.maximum(np.linalg.norm(place, axis=0), 1e-6)
    return place / length, length


def _near_lobe(away: Floats, axis: Floats, variance: Floats) -> Floats:
    """How much lobes about axes (3, N), of variances (N,), see of what lies `away` (3, N) from their origins.

    All of it up to twice their width, nothing from 2.8 times that on.
    """
    along = np.maximum((away * axis).sum(axis=0), 0)
    sine = 1 - along * along / np.maximum((away * away).sum(axis=0), 1e-12)
    found: Floats = np.clip(2 - sine / (NEAR_LOBE * np.maximum(variance, 1e-6)), 0, 1)
    return found


@dataclass(frozen=True, eq=False)
class SurroundingLayer:
    """Things near the object, over nothing: `pictures` of premultiplied radiance and alpha, and a `shape`."""

    pictures: Pictures
    shape: Plane | Shell | Impostor

    def seen(self, offset: Floats, axis: Floats, variance: Floats) -> Floats:
        """What is seen of it, blurred, from offsets (N, 3) along axes (N, 3): (4, N), premultiplied."""
        met, wider, cover = self.shape.meet(offset, axis, variance)
        return cover * self.pictures.look(met.astype(np.float32), (variance * wider).astype(np.float32))


@dataclass(frozen=True, eq=False)
class Lit:
    """How much light falls on places, which tells how much of a sun they see at most.

    `normal` (N, 3), the mesh's; `light` (N,): luminance of their irradiance, or more than any sun's.
    """

    normal: Floats
    light: Floats

    @classmethod
    def of(cls, normal: Floats, irradiance: Floats, colour: Floats) -> Lit:
        """Of an irradiance over pi (N, 3), which is known unless the diffuse `colour` (N, 3) is dark."""
        unknown = np.maximum(1 - KNOWN * colour.max(axis=1), 0)
        return cls(normal, np.pi * (irradiance @ LUMINANCE) + BRIGHTER * unknown)

    def some(self, rows: Ints | slice) -> Lit:
        """Of some of the places."""
        return Lit(self.normal[rows], self.light[rows])

    def most(self, lamp: Lamp, offset: Floats) -> Floats:
        """How much of a lamp is seen at most from the places, at offsets (N, 3) from the middle: (N,)."""
        towards = lamp.place - offset
        squared = (towards * towards).sum(axis=1)
        facing = (self.normal * towards).sum(axis=1) / np.sqrt(squared)
        sent = float(LUMINANCE @ lamp.irradiance) * float(lamp.place @ lamp.place) / squared
        share = self.light / np.maximum(sent * np.maximum(facing, LEAST_FACING), 1e-9)
        found: Floats = np.clip((share - SHADED) / (1 - SHADED), 0, 1).astype(np.float32)
        return found


@dataclass(frozen=True, eq=False)
class Lamp:
    """A lamp that is seen: its `place` (3,) from the middle, `irradiance` (3,) there, `variance` of its size.

    The irradiance is that of a surface at the middle that faces it, the variance in radians² along each axis.
    `behind`: the layers are before it, as walls and windows are before a sun. Without a `shape` it is a blur.
    """

    place: Floats
    irradiance: Floats
    variance: float
    behind: bool = False
    shape: LampShape | None = None

    def light(self, offset: Floats, axis: Floats, variance: Floats, brushed: Brushed | None = None) -> Floats:
        """What rays see of it, blurred by variances (N,), or by lobes of brushed metal: (3, N)."""
        towards = (self.place[:, None] - offset.T).astype(np.float32)
        distance = np.linalg.norm(towards, axis=0)
        squared = 2 * (1 - (axis.T * towards).sum(axis=0) / distance)
        nearer = float((self.place**2).sum()) / distance**2
        size = self.variance * nearer
        if brushed is None:
            shown = nearer * lobe(squared, variance + size)
        else:
            shown = nearer * brushed.towards(towards / distance, size)
        if self.shape is not None:
            shown *= self.shape.facing(towards, self.place)
        if self.shape is not None and brushed is None:
            sharp = self.shape.share(variance, size)
            some = np.flatnonzero(sharp)
            covered = self.shape.covered(towards[:, some], axis.T[:, some], variance[some])
            shown[some] += sharp[some] * (covered / self.shape.solid - shown[some])
        return cast(Floats, self.irradiance[:, None].astype(np.float32) * shown.astype(np.float32))


@dataclass(frozen=True, eq=False)
class Around:
    """All around the object, from its `middle` (3,): the world, `layers` from far to near, lamps."""

    middle: Floats
    world: Pictures
    layers: tuple[SurroundingLayer, ...]
    lamps: tuple[Lamp, ...]

    def look(
        self,
        offset: Floats,
        axis: Floats,
        variance: Floats,
        lit: Lit | None = None,
        brushed: Brushed | None = None,
    ) -> Floats:
        """What rays from offsets (N, 3) from the middle see along unit axes (N, 3): (3, N) float32.

        Blurred by variances (N,), radians² along each of two axes. Components had better lie apart in memory.
        `lit` bounds what places see of lamps that layers are before; `brushed`: how they spread lamps' light.
        """
        axis, offset = axis.astype(np.float32), offset.astype(np.float32)
        light = self.world.look(axis, variance)
        for layer in self.layers:
            seen = layer.seen(offset, axis, variance)
            light = light * (1 - seen[3]) + seen[:3]
        for lamp in self.lamps:
            shown = lamp.light(offset, axis, variance, brushed)
            light = light + (shown * self._open(offset, lamp, lit) if lamp.behind else shown)
        return light.astype(np.float32)

    def _open(self, offset: Floats, lamp: Lamp, lit: Lit | None) -> Floats:
        """How much of a lamp behind the layers is seen between them from offsets (N, 3): (N,).

        No more than `lit` says: in a sun's shadow it is not seen, whatever the layers' pictures show.
        """
        towards = (lamp.place - offset).astype(np.float32)
        distance = np.linalg.norm(towards, axis=1)
        axis, wide = towards / distance[:, None], lamp.variance * (lamp.place @ lamp.place) / distance**2
        free = np.ones(len(offset), dtype=np.float32)
        for layer in self.layers:
            free *= 1 - layer.seen(offset, axis, wide.astype(np.float32))[3]
        return free if lit is None else free * lit.most(lamp, offset)


def lamps_of(
    direction: Floats,
    radiance: Floats,
    places: Sequence[Floats],
    shares: Sequence[float] | None = None,
    behind: Sequence[bool] | None = None,
    shapes: Sequence[LampShape | None] | None = None,
    radii: Sequence[float] | None = None,
) -> tuple[Lamp, ...]:
    """Lamps from a picture of them alone, in size x size cells of the octahedron.

    `direction` (P, 3) and `radiance` (P, 3) are the cells'; `places` (3,) the lamps', from the middle. A lamp
    that covers no cell's centre is left out. `shares`: the lamps' width² over that of what the picture
    shows; `behind` as in `Lamp`; `shapes`, whose `solid` is in units of what the picture shows of each.
    `radii`: how large the picture shows them, in radians, so that a cell is of the lamp that it lies in.
    """
    lit = radiance.sum(axis=1) > 0
    solid = 4 * np.abs(direction[lit]).sum(axis=1) ** 3 / len(direction)  # of a cell, on the sphere
    towards = np.stack([place / np.linalg.norm(place) for place in places])
    angle = np.arccos(np.clip(direction[lit] @ towards.T, -1, 1))
    nearest = np.argmin(angle if radii is None else angle / np.maximum(radii, _LEAST_RADIUS), axis=1)
    found = []
    for number, place in enumerate(places):
        own = nearest == number
        if not own.any():
            continue
        sent, seen = radiance[lit][own] * solid[own, None], direction[lit][own]
        weight = sent.sum(axis=1)
        centre = (seen * weight[:, None]).sum(axis=0)
        centre /= np.linalg.norm(centre)
        squared = 2 * np.maximum(1 - seen @ centre, 0)
        variance = float((squared * weight).sum() / weight.sum() / 2)
        variance *= 1.0 if shares is None else shares[number]
        at = centre * np.linalg.norm(place)
        outside = behind is not None and behind[number]
        shape = None if shapes is None or variance < _LEAST_SHAPE else shapes[number]
        if shape is not None:
            at, shape = place, replace(shape, solid=float(shape.solid * solid[own].sum()))
        found.append(Lamp(at.astype(np.float32), sent.sum(axis=0), max(variance, 1e-7), outside, shape))
    return tuple(found)
