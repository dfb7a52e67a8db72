# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's lobes and falloffs by N.V, as they are looked up; and what a lobe sees past the object.

How much lobes mirror is a table by N.V. Where a material's glossy colour and roughness vary, it tells what is
missing of `reflectance`, which both tell of: a table times the colour alone would make rough paint as bright
at its rim as polished metal beside it.

Kept is a picture of what the object leaves free, blurred by its cells and by buckets that are pooled. A sharp
lobe needs a sharper edge: where the edge is straight, blurring a half-space by a lobe of another width
changes F(d / s) into F(d / t), where F(x) = 1/2 + x / (2 sqrt(2 + x²)).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from ....core.arrays import Floats, Ints

_KEPT = 5.0  # the blur of the kept mask, pooled over buckets, times its cells along a side, radians
_EDGE = 0.04  # the sharpest edge that is shown, radians: cells do not tell where it is any better
SATURATION = 5.0  # of the width² of rough surfaces: see `capture.gloss_maps.width_of`
_LEAST_WEIGHT = 1e-9
SHADOWED = 50.0  # one over the least glossy colour of what is no shadow
_LEAST_LENGTH = 1e-6  # of a vector that has a direction
LEAST_TANGENT = 0.1  # length of a tangent that is known: textures hold 0 a little off
LOWEST = 0.01  # the sine above the surface of the lowest mirror direction, as in Cycles
LOBES = 2
STEPS = 16  # of N.V


def falloff_at(falloff: Floats, material: Ints, cosine: Floats) -> Floats:
    """The falloffs (M, B, 3) of materials (N,) at N.V (N,), linear between their points: (N, 3)."""
    count = falloff.shape[1]
    own = np.minimum(material, len(falloff) - 1)
    place = np.clip(cosine * count - 0.5, 0, count - 1)
    low = np.minimum(place.astype(np.intp), count - 2)
    part = (place - low)[:, None].astype(falloff.dtype)
    return cast(Floats, falloff[own, low] * (1 - part) + falloff[own, low + 1] * part)


@dataclass(frozen=True, eq=False)
class Gloss:
    """What the tints and widths of a material's places are relative to.

    `colour` (3,): the mean glossy colour along the normal, linear; `width`: log2 of the width² where lobes
    are as wide as the material's.
    """

    colour: Floats
    width: float


@dataclass(frozen=True, eq=False)
class Material:
    """One material's lobes at N.V = (k + 0.5) / STEPS: `weight` (LOBES, STEPS, 3), `variance` (LOBES, STEPS).

    `bend` (STEPS,): by how much their axis leaves the mirror direction for the normal, radians. Weights are
    multiplied by the tint of a place, or with `gloss` by the `reflectance` that follows from it. `brush`: of
    anisotropic metal, which has one lobe, the width² along the tangent and across it, seen along the normal:
    lamps are seen by `Brushed`.
    """

    weight: Floats
    variance: Floats
    bend: Floats
    gloss: Gloss | None = None
    brush: tuple[float, float] | None = None

    def at(self, cosine: Floats) -> tuple[Floats, Floats, Floats]:
        """Weights (LOBES, 3, N), variances (LOBES, N) and bends (N,) at N.V (N,)."""
        place = np.clip(cosine * STEPS - 0.5, 0, STEPS - 1)
        low = np.minimum(place.astype(np.intp), STEPS - 2)
        above = (place - low).astype(np.float32)

        def between(table: Floats) -> Floats:
            return cast(Floats, table.take(low, axis=-1) * (1 - above) + table.take(low + 1, axis=-1) * above)

        weight = between(np.moveaxis(self.weight, 2, 1))
        return weight, np.exp(between(np.log(self.variance))), between(self.bend)

    def mean_variance(self, cosine: Floats) -> Floats:
        """The mean of both lobes' variances, by weight, at N.V (N,): (N,)."""
        weight, variance, _ = self.at(cosine)
        bright = weight.sum(axis=1) + _LEAST_WEIGHT
        return cast(Floats, (bright * variance).sum(axis=0) / bright.sum(axis=0))


