# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Single paths of light, traced for a fit: many directions, one sample each."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

import numpy as np

from ..core.arrays import Bools, Floats, Ints
from ..core.hemisphere import mirror_direction, square_to_direction
from ..core.octahedron import direction_to_octahedron
from .blocks import planes
from .plan import CapturePlan

ALL = slice(None)  # all texels
Some: TypeAlias = slice | Ints  # of the texels


class Axis(StrEnum):
    """The direction that indexes a lobe's buckets: the viewer's mirror direction or the line of sight."""

    MIRROR = "mirror"
    THROUGH = "through"


@dataclass(frozen=True, eq=False)
class LightSamples:
    """The light that leaves the plan's K texels in S exactly known directions each.

    `square` (K, S, 2): each direction's bucket coordinates B. `diffuse` and `through` (K, S, 3): the light of
    the diffuse passes and of the transmission passes; `mirrored` (K, S, 3): all other light; float16 will do.
    `colour` (K, 3): the mean of the diffuse colour pass. `seen` (K, S): whether a viewer can be there at all.
    `emitted` (K, S, 3): how much of `mirrored` the surface itself emits; None where no material emits.
    """

    plan: CapturePlan
    square: Floats
    diffuse: Floats
    mirrored: Floats
    through: Floats
    colour: Floats
    seen: Bools
    emitted: Floats | None = None


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
class LobeSamples:
    """Samples along a lobe's axis, S for each of the plan's K texels.

    `square` (K, S, 2): bucket coordinates B of the viewers. `values` (K, S, 3): the light that they see, or
    how much of it the object lets through. `used` (K, S): which samples count.
    """

    plan: CapturePlan
    axis: Axis
    square: Floats
    values: Floats
    used: Bools

    def along(self, some: Some) -> tuple[Floats, Floats]:
        """The axes of some texels' samples, (3, k, S), and their places on the octahedron, (2, k, S)."""
        towards = mirrored if self.axis is Axis.MIRROR else straight_through
        axis = planes(towards(self.plan, self.square[some].astype(np.float32), some))
        return axis, planes(direction_to_octahedron(np.moveaxis(axis, 0, -1)))

    def seen(self, some: Some) -> Floats:
        """Some texels' values, (3, k, S); 0 for samples that do not count."""
        return np.where(self.used[some], planes(self.values[some]), np.float32(0))


def mirrored(plan: CapturePlan, square: Floats, some: Some = ALL) -> Floats:
    """World mirror directions R of viewers at bucket coordinates B: (K, S, 2) -> (K, S, 3) float32.

    `some` are the texels that `square` belongs to.
    """
    return _to_world(plan, mirror_direction(square_to_direction(square)), some)


def straight_through(plan: CapturePlan, square: Floats, some: Some = ALL) -> Floats:
    """World directions -I in which viewers at bucket coordinates B look; arguments as for `mirrored`."""
    return _to_world(plan, -square_to_direction(square), some)


def _to_world(plan: CapturePlan, local: Floats, some: Some) -> Floats:
    local = local.astype(np.float32)
    count = len(plan.texel)
    tangent, bitangent, normal = (
        axis.reshape(-1, 3)[:count][some, None] for axis in (plan.tangent, plan.bitangent, plan.normal)
    )
    x, y, z = np.moveaxis(local, -1, 0)
    world = [x * tangent[..., part] + y * bitangent[..., part] + z * normal[..., part] for part in range(3)]
    return np.moveaxis(np.stack(world), 0, -1)


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
