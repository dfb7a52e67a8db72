# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting what comes through the object: the chief path of each cell, and what is left of the light.

The chief path is the one that most of a cell's paths agree with, and its neighbours': where a clear object
splits light at each surface, the share that refracts every time. Its ray is kept as it is, without pooling.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ....bake.blocks import in_blocks, planes
from ....bake.light_samples import Axis, EndSamples, LightSamples, LobeSamples, straight_through
from ....bake.plan import CapturePlan
from ....bake.pooling import Neighbours
from ....core import large_arrays
from ....core.arrays import Bools, Floats
from ....core.colour_spaces import LUMINANCE
from ....core.hemisphere import cell_centres, square_to_direction
from ..cells import THROUGH_CELLS
from ..lookup.distance_field import DistanceField, follow, reflected
from ..lookup.environment import Around
from ..lookup.ways import CHANNELS, Through, look_through
from ..samples import ExitSamples
from .bucket_grid import Block, BucketGrid
from .residual import BRIGHTER, BRIGHTEST, brightness_weight, fit_rest, mean_brightness, weighted_squares
from .rows import Places, halved, random_half
from .texel_maps import texel_middles

_FAINT = 1e-3  # of all light: what comes through and is less is left out
_AGREE = 0.97  # cosine between paths that go the same way
_NEAR = 0.9  # cosine between a path and those of the texels around, if it goes their way
_NEARBY = 1.6  # paths that the way of the texels around counts for
_AGREEING = 2.0  # paths that have to agree
_ROUNDS = 2
_BINOMIAL = np.array([0.25, 0.5, 0.25], dtype=np.float32)  # what neighbouring cells count for
_LEAST = 1e-6
_DARKEST = 0.01  # share of the light that glass lets through
_SEED = 5
_RAREST = 30.0  # times the mean: as `BRIGHTEST`, where much of the light is in few paths
_BOUNDED = 2 / 3  # of the light, from which on that is much
_LEAST_RIGHT = 0.1
_EVEN = 0.01  # times the square of the mean: a variance; ways that show hardly more here than there are right
_FOLLOWED = 16  # cells of each texel, of coloured glass
_ROWS = 1 << 12  # texels whose samples are in hand at once


def lets_through(alone: EndSamples, light: LightSamples) -> bool:
    """Whether enough light comes through the object to be fitted."""
    through = light.through.sum(dtype=np.float64)
    total = through + light.mirrored.sum(dtype=np.float64) + light.diffuse.sum(dtype=np.float64)
    return bool(through > _FAINT * total and alone.through_weight.any())


def fit_ways(exits: ExitSamples, neighbours: Neighbours) -> Floats:
    """The chief paths of the plan's texels and cells, as in `Through`: (8, K, n*n).

    A few paths may all go astray: where too few agree, and the texels around say otherwise,
    those count. How much gets through is pooled, and averaged with the cells around whose paths go alike, as
    it is a share of few paths.
    """
    ways, votes = _chief(exits, np.zeros((3, *exits.weight.shape[1:]), dtype=np.float32))
    for _ in range(_ROUNDS):
        towards = neighbours.pool(_unit(ways[:3]) * votes)
        ways, votes = _chief(exits, towards / np.maximum(np.linalg.norm(towards, axis=0), _LEAST))
    own = ways / np.maximum(ways[3], _LEAST)
    agreed = (votes >= _AGREEING) & (ways[3] > 0)
    pooled = neighbours.pool(np.concatenate([own * agreed, ways[3:4], np.ones_like(ways[3:4])]))
    others = pooled[:CHANNELS] / np.maximum(pooled[3], _LEAST)
    weight = pooled[CHANNELS] / np.maximum(pooled[CHANNELS + 1], _LEAST)
    chosen: Floats = np.where(agreed, own, others).astype(np.float32)
    return cast(Floats, chosen * _averaged(weight, _unit(chosen[:3])))