def reflectance(colour: Floats, width: Floats, cosine: Floats, alpha: Floats | float = 1.0) -> Floats:
    """What a glossy surface reflects of white surroundings at N.V (N,): (N, 3) float32.

    `colour` (N, 3): what it reflects along its normal; `width` (N,): its lobe's width², of which its
    roughness follows. The colour is premultiplied by `alpha` (N,), and so is what is returned: F A + B, with
    A and B by N.V and roughness (Karis, "Physically Based Shading on Mobile", 2014, after Lazarov, "Getting
    More Physical in Call of Duty: Black Ops II", 2013), and the reflectance F of facets that makes it
    `colour` at N.V = 1.
    """
    squared = width / np.maximum(2 - SATURATION * width, _LEAST_WEIGHT)
    rough = np.minimum(squared, 1) ** 0.25
    scale, offset = _environment(rough, np.clip(cosine, 0, 1))
    facing, bare = _environment(rough, 1.0)
    white = np.broadcast_to(np.asarray(alpha, dtype=np.float32), rough.shape)
    facets = np.maximum(colour - (white * bare)[:, None], 0) / facing[:, None]
    glossy = np.minimum(SHADOWED * colour.max(axis=1), white)  # facets of less are no surface, but shadow
    return cast(Floats, (facets * scale[:, None] + (glossy * offset)[:, None]).astype(np.float32))


def _environment(rough: Floats, cosine: Floats | float) -> tuple[Floats, Floats]:
    """Karis's factor A and addend B, (N,) both."""
    smooth, left = 1 - rough, 0.0425 - 0.0275 * rough
    grazing = np.minimum(smooth * smooth, np.exp2(-9.28 * cosine)) * smooth + left
    return 1.04 - 0.572 * rough - 1.04 * grazing, 0.022 * rough - 0.04 + 1.04 * grazing


def shown_at(
    materials: Sequence[Material],
    material: Ints,
    cosine: Floats,
    tint: Floats,
    width: Floats,
    alpha: Floats | float = 1.0,
) -> Floats:
    """What lobes of materials (N,) are multiplied by at N.V (N,): (N, 3) float32.

    `tint` (N, 3), premultiplied by `alpha` (N,), and `width` (N,), what lobes' width² is multiplied by there.
    """
    shown = np.array(tint, dtype=np.float32)
    for number, one in enumerate(materials):
        some = np.flatnonzero(material == number) if one.gloss is not None else ()
        if one.gloss is not None and len(some):
            colour = tint[some] * one.gloss.colour
            wide = (width[some] * np.float32(2**one.gloss.width)).astype(np.float32)
            white = alpha[some] if isinstance(alpha, np.ndarray) else alpha
            shown[some] = reflectance(colour, wide, cosine[some], white)
    return shown


def lobe(squared: Floats, variance: Floats) -> Floats:
    """The lobe of a width² at squared chords from its axis, per steradian.

    GGX (Walter et al., 2007) mirrored at normal incidence, with a width² of 2 a² / (1 - a²): in the plane it
    is Student's distribution with two degrees of freedom.
    """
    return (1 + variance / 2) / (2 * np.pi * variance) / (1 + squared / (2 * variance)) ** 2


