# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The buckets of what is mirrored: what the object shows of itself, what it leaves free, and the rest.

An object that shows itself in its mirrors needs many cells for that; one that hardly does has more of many
cells for the rest. Both take as many bytes: samples that neither was fitted to choose between them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import Axis, LightSamples, LobeSamples, straight_through
from ....bake.plan import CapturePlan
from ....bake.pooling import Neighbours, Taps
from ....core.arrays import Bools, Floats
from ....core.colour_spaces import LUMINANCE
from ....core.octahedron import direction_to_octahedron
from ..cells import CELLS
from ..lookup.atlas import mirrored_light
from ..samples import OwnRays
from .own_light import Surface, own_light
from .parts import Parts
from .residual import BRIGHTEST, brightness_weight, fit_rest, mean_brightness
from .visibility import free_share

_MIRRORS_ITSELF = 0.25  # share of mirror rays that meet the object, from which on there is no choice
_SEED = 2


@dataclass(frozen=True, eq=False)
class Buckets:
    """By texel and cell: `own` light (3, K, n*n), the share left `free` (1, K, n*n), `rest` (3, K, m*m)."""

    own: Floats
    free: Floats
    rest: Floats

    @property
    def rest_cells(self) -> int:
        return math.isqrt(self.rest.shape[2])


def fit_buckets(
    surface: Surface, own: OwnRays, light: LightSamples, used: Bools, neighbours: Neighbours, parts: Parts
) -> Buckets:
    """Fit them to light samples, of which `used` (K, S) count, and rays in which the object meets itself."""
    fit = _Fit(surface, own, light, used, neighbours, parts)
    choices = CELLS if parts.cells and parts.rest and own.hit.mean() < _MIRRORS_ITSELF else CELLS[:1]
    models = [fit.model(cells) for cells, _ in choices]
    number = 0
    if len(choices) > 1:
        half = np.random.default_rng(_SEED).random(used.shape) < 0.5
        level = mean_brightness(light.mirrored, used)
        weight, most = brightness_weight(models[0].shown, level), np.float32(BRIGHTEST * level)
        errors = [
            fit.error(model, cells, half, weight, most)
            for model, (_, cells) in zip(models, choices, strict=True)
        ]
        number = int(np.argmin(errors))
    model, cells = models[number], choices[number][1]
    rest: Floats = np.zeros((3, len(used), cells * cells), dtype=np.float32)
    if parts.rest:
        rest = fit.rest(model, cells, used)
    return Buckets(model.own, model.free, rest)


@dataclass(frozen=True, eq=False)
class _Model:
    """Own light and what is left free, by cell, and what both and the surroundings show: (3, K, S)."""

    own: Floats
    free: Floats
    place: Floats
    shown: Floats


@dataclass(frozen=True, eq=False)
class _Fit:
    surface: Surface
    rays: OwnRays
    light: LightSamples
    used: Bools
    neighbours: Neighbours
    parts: Parts

    def model(self, cells: int) -> _Model:
        surface = self.surface
        if cells != surface.cells:
            free = free_share(self.rays.rays, ~self.rays.hit, self.neighbours, cells)
            surface = replace(surface, free=free)
        own = np.zeros((3, *surface.free.shape[1:]), dtype=np.float32)
        if self.parts.own:
            own = own_light(surface, self.rays, self.neighbours)
        light = self.light
        samples = LobeSamples(light.plan, Axis.MIRROR, light.square, light.mirrored, self.used)
        place, shown = _shown(surface, turned_samples(samples, surface.normal), own)
        return _Model(own, surface.free, place, shown)

    def rest(self, model: _Model, cells: int, used: Bools) -> Floats:
        return fit_rest(model.place, self.light.mirrored, used, model.shown, self.neighbours, cells)

    def error(self, model: _Model, cells: int, half: Bools, weight: Floats, most: np.float32) -> float:
        """The sum of weighted squares of errors in the samples that are not in `half`.

        Of a rest that is fitted to that half. What is brighter than `most` counts as that.
        """
        rest = self.rest(model, cells, self.used & half)

        def squares(some: slice) -> float:
            told = model.shown[:, some] + Taps.of(model.place[:, some], cells).gather(rest[:, some])
            off = np.minimum(planes(self.light.mirrored[some]), most) - np.minimum(told, most)
            judged = weight[some] * (self.used & ~half)[some]
            return float((judged * np.tensordot(LUMINANCE, off * off, axes=1)).sum(dtype=np.float64))

        texels, samples = self.used.shape
        errors: list[float] = in_blocks(squares, texels, samples)
        return sum(errors)


class _Turned(LobeSamples):
    """Samples along the mirror directions of shading normals `normal` (K, 3)."""

    normal: Floats

    def along(self, some: slice) -> tuple[Floats, Floats]:
        viewer = -straight_through(self.plan, self.square[some].astype(np.float32), some)
        normal = self.normal[some][:, None]
        axis = 2 * (viewer * normal).sum(axis=-1, keepdims=True) * normal - viewer
        return planes(axis), planes(direction_to_octahedron(axis.astype(np.float32)))


def turned_samples(samples: LobeSamples, normal: Floats) -> LobeSamples:
    """The samples along the mirror directions about `normal` (K, 3)."""
    turned = _Turned(samples.plan, samples.axis, samples.square, samples.values, samples.used)
    object.__setattr__(turned, "normal", normal)
    return turned


def cosines(plan: CapturePlan, square: Floats, normal: Floats, some: slice) -> Floats:
    """N.V about the shading normals, (k, S)."""
    viewer = -straight_through(plan, square[some].astype(np.float32), some)
    return cast(Floats, np.clip((viewer * normal[some][:, None]).sum(axis=-1), 1e-3, 1))


def _shown(surface: Surface, samples: LobeSamples, own: Floats) -> tuple[Floats, Floats]:
    """The samples' places on the octahedron's square (2, K, S), and what the model says of them (3, K, S)."""
    shape = samples.used.shape
    place, shown = (np.empty((count, *shape), dtype=np.float32) for count in (2, 3))
    offset = (surface.plan.points - surface.around.middle).astype(np.float32)

    def look(some: slice) -> None:
        axis, place[:, some] = samples.along(some)
        taps = Taps.of(place[:, some], surface.cells)
        each = np.arange(some.start, some.stop).repeat(shape[1])
        direct, share = mirrored_light(
            surface.around, surface.materials, offset[each], axis.reshape(3, -1).T, surface.normal[each],
            cosines(surface.plan, samples.square, surface.normal, some).ravel(),
            surface.material[each], surface.width[each],
            taps.gather(surface.free[:, some])[0].ravel(), surface.cells,
        )  # fmt: skip
        seen = (direct + share * taps.gather(own[:, some]).reshape(3, -1)) * surface.tint[each].T
        shown[:, some] = seen.reshape(3, -1, shape[1])

    in_blocks(look, shape[0], shape[1], 1 << 16)
    return place, shown