def _averaged(weight: Floats, direction: Floats) -> Floats:
    """Weights (K, n*n), averaged with those of the cells around whose `direction` (3, K, n*n) is alike."""
    count, cells = weight.shape
    side = round(cells**0.5)
    steps = [slice(max(step, 0), side + min(step, 0)) for step in (-1, 0, 1)]
    shares = np.outer(_BINOMIAL, _BINOMIAL)
    found = np.empty_like(weight)

    def average(some: slice) -> None:
        own, towards = weight[some].reshape(-1, side, side), direction[:, some].reshape(3, -1, side, side)
        total, sums = np.zeros_like(own), np.zeros_like(own)
        for (row, column), share in np.ndenumerate(shares):
            here, there = (slice(None), steps[2 - row], steps[2 - column]), (..., steps[row], steps[column])
            cosine = (towards[(slice(None), *here)] * towards[there]).sum(axis=0)
            counts = share * ((cosine > _NEAR) | (share == shares.max()))
            total[here] += counts
            sums[here] += counts * own[there]
        found[some] = (sums / total).reshape(-1, cells)

    in_blocks(average, count, cells)
    return found


def _unit(direction: Floats) -> Floats:
    unit: Floats = direction / np.maximum(np.linalg.norm(direction, axis=0), _LEAST)
    return unit


def _chief(exits: ExitSamples, around: Floats) -> tuple[Floats, Floats]:
    """The ways that most paths agree with, (8, K, m), and how many do (K, m), with the texels around.

    `around` (3, K, m): the unit directions of the texels around, 0 where there are none.
    """
    times, count, cells = exits.weight.shape
    found = large_arrays.zeros((CHANNELS, count, cells))
    votes = large_arrays.zeros((count, cells))

    def choose(some: slice) -> None:
        direction, weight = exits.direction[:, some], exits.weight[:, some]
        best = np.zeros(weight.shape[1:], dtype=np.float32)
        keep = np.zeros(weight.shape, dtype=np.float32)
        towards = np.moveaxis(around[:, some], 0, -1)
        for one, own in zip(direction, weight, strict=True):
            agree = ((direction * one).sum(axis=-1) > _AGREE) & (weight > 0)
            near = (towards * one).sum(axis=-1) > _NEAR
            score = (agree.sum(axis=0) + _NEARBY * near) * (own > 0)
            better = score > best
            best = np.where(better, score, best)
            keep = np.where(better, agree * weight, keep)
        total = np.maximum(keep.sum(axis=0), _LEAST)
        mean = (keep[..., None] * direction).sum(axis=0) / total[..., None]
        place = (keep[..., None] * exits.place[:, some]).sum(axis=0) / total[..., None]
        length = np.linalg.norm(mean, axis=-1)
        paths = np.maximum((keep > 0).sum(axis=0), 1)
        variance = np.where(paths > 1, np.maximum(1 - length, 0) * paths / np.maximum(paths - 1, 1), 0)
        share = keep.sum(axis=0) / times
        found[:3, some] = planes(mean / np.maximum(length, _LEAST)[..., None]) * share
        found[3, some] = share
        found[4:7, some] = planes(place) * share
        found[7, some] = variance * share
        votes[some] = best

    in_blocks(choose, count, cells * times)
    return found, votes


def fit_through(
    exits: ExitSamples, light: LightSamples, around: Around, used: Bools, grid: BucketGrid
) -> Through:
    """The ways by cells, or through the object's field if light samples say that these show more.

    Through the field alone, or with light from all around on ways that are not followed. All are judged by
    what is left when a rest was fitted to half of the samples, in the others.
    """
    none = np.zeros((1, 1, 1, 1, 3), dtype=np.float32)
    plan, grid_of_ways = exits.plan, BucketGrid.of(exits.plan, 1)
    ways = fit_ways(exits, Neighbours(plan))
    by_cells = Through(grid_of_ways.placed(ways), plan.placed(exits.colour, gutter=True), rest=none)
    if exits.field is None:
        return by_cells
    dimmed = _dimmed(exits, exits.field, around.middle)
    twice = _square_of_tint(exits.field)  # by which light comes in and goes out
    hue = exits.colour if twice.min() == 1 else twice[None] / (twice @ LUMINANCE)
    colour = plan.placed(hue * dimmed[:, None], gutter=True)
    by_field = Through(grid_of_ways.placed(ways / dimmed[:, None]), colour, none, exits.field)
    lossless = replace(exits.field, facts=replace(exits.field.facts, all_around=1.0))
    choices = [by_cells, by_field, replace(by_field, field=lossless)]
    errors = np.nan_to_num(_errors(choices, light, around, used, grid.part), nan=np.inf)
    return choices[int(np.argmin(errors))]