@dataclass(frozen=True, eq=False)
class Brushed:
    """How N places of anisotropic metal spread what they mirror: GGX with two roughnesses.

    Unit `viewer`, `normal` and `tangent` (3, N), this one across the normal; `along` and `across` (N,): the
    lobe's width² along the tangent and across it. Where the tangent is not known it is 0, and both are alike.
    """

    viewer: Floats
    normal: Floats
    tangent: Floats
    along: Floats
    across: Floats

    @classmethod
    def of(cls, axis: Floats, normal: Floats, tangent: Floats, along: Floats, across: Floats) -> Brushed:
        """Of mirror directions, normals and tangents (N, 3), the last ones in any direction.

        Those shorter than LEAST_TANGENT across the normal are not known: the metal is as rough as before, but
        round.
        """
        axis, normal, tangent = axis.T, normal.T, tangent.T
        viewer = 2 * (axis * normal).sum(axis=0) * normal - axis
        tangent = tangent - (tangent * normal).sum(axis=0) * normal
        length = _length(tangent)
        known = length > LEAST_TANGENT
        tangent = np.where(known, tangent / np.maximum(length, LEAST_TANGENT), 0)
        alike = np.sqrt(along * across)
        return cls(viewer, normal, tangent, np.where(known, along, alike), np.where(known, across, alike))

    def towards(self, way: Floats, size: Floats) -> Floats:
        """The lobe in unit directions (3, N), per steradian, blurred by a width² `size` (N,): (N,).

        The density of what is mirrored by the facets that the viewer sees: D G1 / (4 N.V) (Heitz, "Sampling
        the GGX Distribution of Visible Normals", 2018, equation 2, and Walter et al., 2007, equation 14).
        """
        half = self.viewer + way
        half = half / np.maximum(_length(half), _LEAST_LENGTH)
        upright = np.maximum((half * self.normal).sum(axis=0), 1e-3)
        aside = (half * self.tangent).sum(axis=0) / upright
        flat = np.maximum(1 / (upright * upright) - 1 - aside * aside, 0)
        along, across = (self.along + size) / 2, (self.across + size) / 2
        tail = 1 + aside * aside / along + flat / across
        facets = 1 / (np.pi * np.sqrt(along * across) * (tail * upright * upright) ** 2)
        cosine = np.maximum((self.viewer * self.normal).sum(axis=0), 1e-3)
        slant = (self.viewer * self.tangent).sum(axis=0) ** 2
        rough = self.across * np.maximum(1 - cosine * cosine - slant, 0) + self.along * slant
        seen = 2 / (cosine + np.sqrt(cosine * cosine + rough / 2))  # G1 / N.V
        above = (way * self.normal).sum(axis=0) > 0
        return cast(Floats, (above * facets * seen / 4).astype(np.float32))


def _length(vectors: Floats) -> Floats:
    return cast(Floats, np.sqrt((vectors * vectors).sum(axis=0)))


def lifted(axis: Floats, face: Floats) -> Floats:
    """Mirror directions (3, ...) about shading normals that turn them below the surface, raised onto it.

    `face` (3, ...): the mesh's normals. Cycles turns such shading normals until what is mirrored is above the
    surface (`ensure_valid_specular_reflection`); float32.
    """
    raised = axis + np.maximum(LOWEST - (axis * face).sum(axis=0), 0) * face
    raised /= np.sqrt((raised * raised).sum(axis=0))
    return cast(Floats, raised.astype(np.float32, copy=False))


def bent(axis: Floats, normal: Floats, bend: Floats) -> Floats:
    """Axes (N, 3) turned by so many radians (N,) towards the normal."""
    aside = towards(axis, normal)
    return cast(Floats, (axis.T * np.cos(bend) + aside.T * np.sin(bend)).astype(np.float32).T)


def towards(axis: Floats, normal: Floats) -> Floats:
    """Unit vectors (N, 3) across the axes, in their plane with the normal."""
    axis, normal = axis.T, normal.T
    towards = normal - (normal * axis).sum(axis=0) * axis
    return cast(Floats, (towards / np.maximum(np.linalg.norm(towards, axis=0), 1e-6)).T)


def seen_free(kept: Floats, variance: Floats, cells: int) -> Floats:
    """The kept mask (N,) as a lobe of widths² (N,) sees it: (N,)."""
    sharper = np.maximum(_KEPT / cells / np.sqrt(variance + _EDGE**2), 1)
    place = np.clip(2 * kept - 1, -1, 1) * sharper
    return cast(
        Floats, (0.5 + 0.5 * place / np.sqrt(1 - (place / sharper) ** 2 + place**2)).astype(np.float32)
    )
