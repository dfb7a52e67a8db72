# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The buckets of what is mirrored: what the object shows of itself, what it leaves free, and the rest.

An object that shows itself in its mirrors needs many cells for that; one that hardly does has more of many
cells for the rest. Both take as many bytes: samples that neither was fitted to choose between them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import Axis, LightSamples, LobeSamples
from ....core.arrays import Bools, Floats
from ....core.colour_spaces import LUMINANCE
from ..cells import CELLS
from ..lookup.atlas import mirrored_light
from ..samples import OwnRays
from .known import Known
from .own_light import Surface, own_light
from .parts import Parts
from .residual import BRIGHTEST, brightness_weight, fit_rest, mean_brightness
from .rows import Places, halved, random_half
from .turned import cosines, turned_samples
from .visibility import free_share

_MIRRORS_ITSELF = 0.25  # share of mirror rays that meet the object, from which on there is no choice
_SEED = 2


@dataclass(frozen=True, eq=False)
class Buckets:
    """By bucket and cell: `own` light (3, B, n*n), the share left `free` (1, B, n*n), `rest` (3, B, m*m)."""

    own: Floats
    free: Floats
    rest: Floats

    @property
    def rest_cells(self) -> int:
        return math.isqrt(self.rest.shape[2])


def fit_buckets(
    surface: Surface, own: OwnRays, light: LightSamples, used: Bools, parts: Parts, known: Known | None = None
) -> Buckets:
    """Fit them to light samples, of which `used` (K, S) count, and rays in which the object meets itself."""
    fit = _Fit(surface, own, light, used, parts)
    choices = CELLS if parts.cells and parts.rest and own.hit.mean() < _MIRRORS_ITSELF else CELLS[:1]
    if known is not None:
        choices = (known.cells,)
    number = 0
    place = fit.places()
    models = [fit.model(cells, place) for cells, _ in choices]
    if len(choices) > 1:
        half = random_half(used.shape, _SEED)
        level = mean_brightness(light.mirrored, used)
        most = np.float32(BRIGHTEST * level)
        judge = models[0].shown
        errors = [
            fit.error(model, place, cells, half, judge, (level, most))
            for model, (_, cells) in zip(models, choices, strict=True)
        ]
        number = int(np.argmin(errors))
        del judge
    model, cells = models[number], choices[number][1]
    del models
    rest: Floats = np.zeros((3, len(surface.grid), cells * cells), dtype=np.float32)
    if parts.rest:
        share = 1.0 if known is None else known.share
        rest = fit_rest(place, light.mirrored, used, model.shown, surface.grid, cells, share)
    return Buckets(model.own, model.free, rest)


@dataclass(frozen=True, eq=False)
class _Model:
    """Own light, what is left free, and what is shown of both and the surroundings: (3, K, S) float16."""

    own: Floats
    free: Floats
    shown: Floats


@dataclass(frozen=True, eq=False)
class _Fit:
    surface: Surface
    rays: OwnRays
    light: LightSamples
    used: Bools
    parts: Parts

    @property
    def samples(self) -> LobeSamples:
        light = self.light
        return turned_samples(
            LobeSamples(light.plan, Axis.MIRROR, light.square, light.mirrored, self.used), self.surface.normal
        )

    def places(self) -> Places:
        """The light samples' places on the octahedron's square."""
        samples, found = self.samples, Places(self.used.shape)
        in_blocks(lambda some: found.keep(some, samples.along(some)[1]), *self.used.shape)
        return found

    def model(self, cells: int, place: Places) -> _Model:
        surface = self.surface
        if cells != surface.cells:
            free = free_share(self.rays.rays, self.rays.hit, surface.grid, cells)
            surface = replace(surface, free=free)
        own = np.zeros((3, *surface.free.shape[1:]), dtype=np.float32)
        if self.parts.own:
            own = own_light(surface, self.rays)
        return _Model(own, surface.free, _shown(surface, self.samples, place, own))

    def error(
        self,
        model: _Model,
        place: Places,
        cells: int,
        half: Bools,
        judge: Floats,
        limits: tuple[np.float32, np.float32],
    ) -> float:
        """The sum of weighted squares of errors in the samples that are not in `half`.

        Of a rest that is fitted to that half. Weights are by what `judge` (3, K, S) shows; `limits` are the
        mean brightness, and that above which samples count as no brighter.
        """
        level, most = limits
        grid, light = self.surface.grid, self.light.mirrored
        rest = fit_rest(place, light, self.used & half, model.shown, grid, cells)

        def squares(some: slice) -> float:
            told = model.shown[:, some] + grid.gather(rest, place[some], some)
            off = np.minimum(planes(light[some]), most) - np.minimum(told, most)
            weight = brightness_weight(judge[:, some].astype(np.float32), level)
            judged = weight * (self.used[some] & ~half[some])
            return float((judged * np.tensordot(LUMINANCE, off * off, axes=1)).sum(dtype=np.float64))

        errors: list[float] = in_blocks(squares, *self.used.shape)
        return sum(errors)


def _shown(surface: Surface, samples: LobeSamples, place: Places, own: Floats) -> Floats:
    """What the model says of the samples, (3, K, S) float16."""
    shape = samples.used.shape
    shown = np.empty((3, *shape), dtype=np.float16)
    offset = (surface.plan.points - surface.around.middle).astype(np.float32)

    def look(some: slice) -> None:
        axis, _ = samples.along(some)
        where = place[some]
        each = np.arange(some.start, some.stop).repeat(shape[1])
        direct, share = mirrored_light(
            surface.around, surface.materials, offset[each], axis.reshape(3, -1).T, surface.normal[each],
            cosines(surface.plan, samples.square, surface.normal, some).ravel(),
            surface.material[each], surface.width[each],
            surface.grid.gather(surface.free, where, some)[0].ravel(), surface.cells,
        )  # fmt: skip
        seen = direct + share * surface.grid.gather(own, where, some).reshape(3, -1)
        shown[:, some] = halved((seen * surface.tint[each].T).reshape(3, -1, shape[1]))

    in_blocks(look, shape[0], shape[1], 1 << 16)
    return shown