def _dimmed(exits: ExitSamples, field: DistanceField, middle: Floats) -> Floats:
    """The luminance of each texel's colour (K,), with which the field's ways are as bright as traced paths.

    It is that of the tint of two surfaces, or less. `middle` (3,) of the surroundings.
    """
    cells = square_to_direction(cell_centres(exits.plan.layout.bucket).reshape(-1, 2)).astype(np.float32)
    white = 1 - reflected(cells[:, 2], field.facts.ior)
    passing = _passing(exits.plan, field, middle, cells)
    paths = exits.weight.mean(axis=0).sum(axis=1)
    pooled = Neighbours(exits.plan).pool(np.stack([paths, passing])[..., None])[..., 0]
    share = pooled[0] / np.maximum(pooled[1] * white.sum(), _LEAST)
    return cast(Floats, np.clip(share, _DARKEST, _square_of_tint(field) @ LUMINANCE).astype(np.float32))


def _passing(plan: CapturePlan, field: DistanceField, middle: Floats, cells: Floats) -> Floats:
    """Which share (K,) of what ways bring of an even light glass lets through that tints their ends alone.

    What all surfaces but those leave; told by some of the `cells` (n*n, 3), in texels' frames.
    """
    tint, count = np.array(field.facts.tint, dtype=np.float32), len(plan.texel)
    if tint.min() == 1:
        return np.ones(count, dtype=np.float32)
    twice = _square_of_tint(field)
    chosen = np.random.default_rng(_SEED).integers(len(cells), size=(count, _FOLLOWED))
    frames, offsets = plan.frames.astype(np.float32), (plan.points - middle).astype(np.float32)
    found = np.empty(count, dtype=np.float32)

    def follow_some(some: slice) -> None:
        frame, offset = frames[some].repeat(_FOLLOWED, axis=0), offsets[some].repeat(_FOLLOWED, axis=0)
        local = cells[chosen[some]].reshape(-1, 3)
        viewer = np.einsum("na,nac->nc", local, frame)
        came = 1 - reflected(local[:, 2], field.facts.ior)
        left = came.copy()
        for way in follow(field, offset, frame[:, 2], viewer):
            tinted = (twice * tint ** way.tints[:, None]) @ LUMINANCE / (twice @ LUMINANCE)
            left += way.weight * (tinted - 1)
        found[some] = left.reshape(-1, _FOLLOWED).sum(axis=1) / came.reshape(-1, _FOLLOWED).sum(axis=1)

    in_blocks(follow_some, count, _FOLLOWED)
    return found


def _square_of_tint(field: DistanceField) -> Floats:
    """What the surfaces by which light comes into an object and goes out leave of it, (3,)."""
    return np.array(field.facts.tint, dtype=np.float32) ** 2


def _errors(
    choices: Sequence[Through], light: LightSamples, around: Around, used: Bools, grid: BucketGrid
) -> list[float]:
    """The sums of weighted squares of errors in a grid's samples that are used, by choices.

    In half of the samples; the rest of each is fitted to the others. Weights are by the mean of all choices.
    """
    half = random_half(used.shape, _SEED)
    level = mean_brightness(light.through, used)
    seen = [_shown(each, light, around, grid) for each in choices]
    fitted = large_arrays.from_blocks(len(half), lambda some: used[some] & half[some], _ROWS)

    def error(place: Places, shown: Floats) -> float:
        rest = fit_rest(place, light.through, fitted, shown, grid, THROUGH_CELLS, level)

        def squares(block: Block) -> float:
            some = block.texels
            told = shown[:, some] + grid.gather(rest, place[some], some)
            judge = np.mean([one[:, some] for _, one in seen], axis=0, dtype=np.float32)
            counted = used[some] & ~half[some]
            return float(weighted_squares(light.through[some], told, judge, counted, level).sum())

        return sum(grid.in_blocks(squares, used.shape[1]))

    return [error(*one) for one in seen]


