# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The buckets of what is mirrored: what the object shows of itself, what it leaves free, and the rest.

An object that shows itself in its mirrors needs many cells for that; one that hardly does has more of many
cells for the rest; and one that lights itself by many bounces, as a bowl does inside, has more of a rest at
every texel, and of no own light, unless a mirror among its materials would miss that. All take as many
bytes: samples that none was fitted to choose between them. One whose samples are told as well without has
nothing of itself in its mirrors, and lookups need not read that. What is left free is kept as a picture,
blurred as wide as its cells: see `lookup.lobes`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from ....bake.blocks import planes
from ....bake.light_samples import LightSamples, LobeSamples
from ....core import large_arrays
from ....core.arrays import Bools, Floats
from ....core.atlas import AtlasLayout
from ....settings.rays import coarser
from ..cells import CELLS, CLEAR, HOLLOW, Cells
from ..lookup.atlas import lobes_light
from ..lookup.lobes import shown_at
from ..samples import OwnRays
from .bucket_grid import Block, BucketGrid
from .known import Known
from .own_light import OwnLight, Surface, own_light
from .residual import fit_rest, mean_brightness, weighted_squares
from .rows import Places, halved, random_half
from .turned import mirrored_about, octahedral

_PRIOR = 0.0125  # of a cell's rays: the wider neighbourhood's count for that many
_LITTLE = 0.02  # share of mirror rays that meet the object, below which it may mirror nothing, by samples, …
_NONE = 1e-3  # … below which it does not
_TELLS = 1e-3  # of the samples' error: by how much own light must lessen it to be worth its fetches
_WORSE = (1e-2, 1e-4)  # of a material's and of all error: how much worse `HOLLOW` may tell a material
_SEED = 2
_ROWS = 1 << 12  # texels whose samples are in hand at once


def free_share(rays: LobeSamples, hit: Bools, grid: BucketGrid, cells: int) -> Floats:
    """The share of mirror rays that miss the object, by direction: (1, B, cells * cells).

    `hit` (K, S): which of the `rays` do not.
    """
    if not hit.any():
        return np.ones((1, len(grid), cells * cells), dtype=np.float32)
    table = large_arrays.empty((2, len(grid), cells * cells))

    def sum_up(block: Block) -> None:
        _, place = rays.along(block.texels)
        missed = (~hit[block.texels]).astype(np.float32)
        table[:, block.buckets] = block.scatter(place, cells, [missed, np.ones_like(missed)])

    grid.in_blocks(sum_up, hit.shape[1])
    prior = np.float32(_PRIOR * float(table[1].mean()))

    def share(own: Floats, wide: Floats) -> Floats:
        usual = (wide[0] + 1e-3) / (wide[1] + 1e-3)
        free: Floats = (own[0] + prior * usual) / (own[1] + prior)
        return free[None]

    return large_arrays.copied(grid.pool(table, grid.neighbours.pool_further, share))


@dataclass(frozen=True)
class Parts:
    """Which parts of the layout are fitted: each may be left out, to see what it is worth."""

    own: bool = True
    rest: bool = True
    lamps: bool = True
    layers: bool = True
    tint: bool = True
    normals: bool = True
    second_lobe: bool = True
    widths: bool = True
    cells: bool = True
    smooth: bool = True


ALL_PARTS = Parts()


@dataclass(frozen=True, eq=False)
class FittedBuckets:
    """By bucket and cell: `own` light (3, B, n*n), the share left `free` (1, B, n*n), `rest` (3, B', m*m).

    The rest is in buckets of the `rest_grid`.
    """

    own: Floats
    free: Floats
    rest: Floats
    rest_grid: BucketGrid

    @property
    def rest_cells(self) -> int:
        return math.isqrt(self.rest.shape[2])


def fit_buckets(
    surface: Surface, own: OwnRays, light: LightSamples, used: Bools, parts: Parts, known: Known | None = None
) -> FittedBuckets:
    """Fit them to light samples, of which `used` (K, S) count, and rays in which the object meets itself."""
    fit = _Fit(
        surface, own, own_light(surface, own) if parts.own else None, light, used,
        Places(used.shape), mean_brightness(light.mirrored, used),
    )  # fmt: skip
    choices = _choices(own, parts, surface.plan.layout) if known is None else (known.cells,)
    cells = choices[0] if len(choices) == 1 else fit.best(choices)
    model = fit.model(surface.grid, cells.own)
    (shown,) = fit.shown([model])
    grid = fit.rest_grid(surface.grid, cells)
    rest: Floats = large_arrays.zeros((3, len(grid), cells.rest**2))
    if parts.rest:
        rest = fit.rest(grid, shown, used, cells.rest, 1.0 if known is None else known.share)
    return FittedBuckets(model.own, model.free, rest, grid)


def _choices(own: OwnRays, parts: Parts, layout: AtlasLayout) -> Sequence[Cells]:
    """The numbers of cells between which samples choose."""
    share = own.hit.mean()
    if not (parts.cells and parts.rest):
        return CELLS[:1]
    if share < _LITTLE:
        return CLEAR if share < _NONE else (*CELLS, *CLEAR)
    by_four = coarser(max(layout.width, layout.height)) == 2  # else a bucket for each texel takes more bytes
    return (*CELLS, HOLLOW) if by_four else CELLS


@dataclass(frozen=True, eq=False)
class _Model:
    """Own light (3, B, n*n), and what is left free (1, B, n*n), of a grid's buckets."""

    grid: BucketGrid
    own: Floats
    free: Floats

    @property
    def cells(self) -> int:
        return math.isqrt(self.free.shape[2])


