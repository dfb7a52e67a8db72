# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through a clear object, followed by the distances to its surface: refracted, or reflected within.

The object is a field of signed distances (sphere tracing: Hart, 1996), each with the normal of the nearest
place of its surface. At each surface a ray goes on as most of its light does; the brightest of the shares
that part from it is followed as a second ray. What goes neither way may be taken to come from all around.

Rough glass makes beams of rays, as wide as the small slopes of all surfaces make them: ray differentials
(Igehy, "Tracing Ray Differentials", 1999), whose squares are averaged over both planes, and over slopes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np

from ....core.arrays import Bools, Floats, Ints

WAYS = 2
STEPS = 64  # of each ray, through all that it crosses
MET = 0.1  # steps of the field: a surface that is nearer, and comes nearer, is met
LEAST = 0.5  # … by which a ray goes on at least
PUSH = 1.5  # … by which a ray that was turned leaves the surface
EDGE = 0.9  # squared length of mixed unit normals: of less, an edge, that of the nearest sample counts
TOWARDS = 0.05  # cosine between a ray and the normal of a surface that it meets, at least
STEEP = 0.2  # cosine: what a distance is divided by, at least, to know where along the ray the surface is
FAN = 0.2  # cosine that tells how a surface fans a beam out, at least
BESIDE = 1.0  # steps along a surface in which its normal tells how round it is
ROUNDEST = 0.25  # by how much a normal turns a step along the surface, at most: what turns more is an edge
WIDEST = 4.0  # of a beam, radians²
TAILS = 1.4  # what beams' width² is multiplied by, as lobes with tails add up to more
FARTHEST = 64  # steps, by which beams are narrowest before where they leave
ALL_AROUND = 0.5  # width² of what is seen on ways that are not followed
GRAZING = 1e-3  # cosine, at least
FAINT = 0.004  # share of the light that a way has, at least


@dataclass(frozen=True, eq=False)
class FieldFacts:
    """Where a distance field lies, and of what glass it is.

    `size`: samples along x, y and z. `low` (3,): the first sample, from the middle of the surroundings;
    `step`: between samples, in scene units; `ior`: the index of refraction; `slopes`: the variance of the
    surface's small slopes along each axis, radians². A ray is lost after so many `reflections`. Of the light
    that goes on ways which are not followed, a share comes from `all_around`. `tint` (3,), linear: what light
    is multiplied by at each surface that refracts it and, if it `tints_reflections`, that reflects it within.
    """

    size: tuple[int, int, int]
    low: Floats
    step: float
    ior: float
    slopes: float
    reflections: int
    all_around: float = 0.0
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    tints_reflections: bool = False


def columns_of(size: tuple[int, int, int]) -> int:
    """How many of a field's layers lie in a row of its image."""
    width, height, depth = size
    return min(depth, max(1, round(math.sqrt(depth * height / width))))


