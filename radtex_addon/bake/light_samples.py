# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Single paths of light, traced for the shared layout: many directions, one sample each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from ..core.arrays import Bools, Floats, Ints
from ..core.atlas import AtlasLayout
from ..core.frame import fallback_tangent, orthonormal_frame
from ..core.hemisphere import mirror_direction, square_to_direction
from ..core.octahedron import direction_to_octahedron, octahedron_cell, octahedron_to_direction
from .plan import CapturePlan

ALL = slice(None)  # all texels
_NEAR_SIZE = 64  # cells along a side of the map of near things
_BEFORE = 0.95  # rays to a near thing start at this share of its distance from the middle


@dataclass(frozen=True, eq=False)
class LightSamples:
    """The light that leaves the plan's K texels in S exactly known directions each.

    `square` (K, S, 2): each direction's bucket coordinates B. `diffuse` and `through` (K, S, 3): the light of
    the diffuse passes and of the transmission passes; `mirrored` (K, S, 3): all other light; float16 will do.
    `colour` (K, 3): the mean of the diffuse colour pass. `seen` (K, S): whether a viewer can be there at all.
    """

    plan: CapturePlan
    square: Floats
    diffuse: Floats
    mirrored: Floats
    through: Floats
    colour: Floats
    seen: Bools


@dataclass(frozen=True, eq=False)
class EndSamples:
    """Where paths that leave the object end: S paths from each of the plan's K texels.

    `square` (K, S, 2): bucket coordinates B of the viewers. For each lobe of the first bounce, `mirrored` and
    `through`, (K, S, 3) each: how much the object lets through (`..._weight`), and the direction of the end
    from the object's middle (`..._end`), shorter than 1 where a sample mixes several ends, 0 without any.
    """

    plan: CapturePlan
    square: Floats
    mirrored_weight: Floats
    mirrored_end: Floats
    through_weight: Floats
    through_end: Floats


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


def mirrored(plan: CapturePlan, square: Floats, some: slice = ALL) -> Floats:
    """World mirror directions R of viewers at bucket coordinates B: (K, S, 2) -> (K, S, 3) float32.

    `some` are the texels that `square` belongs to.
    """
    return _to_world(plan, mirror_direction(square_to_direction(square)), some)


def straight_through(plan: CapturePlan, square: Floats, some: slice = ALL) -> Floats:
    """World directions -I in which viewers at bucket coordinates B look; arguments as for `mirrored`."""
    return _to_world(plan, -square_to_direction(square), some)


def _to_world(plan: CapturePlan, local: Floats, some: slice) -> Floats:
    local = local.astype(np.float32)
    count = len(plan.texel)
    tangent, bitangent, normal = (
        axis.reshape(-1, 3)[:count][some, None] for axis in (plan.tangent, plan.bitangent, plan.normal)
    )
    world = local[..., :1] * tangent + local[..., 1:2] * bitangent + local[..., 2:] * normal
    return cast(Floats, world)


def spread_shifts(count: int, seed: int) -> Floats:
    """A point in [0, 1)^2 for each of `count` texels: (count, 2), low-discrepancy, shifted by `seed`.

    So the directions of neighbouring texels interleave. Roberts, "The Unreasonable Effectiveness
    of Quasirandom Sequences" (2018): steps of 1/g and 1/g^2, g^3 = g + 1.
    """
    golden = 1.32471795724474602596
    steps = np.array([1 / golden, 1 / golden**2])
    turn = np.random.default_rng(seed).random(2)
    shifts: Floats = (turn + np.arange(count)[:, None] * steps) % 1.0
    return shifts


def cells_of(square: Floats, bucket: int) -> Ints:
    """Flat index q * n + p of the bucket cell that holds B: (..., 2) -> (...)."""
    cell = np.clip(((square + 1) / 2 * bucket).astype(np.int32), 0, bucket - 1)
    index: Ints = cell[..., 1] * bucket + cell[..., 0]
    return index
