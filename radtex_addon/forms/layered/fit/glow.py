# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface emits: told with its diffuse light, as finely as its colour.

The light E that a material emits towards N.V is taken as E times the falloff of its diffuse light, D times
the irradiance I; where it has none, the falloff is fitted to what it emits, such as a rim that glows. A bake
then keeps (D I + E) / I' as its colour, and I' as its irradiance, where I' is large enough for colours up to
1: lookups stay as they are. What is told badly so is left to the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ....bake.blocks import in_blocks
from ....bake.computed_rows import computed
from ....bake.light_samples import LightSamples, Some
from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Bools, Floats, Ints, blocks
from ....core.hemisphere import square_to_direction
from ....core.sampler import bilinear
from ..lookup.lobes import falloff_at
from ..samples import LayeredSamples
from .diffuse import estimate_frontal, fit_diffuse, mean_of
from .known import Known

_ALONE = 0.02  # of what a material emits: with less diffuse light, the falloff is that of what it emits
_TOLD = 0.9  # of the squares of what it emits, from which on the falloff tells it
_ALIKE = 0.05  # squares of what differs along normals, over those of what is emitted there
_FRONTAL = 0.1  # of what is emitted most, that is emitted along the normal, for it to be told by that
_OTHER = 0.02  # how far the colours of a bake are from the surface's own where it glows, at least
# From texel to texel around what glows the irradiance falls to no less than one over this: between the texels
# of the colour, which then rises as fast, a lookup's product of both is a few per cent too bright.
_FALL = 3.0
_LEAST = 1e-4  # of the brightest glow: irradiance that it does not reach beyond
_STEEPEST = 8.0  # times the light along the normal, of diffuse light and what is emitted with it
_FEW = 0.05  # of the gutter's texels
_MOST = 65504  # of half floats
_BRIGHT = 1.1  # the brightest colour that a glow makes: others would have coarser steps in the dark
_ROWS = 1 << 12  # texels whose samples are in hand at once
_TEXELS = 1 << 18  # of the maps of the material, likewise