def image_size(size: tuple[int, int, int]) -> tuple[int, int]:
    """Width and height of a field's image: its layers of equal z, row by row."""
    width, height, depth = size
    columns = columns_of(size)
    return columns * width, -(-depth // columns) * height


@dataclass(frozen=True, eq=False)
class DistanceField:
    """The surface of a clear object in a grid of samples.

    `values` (d, h, w, 4) float32, by z, y and x in world space: the unit normal of the nearest place, as it
    is shaded, and the distance to it in steps, below 0 inside.
    """

    values: Floats
    facts: FieldFacts

    def at(self, place: Floats) -> Floats:
        """The values at places (N, 3) in the grid, in steps from its first sample: (N, 4) float32."""
        width, height, _ = self.facts.size
        low = np.minimum(place.astype(np.int32), np.array(self.facts.size, dtype=np.int32) - 2)
        x, y, z = (place - low).T.astype(np.float32)
        flat = self.values.reshape(-1, 4)
        first = (low[:, 2] * height + low[:, 1]) * width + low[:, 0]
        found = np.zeros((len(place), 4), dtype=np.float32)
        for up, above in enumerate((1 - z, z)):
            for across, beside in enumerate((1 - y, y)):
                corner = first + (up * height + across) * width
                share = above * beside
                found += (share * (1 - x))[:, None] * flat[corner] + (share * x)[:, None] * flat[corner + 1]
        return found

    def normal_at(self, place: Floats, mixed: Floats) -> Floats:
        """Unit normals (N, 3) at places (N, 3) on the surface, of which `mixed` (N, 3) are those around."""
        normal, edge = mixed.copy(), np.flatnonzero((mixed**2).sum(axis=1) < EDGE)
        x, y, z = np.floor(place[edge] + np.float32(0.5)).astype(np.intp).T
        normal[edge] = self.values[z, y, x, :3]
        return _unit(normal)


@dataclass(frozen=True, eq=False)
class Ways:
    """Where rays leave a clear object.

    Their `weight` (N,), 0 where they do not; `place` (N, 3), from the middle, and unit `direction` (N, 3), in
    world space; `variance` (N,), their lobes' width², about that place: of rough glass, where beams are
    narrowest; `tints` (N,): how many surfaces tinted them beyond the two by
    which light comes in and goes out.
    """

    weight: Floats
    place: Floats
    direction: Floats
    variance: Floats
    tints: Ints


@dataclass(eq=False)
class _Rays:
    """Rays on their way: as `Ways`, but their `place` is where they are, in steps of the field.

    Those of a beam differ in direction by `variance`, radians², and in place across the ray by `spread`,
    steps², which go together by `fan`, radians x steps, (N,) each. Whether rays are `inside`, (N,), how
    many `reflections` (N,) they had, and how many `tints` (N,).
    """

    weight: Floats
    place: Floats
    direction: Floats
    variance: Floats
    fan: Floats
    spread: Floats
    inside: Bools
    reflections: Ints
    tints: Ints

    def put(self, some: Ints, other: _Rays) -> None:
        """Replace `some` of them."""
        for name, values in vars(other).items():
            vars(self)[name][some] = values

    def advance(self, some: Ints | slice, far: Floats | np.float32) -> None:
        """Take `some` of them on by so many steps."""
        self.place[some] += np.reshape(far, (-1, 1)) * self.direction[some]
        self.spread[some] += far * (2 * self.fan[some] + far * self.variance[some])
        self.fan[some] += far * self.variance[some]

    def some(self, chosen: Ints | Bools) -> _Rays:
        """Copies of some of them."""
        return _Rays(*(values[chosen] for values in vars(self).values()))


def follow(field: DistanceField, offset: Floats, normal: Floats, viewer: Floats) -> list[Ways]:
    """The ways on which light comes through the field's object to viewers: its WAYS, the brightest first.

    And that which stands for all others: the viewer's own, with a lobe that is ALL_AROUND.

    `offset` (N, 3): where they look at its surface, from the middle; unit `normal` and `viewer` (N, 3), both
    on the same side of it. All in world space.
    """
    facts, count = field.facts, len(offset)
    cosine = np.maximum((viewer * normal).sum(axis=1), np.float32(GRAZING))
    index = np.full(count, facts.ior, dtype=np.float32)
    mirrored, beyond = _fresnel(cosine, index)
    direction = _unit(-viewer / facts.ior + (cosine / facts.ior - beyond)[:, None] * normal)
    none = np.zeros(count, dtype=np.float32)
    rays = _Rays(
        weight=1 - mirrored,
        place=((offset - facts.low) / facts.step).astype(np.float32),
        direction=direction.astype(np.float32),
        variance=none.copy(),
        fan=none.copy(),
        spread=none.copy(),
        inside=np.ones(count, dtype=bool),
        reflections=np.zeros(count, dtype=np.int32),
        tints=np.full(count, -1, dtype=np.int32),
    )
    if facts.slopes:
        _fan_out(facts, rays, _refracting(cosine, beyond, index), none)
    rays.advance(slice(None), np.float32(PUSH))
    lost, found = 1 - mirrored, []
    for _ in range(WAYS):
        parted = rays.some(np.arange(count))
        parted.weight[:] = 0
        with np.errstate(invalid="ignore", over="ignore"):  # a damaged file may hold any values
            _march(field, rays, parted)
            way = _left(facts, rays)
        numbers = np.column_stack([way.place, way.direction, way.variance])
        way.weight[~np.isfinite(numbers).all(axis=1)] = 0
        found.append(way)
        lost = lost - rays.weight
        rays = parted
    lost = np.maximum(lost * np.float32(facts.all_around) - np.float32(FAINT), 0)
    width = np.full(count, ALL_AROUND, dtype=np.float32)
    return [*found, Ways(lost, offset, -viewer, width, np.zeros(count, dtype=np.int32))]


def reflected(cosine: Floats, ior: float) -> Floats:
    """The share (N,) that smooth glass reflects of what comes to it at such a `cosine` (N,), from outside."""
    cosine = np.maximum(cosine, np.float32(GRAZING))
    return _fresnel(cosine, np.full(len(cosine), ior, dtype=np.float32))[0]


def _left(facts: FieldFacts, rays: _Rays) -> Ways:
    """The ways of rays that have left the object."""
    back = np.clip(rays.fan / np.maximum(rays.variance, np.float32(1e-12)), 0, FARTHEST)
    place = facts.low + (rays.place - back[:, None] * rays.direction) * np.float32(facts.step)
    variance = rays.variance * np.float32(TAILS)
    return Ways(rays.weight, place.astype(np.float32), rays.direction, variance, rays.tints)


def _march(field: DistanceField, rays: _Rays, parted: _Rays) -> None:
    """Take rays on until they leave, and keep the brightest that parts from each in `parted`."""
    last = np.array(field.facts.size, dtype=np.float32) - 1
    going = np.flatnonzero(rays.weight > FAINT)
    rays.weight[rays.weight <= FAINT] = 0
    for _ in range(STEPS):
        here = rays.place[going]
        left = ~((here >= 0) & (here <= last)).all(axis=1)  # or it is no number
        going, here = going[~left], here[~left]
        if not len(going):
            return
        found = field.at(here)
        side = np.where(rays.inside[going], np.float32(1), np.float32(-1))
        free = -found[:, 3] * side
        near = np.flatnonzero(free < MET)
        ahead = _unit(found[:, :3])
        ahead[near] = field.normal_at(here[near], found[near, :3])
        ahead *= side[:, None]
        towards = (rays.direction[going] * ahead).sum(axis=1)
        met = (free < MET) & (towards > TOWARDS)
        far = np.where(
            met, free / np.maximum(towards, np.float32(STEEP)), np.maximum(free, np.float32(LEAST))
        )
        rays.advance(going, far)
        some = going[met]
        if len(some):
            brighter, other = _split(field, rays.some(some), ahead[met], towards[met])
            first = other.weight > parted.weight[some]
            parted.put(some[first], other.some(first))
            rays.put(some, brighter)
            rays.weight[some[brighter.weight <= FAINT]] = 0
            going = going[rays.weight[going] > 0]
    rays.weight[going[rays.inside[going]]] = 0


def _split(field: DistanceField, rays: _Rays, ahead: Floats, towards: Floats) -> tuple[_Rays, _Rays]:
    """Rays that have met the surface, parted into those that have more of the light, and the others.

    `ahead` (N, 3): its unit normal on the far side; `towards` (N,): the cosine between both.
    """
    facts = field.facts
    index = np.where(rays.inside, np.float32(1 / facts.ior), np.float32(facts.ior))
    reflected, beyond = _fresnel(towards, index)
    bent = rays.direction / index[:, None] + (beyond - towards / index)[:, None] * ahead
    mirrored = rays.direction - 2 * towards[:, None] * ahead
    back = reflected >= 0.5
    if facts.slopes:
        bend = _bend(field, rays, ahead, towards)
        mirroring, refracting = _mirroring(towards), _refracting(towards, beyond, index)

    def turned(back: Bools) -> _Rays:
        direction = _unit(np.where(back[:, None], mirrored, bent))
        lost = rays.reflections + back > facts.reflections
        found = _Rays(
            weight=np.where(lost, 0, rays.weight * np.where(back, reflected, 1 - reflected)),
            place=rays.place.copy(),
            direction=direction,
            variance=rays.variance.copy(),
            fan=rays.fan.copy(),
            spread=rays.spread.copy(),
            inside=rays.inside ^ ~back,
            reflections=rays.reflections + back,
            tints=rays.tints + (~back | facts.tints_reflections),
        )
        if facts.slopes:
            _fan_out(facts, found, np.where(back, mirroring, refracting), bend)
        found.advance(slice(None), np.float32(PUSH))
        return found

    return turned(back), turned(~back)


def _bend(field: DistanceField, rays: _Rays, ahead: Floats, towards: Floats) -> Floats:
    """By how much the normals `ahead` of where rays are turn, a step further along the surface, (N,)."""
    across = np.cross(ahead, ahead[:, [1, 2, 0]])  # in case there is no plane of incidence
    along = _unit(rays.direction - towards[:, None] * ahead + np.float32(GRAZING) * across)
    last = np.array(field.facts.size, dtype=np.float32) - 1
    beside = field.at(np.nan_to_num(np.clip(rays.place + np.float32(BESIDE) * along, 0, last)))[:, :3]
    turn = _unit(beside) * np.where(rays.inside, np.float32(1), np.float32(-1))[:, None] - ahead
    return cast(Floats, np.clip((turn * along).sum(axis=1) / np.float32(BESIDE), -ROUNDEST, ROUNDEST))


def _refracting(cosine: Floats, beyond: Floats, index: Floats) -> Floats:
    """How surfaces that refract fan beams out, in the plane of incidence and across it: (4, 2, N).

    What they multiply differences of directions by, and of places; what normals' turns count for in
    directions; and how far apart along the surface rays meet it that are one step apart.
    """
    cosine, beyond = (np.maximum(each, np.float32(FAN)) for each in (cosine, beyond))
    ratio, one = 1 / index, np.ones_like(cosine)
    steeper = ratio * cosine / beyond
    return np.array(
        [[steeper, ratio], [beyond / cosine, one], [1 - steeper, beyond - ratio * cosine], [1 / cosine, one]]
    )


def _mirroring(cosine: Floats) -> Floats:
    """The same of surfaces that mirror, of directions behind the mirror."""
    cosine = np.maximum(cosine, np.float32(FAN))
    one = np.ones_like(cosine)
    return np.array([[one, one], [one, one], [-2 * one, -2 * cosine], [1 / cosine, one]])


def _fan_out(facts: FieldFacts, rays: _Rays, by: Floats, bend: Floats) -> None:
    """Change rays' beams as surfaces do, `by` such factors, whose normals `bend` (N,) along each step."""
    direction, place, turn, apart = by
    bent = turn * bend * apart
    variance, fan, spread = rays.variance, rays.fan, rays.spread
    wider = direction**2 * variance + 2 * direction * bent * fan + bent**2 * spread + turn**2 * facts.slopes
    variance = np.maximum(wider.mean(axis=0), 0)
    bounded = WIDEST / np.maximum(variance, WIDEST)
    rays.variance[:] = bounded * variance
    rays.fan[:] = bounded * (place * (direction * fan + bent * spread)).mean(axis=0)
    rays.spread[:] = bounded * (place**2 * spread).mean(axis=0)


def _fresnel(cosine: Floats, index: Floats) -> tuple[Floats, Floats]:
    """The share that a smooth surface reflects, (N,), and the cosine beyond it, 0 if all is.

    `cosine` (N,) before it; `index` (N,): of refraction beyond over that before.
    """
    beyond = np.sqrt(np.maximum(1 - (1 - cosine**2) / index**2, 0)).astype(np.float32)
    across = (cosine - index * beyond) / (cosine + index * beyond)
    along = (index * cosine - beyond) / (index * cosine + beyond)
    return np.where(beyond > 0, (across**2 + along**2) / 2, 1).astype(np.float32), beyond


def _unit(vectors: Floats) -> Floats:
    return cast(Floats, vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
