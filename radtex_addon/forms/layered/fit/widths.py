# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of materials, and how much wider or narrower they are in each texel.

Where roughness was evaluated, widths follow from it; it is taken if it makes paths that were not fitted to
likelier. Elsewhere they are fitted to the texels' paths, unless normals vary, which would count as roughness.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ....bake.plan import CapturePlan
from ....bake.pooling import Neighbours
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints, blocks
from ....core.colour_spaces import LUMINANCE
from ....core.sampler import bilinear
from ..lookup.lobes import STEPS, Gloss, Material, reflectance
from .lobes import END, SHARPEST, Paths, angles, as_bright_facing, fit_materials, likelihood, unexplained

_VARIES = 0.15  # standard deviation of the widths' logarithm, from which they are kept
_WIDE = 0.02  # how much the wider neighbourhood counts for
_LEAST, _MOST = 1 / 256, 256.0  # of width², fitted
_OCTAVES = 16.0  # of width², evaluated: the most above and below what is usual
_GAIN = 0.01  # of the mean log-likelihood, from which evaluated widths are taken
_LESS = 0.995  # times as much may be left unexplained by a gloss as by tints, or it is not taken


@dataclass(frozen=True, eq=False)
class Lobes:
    """Lobes of M `materials`, and by what their width² is multiplied in each texel: `width` (K,) float32.

    `evaluated` (M,): of which materials that follows from their roughness; `usual` (M,): log2 of the width²
    for which it is 1 there.
    """

    materials: tuple[Material, ...]
    width: Floats
    evaluated: Bools
    usual: Floats

    def image(self, plan: CapturePlan, fine: Mapping[str, Floats]) -> Floats | None:
        """log2 of `width` as a map, gutter filled; None where it does not vary.

        (H', W', 1), as `fine` as the maps of `LayeredSamples`, where any of it was evaluated, else (H, W, 1).
        """
        if np.ptp(self.width) == 0:
            return None
        coarse: Floats = plan.placed(np.log2(self.width)[:, None], gutter=True)
        if not self.evaluated.any():
            return coarse
        number = fine["material"][..., 0].astype(np.intp)
        image = _relative(fine["width"][..., 0], self.usual[number])
        row, column = np.nonzero(~self.evaluated[number])
        if len(row):
            middle = (np.stack([column, row], axis=1) + 0.5) / image.shape[::-1]
            image[row, column] = bilinear(coarse, middle)[:, 0]
        return image[..., None]


def fit_lobes(
    paths: Paths,
    material: Ints,
    neighbours: Neighbours,
    vary: bool = True,
    evaluated: Floats | None = None,
    tint: Floats | None = None,
    glossy: Floats | None = None,
    tangent: Floats | None = None,
    least: int = 1,
) -> Lobes:
    """The lobes of all materials, at `least` so many; `material` (K,) are the texels' numbers.

    `evaluated` (K,): log2 of the width² that follows from roughness, NaN where it is not known. Widths are
    not fitted unless they may `vary`, and all 1 where they hardly differ. `tint` (K, 3): what lobes are
    multiplied by, 1 if None; `glossy` (M, 3): the materials' mean glossy colours, if these are known. Where
    weights follow better from both and from roughness than from the tint alone, materials have a `gloss`.
    `tangent` (K, 3): along what texels may be brushed.
    """
    count = max(int(material.max()) + 1, least)
    width = _fitted(paths, neighbours, vary)
    usual, taken = np.zeros(count, np.float32), np.zeros(count, bool)
    known: list[int] = []  # the materials whose roughness is
    if evaluated is not None:
        known = [number for number in range(count) if np.isfinite(evaluated[material == number]).any()]
        halves = _every_second(paths, 0), _every_second(paths, 1)
        rival = _fitted(halves[0], neighbours, vary)
        for number in known:
            own = material == number
            usual[number] = np.nanmean(evaluated[own])
            relative = _relative(evaluated, usual[number])
            taken[number] = _foretells(halves, number, 2**relative, rival)
            if taken[number]:
                width[own] = 2 ** relative[own]
    if np.ptp(width) > 0:
        paths = replace(paths, width=large_arrays.taken(width, paths.texel))
    glosses: list[Gloss | None] = [None] * count
    if tint is not None:
        shown = large_arrays.taken(tint.astype(np.float32, copy=False), paths.texel)
        if glossy is not None:
            for number in known:
                gloss = Gloss(glossy[number], float(usual[number]))
                glosses[number] = _take_gloss(paths, number, shown, width, gloss)
        paths = replace(paths, shown=shown)
    fitted = zip(fit_materials(paths, count, tangent), glosses, strict=True)
    materials = (
        one if gloss is None else replace(as_bright_facing(one), gloss=gloss) for one, gloss in fitted
    )
    return Lobes(tuple(materials), width, taken, usual)


