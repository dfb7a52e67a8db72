# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of each material: how much they mirror, how wide, and how far bent, by N.V.

Measured by paths through the object alone in an empty, glowing world: they tell weights and directions
without the noise of any light. Lobes of GGX's shape, for each step of N.V, by expectation maximisation
(Dempster et al., 1977; for tails like these Lange, Little and Taylor, "Robust statistical modeling using the
t distribution", 1989). What is called variance is a lobe's width² (see `lobe`): of such tails there is none.
A lobe ends on the sphere: over squared chords d from its axis the mean of 2 d / (2 w + d), where w is its
width², is 2 / (2 + w), not 1 as in the plane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....bake.blocks import side_by_side
from ....bake.computed_rows import computed
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints
from ....core.colour_spaces import LUMINANCE
from ..lookup.lobes import LOBES, STEPS, Material, lobe, towards

_ROUNDS = 40
_AT_MOST = 40_000  # paths of a step
_AT_LEAST = 200
_OVERLAP = 0.75  # steps around a step's middle whose paths count
SHARPEST = 0.003  # radians: no lobe is narrower
_WIDEST = 1.0
_LEAST_SHOWN = 1e-3
_NO_SECOND = np.array([1.0, 0.0])  # shares of the light
_LITTLE, _MORE = 0.005, 0.02  # of the mean log-likelihood: what a second lobe must tell, and …
_WIDER = 1.5  # … where one lobe has less than so many times the variance of the stronger of two
_FACING = 13  # the first step of N.V where a surface reflects about as much as along its normal
_MOST_MET = 1.25  # times as much light, at most, as those paths tell that leave the object
_BRUSHED = 1.5  # times as much width² along the tangent as across it, or less than one over that
_UPRIGHT = 0.6  # N.V, above which facets' slopes are hardly hidden by one another
END = 0.5  # length of a direction: where paths differ too much it is shorter


@dataclass(frozen=True, eq=False)
class Paths:
    """Paths that left the object straight away, or ended in it: P of them.

    `texel` (P,): of the plan; `weight` (P, 3): how much they bring of white light; `end` (P, 3): where they
    go; `axis` (P, 3), the mirror direction, and `normal` (P, 3), all in world space; `cosine` (P,): N.V;
    `material` (P,); `width` (P,): what their material's width² is multiplied by, 1 if None; `shown`
    (P, 3): what its weights are multiplied by, 1 if None.
    """

    texel: Ints
    weight: Floats
    end: Floats
    axis: Floats
    normal: Floats
    cosine: Floats
    material: Ints
    width: Floats | None = None
    shown: Floats | None = None

    def some(self, which: Ints) -> Paths:
        """Those paths, by their numbers."""
        found: dict[str, Any] = {
            name: None if one is None else large_arrays.taken(one, which) for name, one in vars(self).items()
        }
        return Paths(**found)

    def of(self, material: int) -> Paths:
        """Those of a material."""
        which = large_arrays.flatnonzero(len(self.texel), lambda some: self.material[some] == material)
        return self if len(which) == len(self.texel) else self.looked_up(which)

    def looked_up(self, which: Ints) -> Paths:
        """As `some`, but of many paths: vectors are looked up in these whenever they are read."""

        def look_up(one: Floats) -> Floats:
            if len(one.shape) == 1:
                return large_arrays.taken(one, which)
            return computed((len(which), *one.shape[1:]), lambda some: one[which[some]])

        found: dict[str, Any] = {
            name: None if one is None else look_up(one) for name, one in vars(self).items()
        }
        return Paths(**found)

    @property
    def brightness(self) -> Floats:
        """The luminance of the paths' weights, (P,)."""
        return large_arrays.from_blocks(len(self.texel), lambda some: self.weight[some] @ LUMINANCE)


def fit_materials(paths: Paths, count: int, tangent: Floats | None = None) -> tuple[Material, ...]:
    """The lobes of so many materials; those without paths mirror nothing.

    `tangent` (K, 3): along what texels may be brushed, 0 where they are not. A brushed material has one lobe.

    A material has one lobe, the weight of the second being 0, where two tell hardly more of its paths,
    or little more and one is hardly wider than the stronger of two.
    """
    return tuple(_fit_lobes(paths, number, tangent) for number in range(count))


def _fit_lobes(paths: Paths, number: int, tangent: Floats | None) -> Material:
    brush = None if tangent is None else fit_brush(paths.of(number), tangent)
    if brush is not None:
        return replace(_fit_material(paths, number, 1), brush=brush)
    one, two = (_fit_material(paths, number, lobes) for lobes in (1, LOBES))
    some = paths.of(number)
    stronger = two.weight[:, _FACING].sum(axis=1).argmax()
    alike = one.variance[0, _FACING] < _WIDER * two.variance[stronger, _FACING]
    return one if likelihood(two, some) - likelihood(one, some) < (_MORE if alike else _LITTLE) else two


def _fit_material(paths: Paths, number: int, lobes: int) -> Material:
    weight = np.zeros((LOBES, STEPS, 3))
    variance, bend = np.full((LOBES, STEPS), 0.1), np.zeros(STEPS)

    def fit(step: int) -> bool:
        def is_near(some: slice) -> Bools:
            beside = np.abs(paths.cosine[some] * STEPS - 0.5 - step) < _OVERLAP
            found: Bools = (paths.material[some] == number) & beside
            return found

        near = large_arrays.flatnonzero(len(paths.texel), is_near)
        if len(near) < _AT_LEAST:
            return False
        if len(near) > _AT_MOST:
            near = np.random.default_rng(step).choice(near, _AT_MOST, replace=False)
        mean = paths.weight[near].mean(axis=0)
        if paths.shown is not None:
            mean /= np.maximum(paths.shown[near].mean(axis=0), _LEAST_SHOWN)
        share, variance[:, step], bend[step] = _likeliest(paths, near, lobes)
        weight[:, step] = share[:, None] * mean
        return True

    known = [step for step, found in enumerate(side_by_side(fit, range(STEPS))) if found]
    if known:
        closest = [min(known, key=lambda other: abs(other - step)) for step in range(STEPS)]
        weight, variance, bend = weight[:, closest], variance[:, closest], bend[closest]
    return Material(weight.astype(np.float32), variance.astype(np.float32), bend.astype(np.float32))


def _likeliest(paths: Paths, near: Ints, lobes: int) -> tuple[Floats, Floats, float]:
    """Shares (LOBES,), variances (LOBES,) and the bend that make the paths' directions likeliest.

    Of one lobe or two: the share of what is no lobe is 0.
    """
    bright = paths.weight[near] @ LUMINANCE
    length = np.linalg.norm(paths.end[near], axis=1)
    told = (bright > 1e-6) & (length > END)
    if not told.any():
        return _NO_SECOND, np.array([0.1, 0.1]), 0.0
    near, bright = near[told], bright[told] / bright[told].sum()
    up, across = angles(paths.end[near] / length[told, None], paths.axis[near], paths.normal[near])
    bend, width = 0.0, 1.0 if paths.width is None else paths.width[near]
    squared = np.sort((up**2 + across**2) / width / 2)
    least, most = SHARPEST**2, _WIDEST**2
    variance = np.clip(np.quantile(squared, [0.3, 0.9] if lobes > 1 else [0.5]), least, most)
    variance[1:] = np.maximum(variance[1:], 2 * variance[0])
    share = np.array([0.6, 0.4] if lobes > 1 else [1.0])
    for turn in range(_ROUNDS):
        distance = ((up - bend) ** 2 + across**2) / width
        likely = share[:, None] * lobe(distance, variance[:, None])
        likely *= bright / np.maximum(likely.sum(axis=0), 1e-30)
        total = np.maximum(likely.sum(axis=1), 1e-9)
        share = total / total.sum()
        ends = (likely * (2 / (2 + variance[:, None] * width))).sum(axis=1)  # the sphere is no plane
        likely *= 4 / (2 + distance / variance[:, None])
        variance = np.clip((likely * distance).sum(axis=1) / np.maximum(2 * ends, 1e-9), least, most)
        if turn > _ROUNDS // 8:
            pull = (likely / variance[:, None]).sum(axis=0) / width
            bend = float((pull * up).sum() / max(pull.sum(), 1e-30))
    if lobes == 1:
        return _NO_SECOND, variance.repeat(LOBES), bend
    order = np.argsort(variance)
    return share[order], variance[order], bend


def fit_brush(paths: Paths, tangent: Floats) -> tuple[float, float] | None:
    """The width² of one material's lobe along texels' tangents (K, 3) and across, that are likeliest.

    None where they hardly differ, or few paths tell. Of facets' slopes, seen at N.V above `_UPRIGHT`, GGX is
    Student's distribution with two degrees of freedom.
    """
    known, light = np.linalg.norm(tangent, axis=1) > END, paths.brightness
    told = large_arrays.flatnonzero(
        len(light),
        lambda some: (paths.cosine[some] > _UPRIGHT) & (light[some] > 1e-6) & known[paths.texel[some]],
    )
    if len(told) < _AT_LEAST:
        return None
    if len(told) > _AT_MOST:
        told = np.random.default_rng(STEPS).choice(told, _AT_MOST, replace=False)
    some = paths.some(np.sort(told))
    length = np.linalg.norm(some.end, axis=1, keepdims=True)
    viewer = 2 * some.cosine[:, None] * some.normal - some.axis
    half = some.end / np.maximum(length, 1e-6) + viewer
    half /= np.maximum((half * some.normal).sum(axis=1), 1e-3)[:, None]
    along = tangent[some.texel]
    along = along - (along * some.normal).sum(axis=1, keepdims=True) * some.normal
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-6)
    slopes = np.stack([(half * way).sum(axis=1) for way in (along, np.cross(some.normal, along))])
    bright = some.brightness * (length[:, 0] > END)
    if some.width is not None:
        slopes /= np.sqrt(some.width)
    squared, width = slopes**2, np.full(2, 0.1)
    for _ in range(_ROUNDS):
        pull = bright * 8 / (1 + (2 * squared / width[:, None]).sum(axis=0))
        width = np.clip((pull * squared).sum(axis=1) / max(bright.sum(), 1e-9), SHARPEST**2, _WIDEST**2)
    along_it, across = (float(one) for one in width)
    return (along_it, across) if max(width) > _BRUSHED * min(width) else None