@dataclass(frozen=True, eq=False)
class Glow:
    """What a plan's texels emit: `light` (K, 3), times the `falloff` (M, B, 3) of all diffuse light.

    `image` (H', W', 3): the same as a map as fine as the colours, multiplied by alpha as they are.
    """

    light: Floats
    falloff: Floats
    image: Floats

    def taken_from(self, light: LightSamples, material: Ints) -> LightSamples:
        """The samples with it among their `diffuse` light; what glowing texels emit is `mirrored` no more.

        What little it does not tell, as where the falloff of paint dims its lamps at a slant, does not
        come to the rest, whose coarser texels would show it beside the lamps.
        """
        assert light.emitted is not None
        emitted, glowing = light.emitted, self.light.any(axis=1)

        def with_told(some: slice) -> Floats:
            if not glowing[some].any():
                return light.diffuse[some]
            cosine = _cosine(light, some)
            curve = falloff_at(self.falloff, np.repeat(material[some], cosine.shape[1]), cosine.ravel())
            told = self.light[some, None] * curve.reshape(*cosine.shape, 3)
            return np.minimum(light.diffuse[some] + told, _MOST).astype(light.diffuse.dtype)

        def without(some: slice) -> Floats:
            if not glowing[some].any():
                return light.mirrored[some]
            shown = np.where(glowing[some, None, None], emitted[some], 0)
            return np.maximum(light.mirrored[some] - shown, 0).astype(light.mirrored.dtype)

        diffuse, mirrored = (
            large_arrays.from_blocks(len(glowing), move, _ROWS) for move in (with_told, without)
        )
        return replace(light, diffuse=diffuse, mirrored=mirrored, emitted=None)

    def folded(
        self,
        plan: CapturePlan,
        colour: Floats,
        irradiance: Floats,
        fixed: Bools | None = None,
        known: Known | None = None,
    ) -> tuple[Floats, Floats]:
        """A colour (H', W', 3) and an irradiance (H, W, 3) whose product is theirs and the glow.

        Gutters of the irradiance are those of the `plan`. Beside texels whose irradiance is `fixed` (K,),
        since their colour comes from elsewhere, what glows may be too dim. Of a bake that is `known`, its own
        colour, and its own irradiance where the glow is in it.
        """
        tall, wide = colour.shape[:2]
        row, column = (np.arange(n) * m // n for n, m in zip((tall, wide), irradiance.shape[:2], strict=True))
        every = list(blocks(tall, max(1, _TEXELS // wide)))
        needed = np.zeros_like(irradiance)
        for some in every:
            glow = self.image[some]
            if glow.any():
                at = np.ix_(row[some], column)
                whole = np.where(glow.any(axis=2, keepdims=True), colour[some] * irradiance[at] + glow, 0)
                np.maximum.at(needed, at, np.minimum(whole, _MOST))
        raised = _raised(irradiance, needed)
        if fixed is not None and fixed.any():
            beside_fixed = _widest(plan.placed(fixed[:, None], gutter=True))
            raised = np.where(beside_fixed, irradiance, raised)
            needed = np.where(beside_fixed, 0, needed)
        raised = plan.placed(raised.reshape(-1, 3)[plan.texel], gutter=True)
        raised = _with_lamps_between(raised, needed, len(plan.texel))
        other = (raised != irradiance) | (needed > 0)  # what glows faintly needs no more irradiance
        other = other.any(axis=2, keepdims=True)
        if known is not None:
            return known.atlas.colour, np.where(other, known.atlas.irradiance, irradiance)
        beside = _widest(other)[..., 0]
        found, most = large_arrays.copied(colour), max(_BRIGHT, float(colour.max()))
        for some in every:
            rows, columns = np.nonzero(beside[np.ix_(row[some], column)])
            rows += some.start
            uv = np.stack([(columns + 0.5) / wide, (rows + 0.5) / tall], axis=1).astype(np.float32)
            own, after = found[rows, columns], bilinear(raised, uv)
            whole = own * bilinear(irradiance, uv) + self.image[rows, columns]
            found[rows, columns] = np.minimum(np.divide(whole, after, out=own, where=after > 0), most)
        return found, raised


def _raised(irradiance: Floats, needed: Floats) -> Floats:
    """The irradiance (H, W, 3), and where more is `needed`, that, falling gently around it."""
    reach, least = _widest(needed), _LEAST * float(needed.max())
    raised = np.maximum(irradiance, reach)  # as much in all texels that a lookup blends
    while reach.any():
        reach = _widest(reach) / np.float32(_FALL)
        reach[(reach <= raised) | (reach < least)] = 0
        raised = np.maximum(raised, reach)
    return raised


def _with_lamps_between(raised: Floats, needed: Floats, texels: int) -> Floats:
    """The irradiance (H, W, 3) with what is `needed` of lamps where no texel has samples, which is gutter.

    All but a few texels of the gutter stay copies of the nearest one: they show which UV layer a bake is of.
    """
    more = (needed > raised).any(axis=2)
    if more.sum() > _FEW * (more.size - texels):
        return raised
    return cast(Floats, np.maximum(raised, needed))


def _widest(image: Floats) -> Floats:
    """The greatest values of each texel of an image (H, W, C) and the eight around it."""
    rows = image.copy()
    np.maximum(rows[1:], image[:-1], out=rows[1:])
    np.maximum(rows[:-1], image[1:], out=rows[:-1])
    found = rows.copy()
    np.maximum(found[:, 1:], rows[:, :-1], out=found[:, 1:])
    np.maximum(found[:, :-1], rows[:, 1:], out=found[:, :-1])
    return found


def fit_glow(
    capture: LayeredSamples,
    facing: Floats,
    falloff: Floats,
    diffuse: Floats,
    imaged: Sequence[bool] = (),
    known: Known | None = None,
) -> Glow | None:
    """What the materials emit, as far as it can be told so; None where nothing can.

    `facing` (K, S): N.V of the samples that count, of others 0; `falloff` (M, B, 3) and `diffuse` (K, 3): the
    diffuse light. Materials that are `imaged` are left out. Of a bake that is `known`, what was told so then.
    """
    light, plan, material = capture.light, capture.light.plan, capture.material
    if light.emitted is None:
        return None
    emits = _emitting(capture, light.emitted, len(falloff))
    emits[np.flatnonzero(imaged)] = False
    if not emits.any():
        return None
    curves, alone = falloff.copy(), np.zeros(len(falloff), dtype=bool)
    for number in np.unique(material[emits[material]]):
        own = np.flatnonzero(material == number)
        emitted = mean_of(light.emitted, own)
        alone[number] = diffuse[own].mean() < _ALONE * emitted
        if emitted and known is None:
            curves[number] = _curve(light, facing, own, falloff[number], bool(alone[number]))
    emitting = replace(light, diffuse=light.emitted)
    found = estimate_frontal(emitting, facing, curves, material)[0].T.astype(np.float32)
    whole, left = _squares(light.emitted, facing, found, curves, material)
    along = capture.coarse["emission"].reshape(-1, 3)[plan.texel].astype(np.float32)
    shown, falloff = np.zeros_like(diffuse), falloff.copy()
    fine, glowing = np.zeros_like(alone), np.zeros_like(alone)
    for number in map(int, np.flatnonzero(emits)):
        own = np.flatnonzero(material == number)
        told = left[own].sum() <= (1 - _TOLD) * whole[own].sum()
        if not (told if known is None else _was_folded(capture, known, number)):
            continue
        last = curves[number, -1]
        frontal = found[own] * last
        off, all_of_it = ((along[own] - frontal) ** 2).sum(), (frontal**2).sum()
        # Whether the map of what is emitted along the normal tells it:
        fine[number] = off <= _ALIKE * all_of_it and last.min() > _FRONTAL
        glowing[number] = fine[number] or alone[number] or known is not None
        if glowing[number]:
            shown[own] = along[own] / last if fine[number] else found[own]
            falloff[number] = curves[number]
    if not glowing.any():
        return None
    return Glow(shown, falloff, _image(capture, shown, falloff, fine, glowing))


def _emitting(capture: LayeredSamples, emitted: Floats, count: int) -> Bools:
    """Which of so many materials emit anything, by the samples (K, S, 3) or along the normal: (M,).

    Lamps may be narrower than texels are apart: only the fine map meets them.
    """
    found = np.zeros(count, dtype=bool)
    emission, material = capture.fine["emission"], capture.fine["material"]
    for some in blocks(len(emission), max(1, _TEXELS // emission.shape[1])):
        found[material[some, :, 0][emission[some].any(axis=2)].astype(np.intp)] = True
    glows = large_arrays.from_blocks(len(emitted), lambda some: emitted[some].any(axis=(1, 2)), _ROWS)
    found[capture.material[glows]] = True
    return found


def _curve(light: LightSamples, facing: Floats, own: Ints, falloff: Floats, alone: bool) -> Floats:
    """The falloff (B, 3) of what texels emit, `own` (k,), and of their diffuse light, if not `alone`.

    Of a pattern of lamps it is mostly theirs, of few lamps that of the paint between them, whose `falloff`
    along the normal stays.
    """
    emitted = cast(Floats, light.emitted)
    if alone:
        curve, _ = fit_diffuse(replace(light, diffuse=emitted), facing, own)
        most = curve.max(axis=0)
        return np.where(most > 0, curve / np.maximum(most, 1e-9), 1).astype(np.float32)
    both = computed(emitted.shape, lambda some: light.diffuse[some].astype(np.float32) + emitted[some])
    curve, _ = fit_diffuse(replace(light, diffuse=both), facing, own)
    return cast(Floats, np.clip(curve, 0, _STEEPEST) * falloff[-1])


def _image(capture: LayeredSamples, shown: Floats, falloff: Floats, fine: Bools, glowing: Bools) -> Floats:
    """`Glow.image` of what texels show, (K, 3), of `glowing` materials (M,); of `fine` ones by their map."""
    plan, maps = capture.light.plan, capture.fine
    tall, wide = maps["emission"].shape[:2]
    of_texels = plan.placed(shown, gutter=True)

    def compute(some: slice) -> Floats:
        number = np.minimum(maps["material"][some, :, 0].astype(np.intp), len(falloff) - 1)
        found = maps["emission"][some] / np.maximum(falloff[number, -1], _FRONTAL)
        if not fine[glowing].all():
            rows, columns = np.mgrid[some, :wide]
            uv = np.stack([(columns + 0.5) / wide, (rows + 0.5) / tall], axis=-1).astype(np.float32)
            smooth = bilinear(of_texels, uv.reshape(-1, 2)).reshape(found.shape)
            smooth = smooth if capture.alpha is None else smooth * capture.alpha[some]
            found = np.where(fine[number][..., None], found, smooth)
        return np.where(glowing[number][..., None], found, 0).astype(np.float32)

    return large_arrays.from_blocks(tall, compute, max(1, _TEXELS // wide))


def _was_folded(capture: LayeredSamples, known: Known, number: int) -> bool:
    """Whether the colours of a bake that is `known` are not the surface's own where a material glows.

    Anywhere in the material, where it emits nothing along the normal, as at a rim.
    """
    own, colour = capture.fine, known.atlas.colour
    if colour.shape != own["diffuse"].shape:
        return False
    every, glowing = np.zeros((2, 2))  # what is off, and how many texels: all, and those that glow
    for some in blocks(len(colour), max(1, _TEXELS // colour.shape[1])):
        here = own["material"][some, :, 0] == number
        off = np.abs(colour[some] - own["diffuse"][some]).max(axis=2)
        every += off[here].sum(), here.sum()
        here &= own["emission"][some].any(axis=2)
        glowing += off[here].sum(), here.sum()
    off_by, count = glowing if glowing[1] else every
    return bool(off_by > _OTHER * count)


def _cosine(light: LightSamples, some: Some) -> Floats:
    """N.V of some texels' samples, (k, S) float32."""
    found = np.maximum(square_to_direction(light.square[some])[..., 2], 0)
    return cast(Floats, found.astype(np.float32))


def _squares(
    values: Floats, facing: Floats, found: Floats, falloff: Floats, material: Ints
) -> tuple[Floats, Floats]:
    """The squares of samples (K, S, 3), and of what differs from `found` (K, 3) times falloffs: (K,) each."""

    def sums(some: slice) -> Floats:
        used = facing[some] > 0
        curve = falloff_at(falloff, np.repeat(material[some], used.shape[1]), facing[some].ravel())
        seen = values[some].astype(np.float32) * used[..., None]
        off = seen - found[some, None] * curve.reshape(*used.shape, 3) * used[..., None]
        return np.stack([(part * part).sum(axis=(1, 2), dtype=np.float64) for part in (seen, off)])

    whole, left = np.concatenate(in_blocks(sums, len(values), values.shape[1]), axis=1)
    return whole, left