def _take_gloss(paths: Paths, number: int, shown: Floats, width: Floats, gloss: Gloss) -> Gloss | None:
    """Replace tints by reflectances in what is `shown` (P, 3) of a material, if these tell more of its paths.

    Returns the gloss, or None where tints tell about as much, as where neither varies. `width` (K,) is that
    of `Lobes`.
    """
    own = large_arrays.flatnonzero(len(shown), lambda block: paths.material[block] == number)

    def reflect(block: slice) -> Floats:
        which = own[block]
        wide = (width[paths.texel[which]] * 2**gloss.width).astype(np.float32)
        return reflectance(shown[which] * gloss.colour, wide, paths.cosine[which])

    reflected, some = large_arrays.from_blocks(len(own), reflect), paths.of(number)
    if unexplained(some, reflected) > _LESS * unexplained(some, large_arrays.taken(shown, own)):
        return None
    for block in blocks(len(own)):
        shown[own[block]] = reflected[block]
    return gloss


def _every_second(paths: Paths, first: int) -> Paths:
    """Every second path, from the `first` on."""
    return paths.looked_up(large_arrays.flatnonzero(len(paths.texel), lambda some: _every_other(some, first)))


def _every_other(some: slice, first: int) -> Bools:
    odd: Bools = np.arange(some.start, some.stop) % 2 == first
    return odd


def _spread(width: Floats, texel: Ints) -> float:
    """The standard deviation of the logarithm of texels' widths (K,), of those of paths' texels (P,)."""
    values = large_arrays.from_blocks(len(texel), lambda block: np.log(width[texel[block]]))
    values -= values.mean()
    values *= values
    return float(np.sqrt(values.mean()))


def _relative(evaluated: Floats, usual: Floats) -> Floats:
    """By how many octaves widths² differ from what is usual; 0 where they are not known."""
    found: Floats = np.clip(np.nan_to_num(evaluated - usual), -_OCTAVES, _OCTAVES).astype(np.float32)
    return found


def _fitted(paths: Paths, neighbours: Neighbours, vary: bool) -> Floats:
    """`fit_widths`, all 1 where widths may not `vary` or hardly differ."""
    width = fit_widths(paths, neighbours)
    return width if vary and np.log(width).std() / 2 >= _VARIES else np.ones_like(width)


def _foretells(halves: tuple[Paths, Paths], number: int, width: Floats, rival: Floats) -> bool:
    """Whether a material's paths are likelier with its texels' lobes so much wider, (K,), than alike.

    Or than with those of a `rival` (K,). Lobes are fitted to half of the paths, and asked for the other half.
    """
    known, asked = (half.of(number) for half in halves)
    if not len(known.texel) or _spread(width, known.texel) / 2 < _VARIES:
        return False
    none = large_arrays.zeros(len(known.texel), np.int32)
    told = []
    rivals = [np.ones_like(width), *([rival] if np.ptp(rival) > 0 else [])]
    for one in (width, *rivals):
        half = replace(known, material=none, width=large_arrays.taken(one, known.texel))
        (lobes,) = fit_materials(half, 1)
        told.append(likelihood(lobes, replace(asked, width=large_arrays.taken(one, asked.texel))))
    return told[0] > max(told[1:]) + _GAIN


def fit_widths(paths: Paths, neighbours: Neighbours) -> Floats:
    """By how much the texels' paths are further from their axes than those of their material, squared: (K,).

    Means of logarithms, which the few paths in a lobe's tails hardly change; float32.
    """
    texels, count = len(neighbours.plan.texel), len(paths.texel)

    def kinds(some: slice) -> Ints:
        step = np.clip((paths.cosine[some] * STEPS).astype(np.intp), 0, STEPS - 1)
        found: Ints = paths.material[some].astype(np.intp) * STEPS + step
        return found

    def brightness(some: slice) -> Floats:
        found = (paths.weight[some] @ LUMINANCE).astype(np.float64)
        found[np.linalg.norm(paths.end[some], axis=1) < END] = 0
        return found

    def distances(some: slice) -> Floats:
        length = np.maximum(np.linalg.norm(paths.end[some], axis=1), END)
        up, across = angles(paths.end[some] / length[:, None], paths.axis[some], paths.normal[some])
        return np.log(np.maximum(up**2 + across**2, SHARPEST**2)).astype(np.float64)

    kind, bright, far = (large_arrays.from_blocks(count, each) for each in (kinds, brightness, distances))
    weighted = large_arrays.from_blocks(count, lambda some: bright[some] * far[some])
    usual = np.bincount(kind, weighted) / np.maximum(np.bincount(kind, bright), 1e-12)
    for some in blocks(count):
        weighted[some] = bright[some] * (far[some] - usual[kind[some]])
    sums = [np.bincount(paths.texel, values, texels) for values in (weighted, bright)]
    table = np.stack(sums)[..., None].astype(np.float32)
    pooled = neighbours.pool(table) + np.float32(_WIDE) * neighbours.pool(table, True)
    width = np.exp(pooled[0, :, 0] / np.maximum(pooled[1, :, 0], 1e-12))
    return np.clip(width, _LEAST, _MOST).astype(np.float32)