def unexplained(paths: Paths, shown_light: Floats) -> float:
    """What is left of the paths' weights, squared, with so many (P, 3) times a table by N.V as told best."""
    weight, count = paths.brightness, len(paths.texel)
    shown = large_arrays.from_blocks(count, lambda some: shown_light[some] @ LUMINANCE)
    step = large_arrays.from_blocks(
        count, lambda some: np.clip((paths.cosine[some] * STEPS).astype(np.intp), 0, STEPS - 1)
    )

    def means(values: Callable[[slice], Floats]) -> Floats:
        summed = large_arrays.from_blocks(count, lambda some: values(some).astype(np.float64, copy=False))
        return np.bincount(step, summed, STEPS) / np.maximum(np.bincount(step, minlength=STEPS), 1)

    squared = np.maximum(means(lambda some: np.square(shown[some])), 1e-12)
    share = means(lambda some: weight[some] * shown[some]) / squared
    left = means(lambda some: (weight[some] - share[step[some]] * shown[some]) ** 2)
    return float((left / np.maximum(means(lambda some: weight[some] ** 2), 1e-12)).sum())


def as_bright_facing(material: Material) -> Material:
    """The material with as much light along its normal as its glossy colour says.

    Some paths that are taken to leave the object straight away meet it, and bring nothing.
    """
    facing = float((material.weight[:, _FACING:].sum(axis=0) @ LUMINANCE).mean())
    return replace(
        material, weight=material.weight * np.float32(np.clip(1 / max(facing, 1e-9), 1, _MOST_MET))
    )