def fit_through_rest(
    through: Through,
    light: LightSamples,
    around: Around,
    used: Bools,
    grid: BucketGrid,
    share: float | None = None,
) -> Through:
    """Ways with what they do not show of light samples as their rest. `used` (K, S): which count.

    New ways are dimmed if samples say that they are seldom right: the rest is brighter for it. Those that
    are known, of which new samples are a `share`, as for `fit_rest`, stay.
    """
    place, shown = _shown(through, light, around, grid)
    level = mean_brightness(light.through, used)
    if not level:
        return replace(through, rest=grid.placed(large_arrays.zeros((3, len(grid), THROUGH_CELLS**2))))
    told = _Told.of(light, shown, used, level)
    if share is None:
        right = np.float32(told.right)
        through = replace(through, colour=through.colour * right)
        in_blocks(lambda some: np.multiply(shown[:, some], right, out=shown[:, some]), *used.shape)
    brightest = _RAREST if told.bounded < _BOUNDED else BRIGHTEST
    rest = fit_rest(place, light.through, used, shown, grid, THROUGH_CELLS, level, share or 1.0, brightest)
    return replace(through, rest=grid.placed(rest))


@dataclass(frozen=True)
class _Told:
    """What light samples tell of ways, all over an object.

    `right`: by how much samples rise where ways show more, the slope of their regression; 1 where these are
    right, 0 where they are by chance. `bounded`: the share of the samples' light that is left where none may
    be much brighter than its model.
    """

    right: float
    bounded: float

    @classmethod
    def of(cls, light: LightSamples, shown: Floats, used: Bools, level: np.float32) -> _Told:
        """`shown` (3, K, S) by ways; `used` (K, S): which samples count; `level`: their mean brightness."""

        def sums(some: slice) -> Floats:
            now = shown[:, some].astype(np.float32)
            weight = used[some] * brightness_weight(now, level)
            told, found = (
                np.tensordot(LUMINANCE, one, axes=1).astype(np.float64)
                for one in (now, planes(light.through[some]))
            )
            bounded = np.minimum(found, BRIGHTER * told + BRIGHTEST * level)[used[some]].sum()
            parts = (weight, weight * told, weight * found, weight * told**2, weight * told * found)
            return np.array([*(part.sum() for part in parts), found[used[some]].sum(), bounded])

        count, told, found, squares, products, whole, bounded = np.sum(in_blocks(sums, *used.shape), axis=0)
        count = np.maximum(count, _LEAST)
        even = _EVEN * count * float(level) ** 2
        slope = (products - told * found / count + even) / (squares - told**2 / count + even)
        return cls(float(np.clip(slope, _LEAST_RIGHT, 1)), float(bounded / max(whole, 1e-30)))


def _shown(through: Through, light: LightSamples, around: Around, grid: BucketGrid) -> tuple[Places, Floats]:
    """Where light samples of a grid's texels lie in the rest's buckets, and what ways show, (3, K, S).

    Of other texels they say nothing.
    """
    plan, shape = light.plan, light.square.shape[:2]
    samples = LobeSamples(plan, Axis.THROUGH, light.square, light.through, light.seen)
    place, shown = Places(shape), large_arrays.zeros((3, *shape), np.float16)
    frame = plan.frames.astype(np.float32)
    offset = (plan.points - around.middle).astype(np.float32)
    uv = texel_middles(plan)

    def look(block: Block) -> None:
        some = block.texels
        place.keep(some, samples.along(some)[1])
        viewer = -straight_through(plan, light.square[some].astype(np.float32), some).reshape(-1, 3)
        each = some.repeat(shape[1])
        axes = (frame[each, 0], frame[each, 1], frame[each, 2])
        seen = look_through(through, around, uv[each], offset[each], axes, viewer)
        shown[:, some] = halved(seen.reshape(3, -1, shape[1]))

    grid.in_blocks(look, shape[1], 1 << 16)
    return place, shown