@dataclass(frozen=True, eq=False)
class _Fit:
    """`place`: of light samples, once a model of them was looked up; `level`: their mean brightness."""

    surface: Surface
    rays: OwnRays
    own: OwnLight | None
    light: LightSamples
    used: Bools
    place: Places
    level: np.float32

    def best(self, choices: Sequence[Cells]) -> Cells:
        """The numbers of cells that show a part of the buckets best."""
        part = self.surface.grid.part
        half = random_half(self.used.shape, _SEED)
        models = {cells: self.model(part, cells) for cells in dict.fromkeys(each.own for each in choices)}
        shown = dict(zip(models, self.shown(list(models.values())), strict=True))
        judge = shown[choices[0].own]
        errors = np.array([self.errors(part, each, shown[each.own], half, judge) for each in choices])
        handicap = np.array([1.0 if choice in CLEAR else 1 + _TELLS for choice in choices])
        first, second = map(int, np.argsort(errors.sum(axis=1) * handicap)[:2])
        most = (1 + _WORSE[0]) * errors[second] + _WORSE[1] * errors[second].sum()
        mirrors_itself = choices[first] == HOLLOW and (errors[first] > most).any()
        return choices[second] if mirrors_itself else choices[first]

    def model(self, grid: BucketGrid, cells: int) -> _Model:
        surface = self.surface
        if cells == CLEAR[0][0]:
            own = large_arrays.zeros((4, len(grid), cells * cells))
            own[3] = 1
            return _Model(grid, own[:3], own[3:])
        if grid is surface.grid and cells == surface.cells:
            free = surface.free
        else:
            free = free_share(self.rays.rays, self.rays.hit, grid, cells)
        if self.own is None:
            return _Model(grid, large_arrays.zeros((3, *free.shape[1:])), free)
        return _Model(grid, self.own.buckets(grid, cells), free)

    def shown(self, models: Sequence[_Model]) -> list[Floats]:
        """What models of the same grid say of its texels' samples, (3, K, S) float16; keeps their places."""
        surface, grid, square = self.surface, models[0].grid, self.light.square
        offset = (surface.plan.points - surface.around.middle).astype(np.float32)
        number, each = np.arange(len(self.used)), self.used.shape[1]
        shown = [large_arrays.empty((3, *self.used.shape), np.float16) for _ in models]

        def look(block: Block) -> None:
            some = block.texels
            axis, cosine = mirrored_about(surface.plan, square, surface.normal, some)
            place = self.place.keep(some, octahedral(axis))
            material, width = surface.material[some].repeat(each), surface.width[some].repeat(each)
            tint = _for_each(surface.tint[some], each).T
            tint = shown_at(surface.materials, material, cosine.ravel(), tint, width)
            lobes = list(
                lobes_light(
                    surface.around, surface.materials, _for_each(offset[some], each).T,
                    axis.reshape(3, -1).T, _for_each(surface.normal[some], each).T, cosine.ravel(),
                    material, width, surface.lit_at(number[some].repeat(each)),
                    tangent=surface.tangent_at(number[some].repeat(each)),
                )
            )  # fmt: skip
            for model, kept in zip(models, shown, strict=True):
                direct, share = (np.zeros((3, cosine.size), dtype=np.float32) for _ in range(2))
                free = grid.gather(model.free, place, some)[0].ravel()
                for lobe in lobes:
                    lobe.add_to(direct, share, free, model.cells)
                if self.own is not None:
                    direct += share * grid.gather(model.own, place, some).reshape(3, -1)
                kept[:, some] = halved((direct * tint.T).reshape(3, -1, each))

        grid.in_blocks(look, each)
        return shown

    def rest_grid(self, grid: BucketGrid, cells: Cells) -> BucketGrid:
        """The buckets of the rest, of the texels of a grid of buckets of own light."""
        return grid.of_texels() if cells.every else grid

    def rest(self, grid: BucketGrid, shown: Floats, used: Bools, cells: int, share: float = 1.0) -> Floats:
        """What a model lacks that has `shown` (3, K, S) of samples that are `used`: (3, B, cells * cells)."""
        return fit_rest(self.place, self.light.mirrored, used, shown, grid, cells, self.level, share)

    def errors(self, part: BucketGrid, cells: Cells, shown: Floats, half: Bools, judge: Floats) -> Floats:
        """By material (M,), the sum of weighted squares of errors in `part`'s samples that are not in `half`.

        Of a rest that is fitted to that half, and added to what a model has `shown`. Weights are by what
        `judge` (3, K, S) shows; above some brightness, samples count as no brighter.
        """
        grid, light = self.rest_grid(part, cells), self.light.mirrored
        material, count = self.surface.material, len(self.surface.materials)
        fitted = large_arrays.from_blocks(len(half), lambda some: self.used[some] & half[some], _ROWS)
        rest = self.rest(grid, shown, fitted, cells.rest)

        def squares(block: Block) -> Floats:
            some = block.texels
            told = shown[:, some] + grid.gather(rest, self.place[some], some)
            counted = self.used[some] & ~half[some]
            of_texels = weighted_squares(light[some], told, judge[:, some], counted, self.level)
            return cast(Floats, np.bincount(material[some], of_texels, minlength=count))

        return sum(grid.in_blocks(squares, self.used.shape[1]), np.zeros(count))


def _for_each(values: Floats, times: int) -> Floats:
    """Values (k, C) of texels for each of their samples: (C, k * times)."""
    return planes(values).repeat(times, axis=1)