def likelihood(material: Material, paths: Paths) -> float:
    """The mean logarithm of how likely a material's lobes are to send paths where they go, by their light."""
    light = paths.brightness
    told = large_arrays.flatnonzero(
        len(light),
        lambda block: (light[block] > 1e-6) & (np.linalg.norm(paths.end[block], axis=1) > END),
    )
    if not len(told):
        return 0.0
    bright = large_arrays.taken(light, told)

    def logarithms(block: slice) -> Floats:
        some = paths.some(told[block])
        length = np.linalg.norm(some.end, axis=1)
        up, across = angles(some.end / length[:, None], some.axis, some.normal)
        weight, variance, bend = material.at(some.cosine)
        share = np.tensordot(LUMINANCE, weight, (0, 1))
        share /= np.maximum(share.sum(axis=0), 1e-30)
        if some.width is not None:
            variance = variance * some.width
        found = (share * lobe((up - bend) ** 2 + across**2, np.maximum(variance, SHARPEST**2))).sum(axis=0)
        logarithm: Floats = bright[block] * np.log(np.maximum(found, 1e-30))
        return logarithm

    return float(large_arrays.from_blocks(len(told), logarithms).sum() / bright.sum())


def angles(end: Floats, axis: Floats, normal: Floats) -> tuple[Floats, Floats]:
    """How far ends lie from their axes, radians: in the plane of incidence towards the normal, and across."""
    aside = towards(axis, normal)
    across = np.cross(axis, aside)
    angle = np.arccos(np.clip((end * axis).sum(axis=1), -1, 1))
    scale = 1 / np.maximum(np.cos(angle / 2), 0.1)
    return (end * aside).sum(axis=1) * scale, (end * across).sum(axis=1) * scale
